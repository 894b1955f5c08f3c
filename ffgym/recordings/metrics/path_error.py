"""Deviation of the tool from a circle, and of motors from their references: thesis 2.2.5, quantities 1-4."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError, check_class, check_shape
from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.recordings import Phase, Recording

_ROUNDNESS = 1e-3
"""Largest deviation of a reference from a circle, in units of its radius, that still counts as one."""

_SMALLEST = 1e-9
"""Smallest radius of a circle [m]; below it points are one point."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Circle:
    """A circle in space."""

    centre: Array
    """[m], shape (3,)."""
    normal: Array
    """Unit normal of its plane, shape (3,)."""
    radius: float
    """[m]."""


@dataclass(frozen=True, kw_only=True)
class PathError:
    """Deviation of the TCP from one circle [m]: in its plane (as the thesis plots), and in space."""

    label: str
    radius: float
    """Radius of the circle [m]."""
    speed: float
    """TCP speed of the reference on the circle [m/s]."""
    rms: float
    """Root mean square in the plane (2.17)."""
    max: float
    """Largest deviation in the plane."""
    rms_3d: float
    """Root mean square of the distance in space."""
    max_3d: float
    """Largest distance in space."""


def path_errors(recording: Recording) -> list[PathError]:
    """Compute the path error of every circle of a recording; lead-in and lead-out do not count.

    The deviation is the distance to the nearest point of the circle: a tool that runs late on the right path makes no
    error. (Our reading of "path error"; the thesis does not say how it pairs measured and reference points.) The offset
    between TCP and its reference at the first standstill (gravity sag, tracker frame) is removed before.

    Raises:
        FFGymError: if the recording has no TCP, no standstill before its first circle, or no circle.
    """
    check_class("recording", recording, Recording, "read_recording makes one")
    circles = recording.phases_of("circle")
    if not circles:
        raise FFGymError(f"Recording {recording.header.segment!r} has no phase of kind 'circle' to score.")
    tcp, errors = recording.vector("tcp.position") - standstill_offset(recording), []
    for phase in circles:
        circle, outward, height = _deviations(recording, phase, tcp)
        distance = np.hypot(outward, height)
        errors.append(
            PathError(
                label=phase.label,
                radius=circle.radius,
                speed=2 * np.pi * circle.radius / (phase.end - phase.start),
                rms=rms(outward),
                max=float(np.abs(outward).max()),
                rms_3d=rms(distance),
                max_3d=float(distance.max()),
            )
        )
    return errors


def standstill_offset(recording: Recording) -> Array:
    """Compute the mean of TCP minus reference while the robot first stands still [m], shape (3,).

    Raises:
        FFGymError: if the recording does not begin with a standstill, or has no TCP position there.
    """
    rests = recording.phases_of("standstill")
    circles = recording.phases_of("circle")
    if not rests or (circles and rests[0].start > circles[0].start):
        raise FFGymError(
            f"Recording {recording.header.segment!r} has no standstill before its first circle, so the offset of the "
            f"TCP cannot be removed. Record at least 0.1 s of rest first and mark it as a phase of kind 'standstill'."
        )
    away = (recording.vector("tcp.position") - recording.vector("tcp_reference.position"))[recording.during(rests[0])]
    return np.asarray(_seen(away, rests[0], recording).mean(axis=0))


def circle_deviation(points: Array, circle: Circle) -> tuple[Array, Array]:
    """Compute deviations of points (T, 3) in the plane (outward > 0) and along the normal of a circle [m], (T,)."""
    arms = points - circle.centre
    height = arms @ circle.normal
    outward = np.linalg.norm(arms - height[:, None] * circle.normal, axis=1) - circle.radius
    return outward, height


def _seen(points: Array, phase: Phase, recording: Recording) -> Array:
    """Return rows of `points` (T, 3) of a phase that the tracker has seen."""
    seen = points[~np.isnan(points).any(axis=1)]
    if len(seen) == 0:
        raise FFGymError(f"Recording {recording.header.segment!r} has no TCP position in {phase.kind} {phase.label!r}.")
    return seen


