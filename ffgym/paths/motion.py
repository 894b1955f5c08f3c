"""A motion as a chain of segments that know their time law, and what comes out when it is sampled."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.effort import announce
from ffgym.core.errors import FFGymError, check_number
from ffgym.core.types import Array
from ffgym.recordings import Phase, PhaseKind

MAX_STEPS = 1e7
"""Longest motion [steps]: 11 h at 4 ms; beyond it a speed or a step is surely a slip, and memory runs out."""

Evaluate = Callable[[Array], tuple[Array, Array, Array]]
"""Position, velocity and acceleration, each (T, D), at times (T,) since the start of a segment."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Segment:
    """One piece of a motion."""

    label: str
    kind: PhaseKind
    duration: float
    """[s], > 0."""
    evaluate: Evaluate


@dataclass(frozen=True, kw_only=True, eq=False)
class CartesianPath:
    """Sampled TCP motion in the world frame.

    Where `rotation` is None the tool keeps one orientation, that of the work area; otherwise the angular quantities
    belong to it.
    """

    name: str
    t: Array
    """Times [s], uniform, from 0, shape (T,)."""
    position: Array
    """TCP [m], shape (T, 3)."""
    velocity: Array
    """TCP [m/s], shape (T, 3)."""
    acceleration: Array
    """TCP [m/s^2], shape (T, 3)."""
    phases: tuple[Phase, ...]
    rotation: Array | None = None
    """Orientation of tool0, shape (T, 3, 3)."""
    angular_velocity: Array | None = None
    """Angular velocity of tool0 [rad/s], in world axes, shape (T, 3)."""
    angular_acceleration: Array | None = None
    """Angular acceleration of tool0 [rad/s^2], in world axes, shape (T, 3)."""

    def __post_init__(self) -> None:
        turning = (self.rotation, self.angular_velocity, self.angular_acceleration)
        if len({part is None for part in turning}) > 1:
            raise FFGymError(
                f"Path {self.name!r}: rotation, angular_velocity and angular_acceleration belong together."
            )


@dataclass(frozen=True, kw_only=True, eq=False)
class JointPath:
    """Sampled motion of the joints, link side; a sliding joint has m in place of rad."""

    name: str
    t: Array
    """Times [s], uniform, from 0, shape (T,)."""
    q: Array
    """[rad], shape (T, N)."""
    dq: Array
    """[rad/s], shape (T, N)."""
    ddq: Array
    """[rad/s^2], shape (T, N)."""
    phases: tuple[Phase, ...]


def standstill(label: str, point: Array, duration: float) -> Segment:
    """Rest at `point`, shape (D,), for `duration` [s]."""
    point = np.asarray(point, dtype=np.float64)

    def evaluate(tau: Array) -> tuple[Array, Array, Array]:
        rest = np.zeros((len(tau), len(point)))
        return rest + point, rest.copy(), rest.copy()

    return Segment(label=label, kind="standstill", duration=duration, evaluate=evaluate)


def sample(segments: Sequence[Segment], dt: float) -> tuple[Array, Array, Array, Array, tuple[Phase, ...]]:
    """Times (T,), position, velocity, acceleration (T, D) every `dt` [s] from the start to the end, and the phases.

    Segments last as long as they last; only the whole motion is sampled on the grid, so that no speed is rounded.
    """
    dt = check_number("dt", dt, unit="s", low=0.0, open_low=True)
    with np.errstate(over="ignore"):  # an infinite number of steps is too many
        ends = np.cumsum([segment.duration for segment in segments])
        steps = ends[-1] / dt
    starts = np.concatenate([[0.0], ends[:-1]])
    if not 1 - 1e-9 <= steps <= MAX_STEPS:
        raise FFGymError(
            f"The motion lasts {ends[-1]:.6g} s, must be from one step of dt = {dt} s to {MAX_STEPS:g} of them."
        )
    announce(float(ends[-1]), "plan")
    count = int(np.ceil(steps - 1e-9)) + 1  # the last sample may lie up to one step beyond the end
    t = np.arange(count, dtype=np.float64) * dt
    which = np.minimum(np.searchsorted(ends, t, side="right"), len(segments) - 1)
    parts = [s.evaluate(t[which == i] - starts[i]) for i, s in enumerate(segments)]
    position: Array = np.concatenate([part[0] for part in parts])
    velocity: Array = np.concatenate([part[1] for part in parts])
    acceleration: Array = np.concatenate([part[2] for part in parts])
    phases = tuple(
        Phase(label=s.label, kind=s.kind, start=float(a), end=float(b))
        for s, a, b in zip(segments, starts, ends, strict=True)
    )
    return t, position, velocity, acceleration, phases
