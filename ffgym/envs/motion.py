"""Motion of an episode: a reference, and the rows of it that are looked up at every control step."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ffgym.control import CausalLaw, FeedForwardLaw, invert_servo, rigid_feedforward
from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array, BoolArray
from ffgym.paths import Reference
from ffgym.recordings import PHASE_KINDS, Phase
from ffgym.recordings.metrics import Circle, fit_circle
from ffgym.robot import RigidArm

SLOW = 1e-3
"""TCP speed [m/s] below which a path counts as straight: positions are known to 1e-10 m, so that curvatures computed
from samples every 4 ms are known to 25 1/m there, which does not matter over the 10 um that so slow a tool lags."""
CONCENTRIC = 1e-3
"""Distance of centres in radii, and angle between planes [rad], below which circles count as concentric; chosen: the
roundness that `metrics.fit_circle` demands of a circle."""


@dataclass(frozen=True, kw_only=True)
class MotionColumns:
    """Columns of a motion's rows; N joints, motor side unless said otherwise."""

    n_joints: int
    has_tcp: bool

    position: slice = field(init=False)
    """Reference [rad]."""
    velocity: slice = field(init=False)
    """Reference [rad/s]."""
    acceleration: slice = field(init=False)
    """Reference [rad/s^2]."""
    reference: slice = field(init=False)
    """Position, velocity and acceleration."""
    feedforward: slice = field(init=False)
    """Rigid feed-forward torque [N m]."""
    phase: int = field(init=False)
    """Index in PHASE_KINDS."""
    circle: int = field(init=False)
    """Number of the circle in the motion, from 0, with its leads; -1 between circles."""
    radius: int = field(init=False)
    """Radius [m] on a circle, 0 elsewhere."""
    share: int = field(init=False)
    """Share of the sample in the mean square error of its circle, or of the motion if it has none; 0 where errors do
    not count."""
    base: slice = field(init=False)
    """Torque of the base law [N m], or its correction of set-points [rad]."""
    base_error: slice = field(init=False)
    """Errors that the base law asks for, position [rad] and speed [rad/s]."""
    tcp: slice = field(init=False)
    """TCP of a rigid arm on the reference [m]; no columns for a robot without tool."""
    anchor: slice = field(init=False)
    """Point from which deviations of the TCP count [m]: the centre of a circle, elsewhere the TCP on the reference."""
    axis: slice = field(init=False)
    """Direction in which they do not count: normal of a circle's plane, elsewhere that of motion, zero at rest."""
    bend: slice = field(init=False)
    """Curvature of its path [1/m], towards the centre; zero where deviations count in a circle's plane."""

    def __post_init__(self) -> None:
        n = self.n_joints
        one, wide = 4 * n, 3 if self.has_tcp else 0
        tcp = one + 4 + 3 * n
        for name, value in {
            "position": slice(0, n),
            "velocity": slice(n, 2 * n),
            "acceleration": slice(2 * n, 3 * n),
            "reference": slice(0, 3 * n),
            "feedforward": slice(3 * n, one),
            "phase": one,
            "circle": one + 1,
            "radius": one + 2,
            "share": one + 3,
            "base": slice(one + 4, one + 4 + n),
            "base_error": slice(one + 4 + n, tcp),
            "tcp": slice(tcp, tcp + wide),
            "anchor": slice(tcp + wide, tcp + 2 * wide),
            "axis": slice(tcp + 2 * wide, tcp + 3 * wide),
            "bend": slice(tcp + 3 * wide, tcp + 4 * wide),
        }.items():
            object.__setattr__(self, name, value)

    @cached_property
    def geometry(self) -> slice:
        """Anchor, axis and bend."""
        return slice(self.anchor.start, self.bend.stop)

    @property
    def width(self) -> int:
        """Number of columns."""
        return self.bend.stop