def deviation_along(recording: Recording, phase: Phase, n: int) -> Array:
    """Compute the deviation in the plane (outward > 0) at `n` even times of a circle [m]; errors as `path_errors`."""
    tcp = recording.vector("tcp.position") - standstill_offset(recording)
    _, outward, _ = _deviations(recording, phase, tcp)
    return outward[np.linspace(0, len(outward) - 1, n).round().astype(np.int64)]


def _deviations(recording: Recording, phase: Phase, tcp: Array) -> tuple[Circle, Array, Array]:
    """Fit the circle of a phase, and return it with deviations in its plane and out of it [m] at seen samples."""
    rows = recording.during(phase)
    circle = fit_circle(recording.vector("tcp_reference.position")[rows])
    return circle, *circle_deviation(_seen(tcp[rows], phase, recording), circle)


def fit_circle(points: Array) -> Circle:
    """Fit a circle to `points` (T, 3) [m], T >= 4, by least squares.

    Raises:
        FFGymError: if the points do not lie on a circle.
    """
    points = check_shape("circle points", points, (None, 3))
    if len(points) < 4:
        raise FFGymError(f"A circle needs at least 4 points, got {len(points)}; record faster than the circle runs.")
    # plane: its normal is the direction of least spread
    middle = points.mean(axis=0)
    centred = points - middle
    normal = np.linalg.eigh(centred.T @ centred)[1][:, 0]
    first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    flat = np.stack([(points - middle) @ first, (points - middle) @ second], axis=1)
    # circle in the plane: linear least squares in centre and rest = radius^2 - |centre|^2
    system = np.column_stack([2 * flat, np.ones(len(flat))])
    (x, y, rest), *_ = np.linalg.lstsq(system, (flat**2).sum(axis=1), rcond=None)
    radius = float(np.sqrt(rest + x * x + y * y))
    centre = middle + x * first + y * second
    distance = np.linalg.norm(points - centre, axis=1)
    worst = float(np.abs(distance - radius).max())
    if not (worst <= _ROUNDNESS * radius and radius > _SMALLEST):
        raise FFGymError(
            f"The reference is no circle: it deviates by {worst:.3g} m from the best one, of radius {radius:.3g} m."
        )
    return Circle(centre=centre, normal=normal, radius=radius)


def motor_error(recording: Recording) -> Array:
    """Compute the motor position error e = reference - measured, motor side [rad], shape (T, N).

    The reference is that of the program, without what a law corrects of set-points.
    """
    error = recording.joint_array("reference.position") - recording.joint_array("motor.position")
    if recording.has("correction.position"):
        error -= recording.joint_array("correction.position")
    return recording.header.motor_side(error)


def motor_error_rms(recording: Recording) -> Array:
    """Compute the RMS of the motor position error, motor side [rad], shape (N,), without standstill (thesis 4.3.2).

    Raises:
        FFGymError: if the recording is all standstill.
    """
    check_class("recording", recording, Recording, "read_recording makes one")
    moving = ~recording.mask(kind="standstill")
    if not moving.any():
        raise FFGymError(
            f"Recording {recording.header.segment!r} is all standstill, so it has no motor error to score."
        )
    return rms(motor_error(recording)[moving], 0)


def friction_miss(recording: Recording, rows: BoolArray | None = None) -> Array:
    """Compute RMS of friction minus added torque over RMS friction, motor side, shape (N,); 0 without friction.

    Args:
        recording: a simulated one, since machines do not measure their friction.
        rows: samples that count, shape (T,); None takes all but standstill.

    Raises:
        FFGymError: if the recording does not hold friction or added torque.
    """
    rows = ~recording.mask(kind="standstill") if rows is None else rows
    friction = recording.joint_array("friction.effort")[rows]
    added = recording.joint_array("compensation.effort")[rows]
    return relative_rms(friction - added, friction)


def relative_rms(difference: Array, whole: Array) -> Array:
    """Divide RMS of `difference` by RMS of `whole`, (T, N) each, per column, shape (N,); 0 where `whole` is 0."""
    size = rms(whole, 0)
    return np.asarray(np.divide(rms(difference, 0), size, out=np.zeros_like(size), where=size > 0))
