"""Numbers of a machine: what its description says, made wrong as descriptions are, and faults beside them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.core.errors import check_choice
from ffgym.core.types import Array, BoolArray
from ffgym.robot.description import RobotDescription
from scripts.exam.independent.arm import Bodies, bodies_of

_USUAL = 0.3
"""Usual speed over the largest; chosen: what a motion that fills the range in a second comes to."""


FAULTS: Mapping[str, str] = MappingProxyType(
    {
        "asymmetry": "share of the Coulomb torque that is more forwards and less backwards",
        "load_share": "share of the torque that the gearbox passes on, which adds to the strength of the contact",
        "blocks": "1 where blocks on springs rub in place of bristles",
        "bend": "by how much the exponent of viscous friction is below 1",
        "warm": "share of viscous friction that is lost when warm, by a Lorentz curve of temperature",
        "wear": "share of the Coulomb torque that is gained in an hour, evenly",
        "waves": "share of the Coulomb torque that comes and goes with the joint angle",
        "wave_cycles": "of these waves [1/rad], by the joint angle",
        "gap": "half the play of the gearbox, link side [rad], with edges round over a tenth of it",
        "growth": "share by which the spring is stiffer at the deflection `growth_at`, by its magnitude",
        "growth_at": "deflection, link side [rad]",
        "behind": "share of the friction that rubs behind the spring, along the way of the link",
        "tooth": "error of the gearbox, link side [rad], once in a turn of the motor",
        "cogging": "torque that comes and goes with the angle of the motor [N m]",
        "cogging_cycles": "of it, per motor turn",
        "ripple": "share of the motor torque that comes and goes with its angle",
        "ripple_cycles": "of it, per motor turn",
        "torque_error": "share by which the motor gives more than its current says",
        "offset": "torque without a current [N m]",
        "lag": "time constant with which torque follows what is logged [s]",
        "resolver": "error of the motor's angle, once in a turn [rad]",
        "balance": "amplitude of a torque of the link that goes with the cosine of its angle [N m], link side",
        "brake": "amplitude of a drag that comes and goes with time [N m]",
        "clock": "amplitude of a torque that comes and goes with time [N m]",
        "frequency": "of both [Hz]",
        "neighbour": "torque on this joint by the angle of the next, the first after the last [N m]",
    }
)
"""Faults that a machine may have beside its description, one number per joint; friction acts through the strength of
the contact, and torques are of the motor side if nothing else is said."""


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
    faults: Mapping[str, Array] = field(default_factory=dict)
    """Values of `FAULTS` that some machine has."""

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


def with_fault(numbers: Numbers, joint: int, **values: float) -> Numbers:
    """The same machine with faults of that size on one joint."""
    faults = dict(numbers.faults)
    for name, value in values.items():
        changed = faults.get(name, np.zeros(numbers.shape)).copy()
        changed[:, joint] = value
        faults[check_choice("fault", name, list(FAULTS))] = changed
    return replace(numbers, faults=faults)


def side_by_side(machines: Sequence[Numbers]) -> Numbers:
    """Machines of the same joints as one batch."""

    def all_of(of: Sequence[Any], skip: tuple[str, ...]) -> dict[str, Any]:
        names = [f.name for f in fields(of[0]) if f.name not in skip]
        return {name: np.concatenate([getattr(one, name) for one in of]) for name in names}

    bodies, some = [one.bodies for one in machines], {name for one in machines for name in one.faults}
    return replace(
        machines[0],
        bodies=replace(bodies[0], **all_of(bodies, ("slides", "gravity", "tool_rotation"))),
        faults={name: np.concatenate([one.faults.get(name, np.zeros(one.shape)) for one in machines]) for name in some},
        **all_of(machines, ("bodies", "faults", "rigid")),
    )