@dataclass(frozen=True, kw_only=True, eq=False)
class EpisodeMotion:
    """Motion that one episode follows."""

    reference: Reference
    arm: RigidArm
    """Rigid dynamics of the controller's nominal robot."""
    task: dict[str, Any]
    """Options that define it, e.g. position, speed and radii."""
    in_space: bool = False
    """True: deviations from circles count in space, like those from any path. False: in the plane of the circles."""
    is_practice: bool = False
    """True if nothing of it is rewarded or scored."""

    @property
    def name(self) -> str:
        """Name of the motion."""
        return self.reference.name

    @property
    def label(self) -> str:
        """Name of the motion with the radii of its circles."""
        radii = self.task.get("radii")
        return self.name if radii is None else f"{self.name}, {' '.join(f'{radius * 1e3:g}' for radius in radii)} mm"

    @property
    def n_steps(self) -> int:
        """Control steps from its first sample to its last."""
        return len(self.reference.t) - 1

    @cached_property
    def columns(self) -> MotionColumns:
        """Columns of `rows`."""
        robot = self.reference.robot
        return MotionColumns(n_joints=robot.n_joints, has_tcp=robot.tool is not None)

    @cached_property
    def plane(self) -> tuple[Array, Array]:
        """Centre and unit normal of the circles, shape (3,) each; zero without circles, or where they share neither."""
        fits = list(self._circles.values())
        last = fits[-1] if fits else None
        nowhere = np.zeros(3), np.zeros(3)
        if last is None:
            return nowhere
        for circle in fits:  # all about the same centre, in the same plane, but for rounding
            if circle is None or np.linalg.norm(np.cross(circle.normal, last.normal)) > CONCENTRIC:
                return nowhere
            if np.linalg.norm(circle.centre - last.centre) > CONCENTRIC * max(circle.radius, last.radius):
                return nowhere
        return last.centre, last.normal

    @cached_property
    def _circles(self) -> dict[Phase, Circle | None]:
        """Circles of the phases of that kind."""
        return {phase: self._circle(phase) for phase in self.reference.phases if phase.kind == "circle"}

    def _circle(self, phase: Phase) -> Circle | None:
        """Fit the circle of a phase; None if its ends are rounded, as in a program, and deviations count in space."""
        try:
            return fit_circle(self.arm.tcp_position(self.reference.q[self._within(phase)]))
        except FFGymError:
            if self.in_space:
                return None
            raise

    def _within(self, phase: Phase) -> BoolArray:
        """Mark the samples of a phase, shape (T,)."""
        return (self.reference.t >= phase.start) & (self.reference.t < phase.end)

    def rows(self, padding: int, base: FeedForwardLaw | None = None, *, corrects: bool = False) -> Array:
        """Compute one row per sample, and copy the last one `padding` times; shape (T + padding, W).

        Args:
            padding: number of copies of the last row.
            base: law whose torque is added at every sample; None adds nothing.
            corrects: True for the correction of set-points that makes the servo give this torque.
        """
        reference, at = self.reference, self.columns
        rows = np.zeros((len(reference.t), at.width))
        rows[:, at.position] = reference.motor_q
        rows[:, at.velocity] = reference.motor_dq
        rows[:, at.acceleration] = reference.motor_ddq
        rows[:, at.feedforward] = rigid_feedforward(self.arm, reference)
        self._write_phases(rows)
        _write_shares(rows, at)
        if base is not None:
            name = f"torque of feed-forward law {base.name!r}"
            torque = check_shape(name, base.torque(reference), reference.q.shape)
            rows[:, at.base] = invert_servo(reference.robot.servo, torque) if corrects else torque
            if isinstance(base, CausalLaw):
                rows[:, at.base_error] = np.hstack(base.own_errors(reference))
        if at.has_tcp:
            rows[:, at.tcp] = tcp = self.arm.tcp_position(reference.q)
            (centre, normal), on_circle = self.plane, rows[:, at.radius, None] > 0
            rows[:, at.anchor] = np.where(on_circle, centre, tcp)
            rows[:, at.axis] = np.where(on_circle, normal, _directions(tcp))
            if self.in_space:
                rows[:, at.bend] = _bends(tcp, reference.robot.servo.control_dt)
        return np.pad(rows, ((0, padding), (0, 0)), mode="edge")

    def _write_phases(self, rows: Array) -> None:
        """Write phase, number of the circle and radius into rows."""
        reference, at = self.reference, self.columns
        rows[:, at.phase] = PHASE_KINDS.index("motion")
        rows[:, at.circle] = -1.0
        circle, before, in_plane = -1, "", not self.in_space and np.any(self.plane[1])
        for phase in reference.phases:
            on = self._within(phase)
            if phase is reference.phases[-1]:
                on |= reference.t >= phase.end  # the last sample closes the motion
            rows[on, at.phase] = PHASE_KINDS.index(phase.kind)
            circle += phase.kind == "lead_in" or (phase.kind == "circle" and before != "lead_in")
            before = phase.kind
            if phase.kind in ("lead_in", "circle", "lead_out"):
                rows[on, at.circle] = circle
            circle_here = self._circles.get(phase)
            if circle_here is not None and in_plane:
                rows[on, at.radius] = circle_here.radius


def _write_shares(rows: Array, at: MotionColumns) -> None:
    """Write the share of each sample in the score: those on circles count if there are any, else all that move."""
    scored, circle = PHASE_KINDS.index("circle"), rows[:, at.circle]
    if not np.any(rows[:, at.phase] == scored):
        scored, circle = PHASE_KINDS.index("motion"), np.zeros(len(rows))
    counts = rows[:, at.phase] == scored
    for one in np.unique(circle[counts]):
        own = counts & (circle == one)
        rows[own, at.share] = 1 / own.sum()


def _directions(points: Array) -> Array:
    """Compute the unit direction of motion at each of the points (T, 3) [m], zero where they rest."""
    step = np.gradient(points, axis=0)
    length = np.linalg.norm(step, axis=1, keepdims=True)
    return np.divide(step, length, out=np.zeros_like(step), where=length > 1e-9)


def _bends(points: Array, dt: float) -> Array:
    """Compute the curvature [1/m] at points (T, 3) [m], sampled every `dt` [s]; zero where they are slow."""
    velocity = np.gradient(points, dt, axis=0)
    square = (velocity**2).sum(axis=1, keepdims=True)
    acceleration = np.zeros_like(points)
    acceleration[1:-1] = (points[2:] - 2 * points[1:-1] + points[:-2]) / dt**2
    along = (acceleration * velocity).sum(axis=1, keepdims=True)
    slow = square < SLOW**2
    across = acceleration - np.divide(along, square, out=np.zeros_like(along), where=~slow) * velocity
    return np.divide(across, square, out=np.zeros_like(across), where=~slow)
