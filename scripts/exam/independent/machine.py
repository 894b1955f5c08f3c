"""Numbers of a machine: what its description says, made wrong as descriptions are, and faults beside them."""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, final

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.robot.description import RobotDescription
from scripts.exam.independent.arm import Bodies, bodies_of

_USUAL = 0.3
"""Usual speed over the largest; chosen: what a motion that fills the range in a second comes to."""


def _none(*shape: int) -> Array:
    return np.zeros(shape)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Faults:
    """What a machine may have beside its description, none of it by default; one entry per joint, or alone.

    Friction acts through the strength of the contact; torques are of the motor side if nothing else is said.
    """

    asymmetry: Array = field(default_factory=_none)
    """Share of the Coulomb torque that is more forwards and less backwards."""
    load_share: Array = field(default_factory=_none)
    """Share of the torque that the gearbox passes on, which adds to the strength of the contact."""
    blocks: Array = field(default_factory=_none)
    """1 where blocks on springs rub in place of bristles."""
    bend: Array = field(default_factory=_none)
    """By how much the exponent of viscous friction is below 1."""
    warm: Array = field(default_factory=_none)
    """Share of viscous friction that is lost when warm, by a Lorentz curve of temperature."""
    wear: Array = field(default_factory=_none)
    """Share of the Coulomb torque that is gained in an hour, evenly."""
    waves: Array = field(default_factory=_none)
    """Share of the Coulomb torque that comes and goes with the joint angle."""
    wave_cycles: Array = field(default_factory=_none)
    """[1/rad] of the joint angle."""
    gap: Array = field(default_factory=_none)
    """Half the play of the gearbox, link side [rad], with edges round over a tenth of it."""
    growth: Array = field(default_factory=_none)
    """Share by which the spring is stiffer at the deflection `growth_at`, by its magnitude."""
    growth_at: Array = field(default_factory=_none)
    """Link side [rad]."""
    tooth: Array = field(default_factory=_none)
    """Error of the gearbox, link side [rad], once in a turn of the motor."""
    cogging: Array = field(default_factory=_none)
    """[N m]."""
    cogging_cycles: Array = field(default_factory=_none)
    """Per motor turn."""
    ripple: Array = field(default_factory=_none)
    """Share of the motor torque that comes and goes with its angle."""
    ripple_cycles: Array = field(default_factory=_none)
    """Per motor turn."""
    torque_error: Array = field(default_factory=_none)
    """Share by which the motor gives more than its current says."""
    offset: Array = field(default_factory=_none)
    """[N m]."""
    lag: Array = field(default_factory=_none)
    """Time constant with which torque follows what is logged [s]."""
    resolver: Array = field(default_factory=_none)
    """Error of the motor's angle, once in a turn [rad]."""
    balance: Array = field(default_factory=_none)
    """Amplitude of a torque of the link that goes with the cosine of its angle [N m], link side."""
    brake: Array = field(default_factory=_none)
    """Amplitude of a drag that comes and goes with time [N m]."""
    clock: Array = field(default_factory=_none)
    """Amplitude of a torque that comes and goes with time [N m]."""
    frequency: Array = field(default_factory=_none)
    """Of both [Hz]."""
    neighbour: Array = field(default_factory=_none)
    """Torque on this joint by the angle of the next, the first after the last [N m]."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Numbers:
    """Machines of the same joints, B of them side by side; motor side unless said otherwise, shape (B, N) each."""

    bodies: Bodies
    gear_ratio: Array
    rotor: Array
    stiffness: Array
    """Link side [N m/rad]; anything where joints are rigid."""
    damping: Array
    """Link side [N m s/rad]."""
    rigid: BoolArray
    """Shape (N,)."""
    coulomb: Array
    breakaway: Array
    viscous: Array
    stribeck: Array
    """Speed at which the breakaway torque is gone by 63 % [rad/s]."""
    presliding: Array
    """Stiffness of the contact at rest [N m/rad]."""
    rubbing: Array
    """Damping of the contact [N m s/rad]."""
    usual_speed: Array
    """At which bent viscous friction is as described [rad/s]."""
    faults: Faults = field(default_factory=Faults)

    @property
    def shape(self) -> tuple[int, int]:
        """(B, N)."""
        return self.rotor.shape[0], self.rotor.shape[1]


def numbers_of(robot: RobotDescription) -> Numbers:
    """One machine that is as its description."""
    drive, friction = robot.drive, robot.friction
    rigid = np.isinf(drive.joint_stiffness)

    def one(values: Array) -> Array:
        return np.array(values, dtype=np.float64)[None]

    return Numbers(
        bodies=bodies_of(robot),
        gear_ratio=one(drive.gear_ratio),
        rotor=one(drive.rotor_inertia),
        stiffness=one(np.where(rigid, 0.0, drive.joint_stiffness)),
        damping=one(np.where(rigid, 0.0, drive.joint_damping)),
        rigid=rigid,
        coulomb=one(friction.coulomb),
        breakaway=one(friction.static),
        viscous=one(friction.viscous),
        stribeck=one(friction.stribeck_velocity),
        presliding=one(friction.bristle_stiffness),
        rubbing=one(friction.bristle_damping),
        usual_speed=one(_USUAL * robot.kinematics.max_speed * np.abs(drive.gear_ratio)),
        faults=_spread(Faults(), robot.n_joints),
    )


_UNSURE = ("rotor", "stiffness", "damping", "coulomb", "breakaway", "viscous", "stribeck", "presliding", "rubbing")


def unsure(robot: RobotDescription, share: float, rng: np.random.Generator) -> Numbers:
    """A machine whose links and drives are off their description by a share, normally distributed; its tool is not."""

    def off(values: Array, *shape: int) -> Array:
        return values * (1 + share * rng.standard_normal(shape or values.shape))

    links = robot.bodies
    links = replace(links, mass=off(links.mass), inertia=off(links.inertia, robot.n_joints, 1))
    numbers = numbers_of(replace(robot, bodies=links, quantities={}))
    values: dict[str, Any] = {name: off(getattr(numbers, name)) for name in _UNSURE}
    found = replace(numbers, **values)
    return replace(found, breakaway=np.maximum(found.breakaway, found.coulomb))


def with_fault(numbers: Numbers, joint: int | None, **values: float) -> Numbers:
    """The same machine with a fault of that size on one joint, or on the machine."""
    changed = {}
    for name, value in values.items():
        changed[name] = getattr(numbers.faults, name).copy()
        changed[name][:, slice(None) if joint is None else joint] = value
    return replace(numbers, faults=replace(numbers.faults, **changed))


def side_by_side(machines: Sequence[Numbers]) -> Numbers:
    """Machines of the same joints as one batch."""

    def all_of(of: Sequence[Any], skip: tuple[str, ...]) -> dict[str, Any]:
        names = [f.name for f in fields(of[0]) if f.name not in skip]
        return {name: np.concatenate([getattr(one, name) for one in of]) for name in names}

    bodies = [one.bodies for one in machines]
    shared = ("slides", "gravity", "tool_rotation")
    return replace(
        machines[0],
        bodies=replace(bodies[0], **all_of(bodies, shared)),
        faults=replace(machines[0].faults, **all_of([one.faults for one in machines], ())),
        **all_of(machines, ("bodies", "faults", "rigid")),
    )


def _spread(faults: Faults, n: int) -> Faults:
    return replace(faults, **{f.name: np.zeros((1, n)) for f in fields(Faults)})
