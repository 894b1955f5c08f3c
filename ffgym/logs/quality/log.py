"""A recording as the checks look at it: link-side motion, speeds, and what is at rest, each computed once."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy

from ffgym.core.types import Array, BoolArray
from ffgym.logs.quality.signals import TINY, average, estimate_noise_by_differences
from ffgym.recordings import FAMILIES, Recording
from ffgym.recordings.schema import VALID
from ffgym.robot import RigidArm, RobotDescription

SMOOTHING = 0.02
"""Time [s] over which positions are averaged before they are differentiated: short beside planned motion, long beside
the quantisation of encoders at 1 kHz."""

_LONGER = (1.0, 2.0, 4.0, 8.0)
"""Multiples of `SMOOTHING` that are tried until accelerations are no noise."""

_NOISY = 0.3
"""Noise of the accelerations of a typical joint, in what is measured of them, from which on positions are averaged over
a longer time."""

EXCITED = 1e-3
"""Travel [rad or m, link side] from which on a joint counts as moved: some hundred steps of a motor encoder, and more
than gearboxes give way under a load that others move."""

RESTING = 0.02
"""Share of the largest speed of a joint below which it rests."""

MOTION_FAMILIES = (
    *("motor.position", "motor.velocity", "link.position", "link.velocity"),
    *("reference.position", "reference.velocity", "reference.acceleration"),
)
"""Families that say how joints move."""


TORQUES = ("motor.effort", "command.effort", "feedback.effort", "feedback.integral")
"""Families of torques, which may be cut at their extremes."""


class NotJudgedError(Exception):
    """Raised by a check that the columns of a recording give no answer to; the text is the reason."""


@dataclass(frozen=True, eq=False)
class CheckedLog:
    """One recording, and the robot it is said to be of."""

    recording: Recording
    robot: RobotDescription | None = None

    @property
    def t(self) -> Array:
        """[s], shape (T,)."""
        return self.recording.t

    @property
    def dt(self) -> float:
        """Median sample time [s]."""
        return self.recording.dt

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints."""
        return self.recording.header.joints

    @property
    def is_described(self) -> bool:
        """Tell whether the robot is given, and has as many joints as the recording."""
        return self.robot is not None and self.robot.n_joints == len(self.joints)

    @property
    def families(self) -> tuple[str, ...]:
        """Families of the schema that are present; a mask is none that is judged."""
        return tuple(name for name in self.recording.families if name in FAMILIES and name != VALID)

    def columns(self, family: str) -> dict[str, Array]:
        """Columns of a family by name, those of joints that lack the sensor left out."""
        there, names = self.recording.columns, FAMILIES[family].columns(self.joints)
        return {name: there[name] for name in names if name in there}

    def joint_columns(self, families: tuple[str, ...]) -> Iterator[tuple[str, int, str, Array]]:
        """Family, joint number, name and values of all per-joint columns of `families` that are present."""
        for family in families:
            if self.recording.has(family):
                for name, values in self.columns(family).items():
                    yield family, self.joints.index(name.removeprefix(f"{family}.")), name, values

    def joint_of(self, column: str) -> str:
        """Joint of a column; empty if it belongs to none."""
        part = column.rpartition(".")[2]
        return part if part in self.joints and not column.startswith("user.") else ""

    def rows(self, seconds: float) -> int:
        """Rows in a time span, one at least and no more than there are."""
        return max(1, round(min(seconds / self.dt, len(self.t))))

    def link_side(self, family: str) -> Array:
        """A family of `MOTION_FAMILIES` behind the gearbox [rad, rad/s, ... or m], shape (T, N)."""
        values, header = self.recording.joint_array(family), self.recording.header
        return values if family.startswith("link.") else header.joint_side(values)

    @cached_property
    def motions(self) -> dict[str, Array]:
        """All `MOTION_FAMILIES` brought to joint positions by integration, from 0 at the first row, (T, N) each."""
        found = {}
        for family in self.motion_families:
            values = self.link_side(family)
            for _ in range(("position", "velocity", "acceleration").index(family.rpartition(".")[2])):
                values = np.asarray(scipy.integrate.cumulative_trapezoid(values, self.t, axis=0, initial=0))
            found[family] = values - values[0]
        return found

    @cached_property
    def travel(self) -> dict[str, Array]:
        """Range of each of `motions`, (N,) each."""
        return {family: np.ptp(values, axis=0) for family, values in self.motions.items()}

    @cached_property
    def motion_families(self) -> tuple[str, ...]:
        """List the families of `MOTION_FAMILIES` that are present for all joints."""
        return tuple(name for name in MOTION_FAMILIES if len(self.columns(name)) == len(self.joints))

    @cached_property
    def arm(self) -> RigidArm:
        """The rigid arm of the robot; there must be one."""
        assert self.robot is not None
        return _arm_of(self.robot)

    @cached_property
    def _position_family(self) -> str:
        """Family that says where the joints are: measured, else set; empty if there is neither."""
        there = (f for f in ("motor.position", "link.position", "reference.position") if f in self.motion_families)
        return next(there, "")

    @property
    def has_positions(self) -> bool:
        """Tell whether the recording has positions of the joints; if not, they count as at rest in 0."""
        return bool(self._position_family)

    @cached_property
    def q(self) -> Array:
        """Joint positions, link side, shape (T, N)."""
        family = self._position_family
        return self.link_side(family) if family else np.zeros((len(self.t), len(self.joints)))

    @cached_property
    def angle_noise(self) -> Array:
        """White noise of `q` [rad or m, link side], shape (N,)."""
        return estimate_noise_by_differences(self.q)

    @cached_property
    def smoothing(self) -> float:
        """Time [s] over which positions are averaged: `SMOOTHING`, or longer where noise of angles calls for it."""
        for times in _LONGER:
            span = times * SMOOTHING
            moved = np.ptp(self.q, axis=0) > EXCITED
            dq = np.gradient(average(self.q, self.rows(span)), self.t, axis=0)
            ddq = np.gradient(average(dq, self.rows(span)), self.t, axis=0)
            size = np.std(ddq, axis=0)[moved]
            # two averages make a triangle, whose second derivative is three samples of noise over its width squared
            noise = np.sqrt(6) * self.angle_noise[moved] / max(span, self.dt) ** 2
            if not moved.any() or np.median(noise / np.maximum(size, TINY)) < _NOISY:
                return span
        return _LONGER[-1] * SMOOTHING

    @cached_property
    def smooth_q(self) -> Array:
        """`q`, averaged over `smoothing`."""
        return average(self.q, self.rows(self.smoothing))

    @cached_property
    def dq(self) -> Array:
        """Joint speeds from `smooth_q`, link side, shape (T, N)."""
        return np.gradient(self.smooth_q, self.t, axis=0)

    @cached_property
    def ddq(self) -> Array:
        """Joint accelerations from `dq`, averaged again, link side, shape (T, N)."""
        return np.gradient(average(self.dq, self.rows(self.smoothing)), self.t, axis=0)

    @cached_property
    def excited(self) -> BoolArray:
        """Joints that move, shape (N,)."""
        return np.ptp(self.smooth_q, axis=0) > EXCITED

    @cached_property
    def moving(self) -> BoolArray:
        """Mark the rows in which each joint moves, shape (T, N); joints that are not excited never do."""
        speed = np.abs(self.dq)
        return self.excited & (speed > RESTING * speed.max(axis=0))


@lru_cache(maxsize=1)
def _arm_of(robot: RobotDescription) -> RigidArm:
    """Its rigid arm, kept for the next log of the same robot."""
    return RigidArm(robot)
