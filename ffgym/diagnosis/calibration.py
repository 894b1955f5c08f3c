"""Errors of calibration: what the numbers of a model that lacks nothing may be off by."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, final

import numpy as np

from ffgym.core.errors import check_number
from ffgym.core.types import Array
from ffgym.diagnosis.base_torques import base_torques
from ffgym.diagnosis.lateness import late_columns
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.signatures.column import Column, columns_of, machine_columns
from ffgym.effects import Effect, NativeEffect
from ffgym.effects.drive.offset import TorqueOffset
from ffgym.effects.drive.torque_constant import TorqueConstant
from ffgym.effects.effect import Side
from ffgym.effects.friction.coulomb import CoulombLevel
from ffgym.effects.friction.presliding import PreslidingStiffness
from ffgym.effects.friction.stribeck import StribeckPeak
from ffgym.effects.friction.viscous import ViscousLevel
from ffgym.effects.load.rotor_inertia import RotorInertia
from ffgym.effects.measurement.tool_frame import ToolFrame
from ffgym.effects.parameters import parameter
from ffgym.effects.transmission.stiffness import JointStiffness
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription

BOUND = 4.0
"""Standard deviations beyond which a calibration error is none: without a bound calibration swallows effects. Of the
sixty numbers of a robot one lies beyond 3 in every seventh robot, beyond 4 in one of 260.
"""

SHARE = 0.005
"""Default standard deviation of nominal numbers, relative: of robots that are calibrated one by one."""

_OFFSET = 2.0
"""Torque offset over `share` times the Coulomb torque, standard deviation: 1 % of it for the default share; chosen."""

_OPEN = 0.3
"""Standard deviation from which on a level of friction is as open as its plausible change is large, 30 %."""

_MASS_STEP = 0.03
"""Relative step of masses; their effect is linear."""

_TOOL = 20e-6
"""Standard deviation of the tool offset, each axis [m]: that of a laser tracker (thesis 2.2.4)."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LinkMass(NativeEffect):
    """Masses and inertias of links other than described; a doubt of the calibration, no effect to be named."""

    name: ClassVar[str] = "link_mass"
    title: ClassVar[str] = "mass of a link"
    equation: ClassVar[str] = r"m_i \to (1 + a)\, m_i, \quad I_i \to (1 + a)\, I_i"
    side: ClassVar[Side] = "link"
    signature: ClassVar[str] = "torque: gravity and inertia of all joints before the link"
    way_in: ClassVar[str] = "native: masses and inertias"

    change: Array = parameter("a", unit="1", low=-0.1, high=0.1, minimum=-0.9, source="only a doubt")

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """See base class."""
        factor = 1 + self.change
        bodies = robot.bodies
        scaled = replace(bodies, mass=bodies.mass * factor, inertia=bodies.inertia * factor[:, None])
        return replace(robot, bodies=scaled)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LinkInertia(NativeEffect):
    """Inertias of links about their centres of mass other than described; a doubt, no effect to be named."""

    name: ClassVar[str] = "link_inertia"
    title: ClassVar[str] = "inertia of a link about its centre of mass"
    equation: ClassVar[str] = r"I_i \to (1 + a)\, I_i"
    side: ClassVar[Side] = "link"
    signature: ClassVar[str] = "torque with the acceleration, and the frequencies at which joints swing"
    way_in: ClassVar[str] = "native: inertias"

    change: Array = parameter("a", unit="1", low=-0.1, high=0.1, minimum=-0.9, source="only a doubt")

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """See base class."""
        bodies = robot.bodies
        scaled = replace(bodies, inertia=bodies.inertia * (1 + self.change)[:, None])
        return replace(robot, bodies=scaled)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class JointDamping(NativeEffect):
    """Damping of the joints other than described; a doubt of the calibration, no effect to be named."""

    name: ClassVar[str] = "joint_damping"
    title: ClassVar[str] = "damping of a joint"
    equation: ClassVar[str] = r"d \to (1 + a)\, d"
    side: ClassVar[Side] = "link"
    signature: ClassVar[str] = "tool and torque near resonances"
    way_in: ClassVar[str] = "native: damping of the joint"
    needs_elasticity: ClassVar[bool] = True

    change: Array = parameter("a", unit="1", low=-0.5, high=0.5, minimum=-0.9, source="only a doubt")

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """See base class."""
        drive = robot.drive
        return replace(robot, drive=replace(drive, joint_damping=drive.joint_damping * (1 + self.change)))


_OF_LINKS: tuple[type[LinkMass] | type[LinkInertia], ...] = (LinkMass, LinkInertia)

