"""Sensors of a course: encoders, currents and a tracker, with noise of several kinds, in columns by choice."""

from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from ffgym.core.types import Array
from ffgym.recordings import Recording
from ffgym.robot.description import RobotDescription, log_header
from scripts.exam.independent.arm import Bodies, pose_of, tool_of

Noise = Literal["white", "coloured", "quiet"]
NOISES: tuple[Noise, ...] = get_args(Noise)
"""Kinds of noise: independent from row to row; with a memory of some milliseconds; a tenth of the others."""

ANGLE_NOISE = 2e-5
"""Noise of a motor's angle [rad], standard deviation; chosen: a step of 17 bit over sqrt 12."""

TORQUE_NOISE = 0.02
"""Noise of currents, as a share of the Coulomb torque; chosen."""

TOOL_NOISE = 2e-5
"""Noise of a tracker, each axis [m]; chosen: laser trackers over some metres."""

QUIET = 0.1
"""Noise of quiet sensors over that of others."""

_QUIET_STEPS = 2.0**24
"""Steps of a turn of quiet encoders."""

_MEMORY = 0.006
"""Time constant of coloured noise [s]; chosen: filters of drives."""


@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """Errors with which the tracker sees the tool; nothing by default."""

    offset: Array = field(default_factory=lambda: np.zeros(3))
    """Offset of the reflector, in the axes of the flange [m]."""
    shift: Array = field(default_factory=lambda: np.zeros(3))
    """Displacement of the tracker's frame [m]."""
    turn: Array = field(default_factory=lambda: np.zeros(3))
    """Rotation of the tracker's frame, as a rotation vector [rad]."""
    latency: float = 0.0
    """Age of positions [s]."""


@dataclass(frozen=True, kw_only=True)
class Columns:
    """Columns of a log beside angles and torques of the motors."""

    tracker: bool
    set_points: bool
    feedback: bool
    speed: bool
    temperature: bool


def track(bodies: Bodies, q: Array, view: View, dt: float) -> Array:
    """Positions (T, B, 3) of the tool along joint positions (T, B, N), as a tracker sees them without noise."""
    if view.latency:
        t = np.arange(len(q)) * dt
        flat = q.reshape(len(q), -1)
        q = np.stack([np.interp(t - view.latency, t, column) for column in flat.T], axis=1).reshape(q.shape)
    turn, found = Rotation.from_rotvec(view.turn).as_matrix().T, []
    for row in q:
        pose = pose_of(bodies, row)
        reflector = tool_of(bodies, pose) + pose.rotation[:, -1] @ bodies.tool_rotation @ view.offset
        found.append(reflector @ turn + view.shift)
    return np.stack(found)


@dataclass(frozen=True, kw_only=True, eq=False)
class Exact:
    """Readings of sensors without noise along the motions of one machine; shape (T, M, N), or (T, M, 3) of the tool."""

    dt: float
    angle: Array
    speed: Array
    torque: Array
    ahead: Array
    set_point: Array
    set_speed: Array
    tool: Array
    temperature: Array


def record_log(
    robot: RobotDescription,
    exact: Exact,
    *,
    columns: Columns,
    noise: Noise,
    started: Array,
    current_offset: Array,
    rng: np.random.Generator,
) -> list[Recording]:
    """Recordings of motions as sensors log them."""
    length, motions, n = exact.angle.shape
    size, dt = QUIET if noise == "quiet" else 1.0, exact.dt
    step = 2 * np.pi / (_QUIET_STEPS if noise == "quiet" else 2.0**robot.sensors.encoder_bits)

    def noisy(values: Array, sigma: float | Array) -> Array:
        return np.asarray(values + size * sigma * _drawn(values.shape, noise, dt, rng))

    recordings = []
    for m in range(motions):
        angle = np.round(noisy(exact.angle[:, m], ANGLE_NOISE) / step) * step
        torque = noisy(exact.torque[:, m], TORQUE_NOISE * robot.friction.coulomb) + current_offset
        tool = noisy(exact.tool[:, m], TOOL_NOISE)
        families = {"motor.position": angle, "motor.effort": torque}
        if columns.speed:
            families["motor.velocity"] = np.gradient(angle, dt, axis=0)
        if columns.set_points:
            families["reference.position"] = exact.set_point[:, m]
            families["reference.velocity"] = exact.set_speed[:, m]
        if columns.feedback:
            families["feedforward.effort"] = exact.ahead[:, m]
            families["feedback.effort"] = torque - current_offset - exact.ahead[:, m]
        if columns.temperature:
            families["temperature"] = exact.temperature[:, m] + 0.1 * rng.standard_normal((length, n))
        if columns.tracker:
            families["tcp.position"] = tool
        found: dict[str, Array] = {"timestamp": np.arange(length, dtype=np.float64) * dt}
        for name, values in families.items():
            parts = "xyz" if name == "tcp.position" else robot.joints
            found |= {f"{name}.{part}": column for part, column in zip(parts, values.T, strict=True)}
        header = log_header(robot, f"motion_{m + 1}", "sampled")
        header.meta["session_start"] = float(started[m])
        recordings.append(Recording(columns=found, header=header))
    return recordings


def _drawn(shape: tuple[int, ...], noise: Noise, dt: float, rng: np.random.Generator) -> Array:
    """Noise of unit standard deviation along the first axis."""
    white = rng.standard_normal(shape)
    if noise != "coloured":
        return white
    keep = np.exp(-dt / _MEMORY)
    start = keep * rng.standard_normal((1, *shape[1:]))
    fresh = np.sqrt(1 - keep**2)
    return np.asarray(lfilter([fresh], [1.0, -keep], white, axis=0, zi=start)[0])