Refit = Callable[[Sequence[Recording]], RobotDescription]
"""From recordings, whose torque is without that of causes, to the robot that they are of."""


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """Standard deviations of what is known of the nominal model."""

    share: float = SHARE
    """Of masses, rotors, stiffness, damping and friction, relative."""
    levels: float | None = None
    """Of Coulomb and viscous friction, relative, where they are known less well than the rest; None is `share`."""
    torque_constant: float = 0.0
    """Of torque per current, relative, where the torque of a log is a current times a number that nobody measured; 0
    where torque is known."""
    offset: float = _OFFSET * SHARE
    """Of torque offsets, as a share of the Coulomb torque."""
    tool: float = _TOOL
    """Of the tool's place, each axis [m]."""
    base: float = 0.0
    """Of each base parameter of the rigid arm, as a share of the torque that motors take: for masses and inertias that
    were fitted to torque, which knows these combinations alone. 0: of masses and rotors one by one, by `share`."""

    refit: Refit | None = field(default=None, repr=False, compare=False)
    """Fits the numbers anew that were fitted to the logs: to what is left of their torque without that of causes."""

    def __post_init__(self) -> None:
        check_number("calibration share", self.share, low=0.0, high=1.0, open_low=True)
        if self.levels is not None:
            check_number("calibration levels", self.levels, low=0.0, open_low=True)
        check_number("calibration torque_constant", self.torque_constant, low=0.0, high=1.0)
        check_number("calibration offset", self.offset, low=0.0, open_low=True)
        check_number("calibration tool", self.tool, unit="m", low=0.0, open_low=True)
        check_number("calibration base", self.base, low=0.0, high=1.0)

    @classmethod
    def of_share(cls, share: float) -> "Calibration":
        """Calibration with relative errors of standard deviation `share`."""
        return cls(share=share, offset=_OFFSET * share)

    @property
    def of_levels(self) -> float:
        """Standard deviation of Coulomb and viscous friction, relative."""
        return self.share if self.levels is None else self.levels

    @property
    def open_numbers(self) -> frozenset[type[Effect]]:
        """Effects that are numbers of the model as little known as the effects are large: none of them is a cause."""
        found: set[type[Effect]] = set()
        if self.of_levels >= _OPEN:
            found |= {CoulombLevel, ViscousLevel}
        if self.torque_constant > 0:
            found.add(TorqueConstant)
        if self.base > 0:
            found.add(RotorInertia)
        return frozenset(found)


@dataclass(frozen=True, kw_only=True, eq=False)
class Doubt:
    """A column of what calibration leaves open."""

    column: Column
    sigma: float
    """Standard deviation of its parameter, in the parameter's unit."""
    at: float = 0.0
    """Where the nominal machine stands already, in standard deviations from what is described."""

    @property
    def low(self) -> float:
        """Lowest value, in standard deviations: as far as calibration errors go, and as a machine can be so."""
        known = self.column.effect.parameters()[self.column.parameter]
        return max(-BOUND - self.at, (known.minimum - known.neutral) / self.sigma)

    @property
    def high(self) -> float:
        """Highest value, in standard deviations."""
        known = self.column.effect.parameters()[self.column.parameter]
        return min(BOUND - self.at, (known.maximum - known.neutral) / self.sigma)


def doubts_of(run: Replay, calibration: Calibration) -> list[Doubt]:
    """Columns of all calibration errors along a nominal replay."""
    robot, share = run.robot, calibration.share
    plain: list[type[Effect]] = [PreslidingStiffness]
    if not robot.drive.is_rigid.all():
        plain += [JointStiffness, JointDamping]
    levels = columns_of(run, [CoulombLevel, ViscousLevel], {})
    found = [Doubt(column=column, sigma=calibration.of_levels) for column in levels]
    found += [Doubt(column=column, sigma=share) for column in columns_of(run, plain, {})]
    if calibration.torque_constant > 0:
        constants = [column for column in columns_of(run, [TorqueConstant], {}) if column.parameter == "error"]
        found += [Doubt(column=column, sigma=calibration.torque_constant) for column in constants]
    found += [_stribeck(column, robot, share) for column in columns_of(run, [StribeckPeak], {})]
    if calibration.base > 0:
        found += [Doubt(column=column, sigma=calibration.base) for column in _base(run)]
    else:
        found += [Doubt(column=column, sigma=share) for column in columns_of(run, [RotorInertia], {})]
        found += [Doubt(column=column, sigma=share) for kind in _OF_LINKS for column in _per_link(run, kind)]
    for column in columns_of(run, [TorqueOffset], {}):
        coulomb = float(robot.friction.coulomb[list(robot.joints).index(column.joint)])
        found.append(Doubt(column=column, sigma=calibration.offset * coulomb))
    found += [Doubt(column=column, sigma=sigma) for column, sigma in late_columns(run)]
    if run.log.tool is not None:
        found += [Doubt(column=column, sigma=calibration.tool) for column in columns_of(run, [ToolFrame], {})]
    return found


def _stribeck(column: Column, robot: RobotDescription, share: float) -> Doubt:
    """Breakaway torque is a share of itself off, where the effect's parameter is one of the Coulomb torque."""
    if column.parameter != "level":
        return Doubt(column=column, sigma=share)
    j = list(robot.joints).index(column.joint)
    return Doubt(column=column, sigma=share * float(robot.friction.static[j] / robot.friction.coulomb[j]))


def _base(run: Replay) -> list[Column]:
    """One column for each base parameter of bodies and rotors."""
    return [
        Column(effect=LinkMass, joint="", parameter="change", part=None, choice=k, span=0, shape={}, parts=parts)
        for k, parts in enumerate(base_torques(run).values())
    ]


def _per_link(run: Replay, kind: type[LinkMass] | type[LinkInertia]) -> Sequence[Column]:
    """One column for each link."""
    rows = zip(np.eye(run.robot.n_joints), run.robot.joints, strict=True)
    effects = [(joint, kind(change=_MASS_STEP * one)) for one, joint in rows]
    return machine_columns(run, effects, "change", _MASS_STEP)
