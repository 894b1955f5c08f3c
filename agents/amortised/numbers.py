"""Numbers of a machine beside those of its nominal robot, as a vector: an estimator finds them, a law needs them."""

from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.core.errors import check_shape
from ffgym.core.types import Array
from ffgym.effects.friction.asymmetry import Asymmetry
from ffgym.effects.friction.falling import FallingFriction
from ffgym.effects.friction.load import LoadFriction
from ffgym.effects.transmission.hysteresis import TorsionalHysteresis
from ffgym.robot import RobotDescription
from ffgym.robot.description import with_payload
from ffgym.simulation.plant import Machine

FRICTION = ("coulomb", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping")
"""Friction numbers of which the vector has log factors; breakaway torque goes with Coulomb torque."""
GROUPS = (
    *FRICTION,
    "arm_share",
    "joint_stiffness",
    "rotor_inertia",
    "link_inertia",
    "asymmetry",
    "load_friction",
    "falling_friction",
    "hysteresis",
)
"""Groups of the vector, N numbers each: log factors on nominal numbers; the arm's share of friction less the nominal
one; sizes of effects, which a nominal robot has not. A last number is the payload [kg]."""
LOST_MOTION = 1e-4
"""Unit of the lost motion of hysteresis in the vector [rad]: sizes of all numbers are then about one; chosen."""
FALL_WIDTH, FALL_EXPONENT = 10.0, 1.0
"""Width, in Stribeck velocities, and exponent of falling friction in a law; a lap does not tell them. Chosen: the
middle of the draws, see `ffgym.agents.amortised.draws`."""
HYSTERESIS_WIDTH = 3e-4
"""Width of the hysteresis in a law [rad]; as above."""
_LIMITS = {
    "asymmetry": (-0.3, 0.3),
    "load_friction": (0.0, 0.1),
    "falling_friction": (0.0, 0.4),
    "hysteresis": (0.0, 0.6),
}
"""Range of sizes of effects in a law; chosen: somewhat beyond the draws."""


def split(numbers: Array, n_joints: int) -> dict[str, Array]:
    """Split a vector (13 N + 1,) by group, (N,) each, and 'payload', a number."""
    numbers = check_shape("numbers of a machine", numbers, (len(GROUPS) * n_joints + 1,))
    parts = dict(zip(GROUPS, numbers[:-1].reshape(len(GROUPS), n_joints), strict=True))
    return parts | {"payload": numbers[-1]}


def numbers_of(machine: Machine, nominal: RobotDescription) -> Array:
    """Return the numbers of a machine beside those of its nominal robot, shape (13 N + 1,)."""
    robot, n = machine.robot, nominal.n_joints
    found = {name: np.log(getattr(robot.friction, name) / getattr(nominal.friction, name)) for name in FRICTION}
    found["arm_share"] = robot.arm_share - nominal.arm_share
    for name in ("joint_stiffness", "rotor_inertia"):
        found[name] = np.log(getattr(robot.drive, name) / getattr(nominal.drive, name))
    found["link_inertia"] = np.log(robot.bodies.mass / nominal.bodies.mass)
    # sizes of the effects that it has
    sizes = {Asymmetry: "coulomb", LoadFriction: "share", FallingFriction: "share", TorsionalHysteresis: "lost_motion"}
    for group, (kind, size) in zip(GROUPS[-4:], sizes.items(), strict=True):
        own = [getattr(effect, size) for effect in machine.effects if isinstance(effect, kind)]
        found[group] = own[0] if own else np.zeros(n)
    found["hysteresis"] = found["hysteresis"] / LOST_MOTION
    mass = 0.0 if robot.tool is None or nominal.tool is None else robot.tool.mass - nominal.tool.mass
    return np.append(np.concatenate([found[name] for name in GROUPS]), mass)


def machine_with(nominal: RobotDescription, numbers: Array) -> Machine:
    """Make the machine that has these numbers (13 N + 1,), the inverse of `numbers_of`.

    Sizes of effects and shares that no machine has are taken to their limits; damping of joints goes with the root of
    their stiffness, as in `ffgym.simulation.plant.PlantDistribution`.
    """
    part = split(numbers, nominal.n_joints)
    factor = {name: np.exp(part[name]) for name in (*FRICTION, "joint_stiffness", "rotor_inertia", "link_inertia")}
    friction = nominal.friction.scale(static=factor["coulomb"], **{name: factor[name] for name in FRICTION})
    share = np.where(nominal.arm_share > 0, np.clip(nominal.arm_share + part["arm_share"], 0.0, 1.0), 0.0)
    drive, bodies = nominal.drive, nominal.bodies
    robot = replace(
        nominal,
        friction=replace(friction, arm_share=share),
        drive=replace(
            drive,
            joint_stiffness=drive.joint_stiffness * factor["joint_stiffness"],
            joint_damping=drive.joint_damping * np.sqrt(factor["joint_stiffness"]),
            rotor_inertia=drive.rotor_inertia * factor["rotor_inertia"],
        ),
        bodies=replace(
            bodies,
            mass=bodies.mass * factor["link_inertia"],
            inertia=bodies.inertia * factor["link_inertia"][:, None],
        ),
        quantities=MappingProxyType({}),  # origins of the numbers that were just changed
    )
    if robot.tool is not None and part["payload"] > 0:
        robot = with_payload(robot, float(part["payload"]))
    return Machine(robot=robot, effects=_effects(robot, part))


def _effects(robot: RobotDescription, part: dict[str, Array]) -> tuple[Any, ...]:
    """Make effects of the sizes in a vector's parts; those without any are left out."""
    size = {name: np.clip(part[name], *limits) for name, limits in _LIMITS.items()}
    found = (
        Asymmetry.on(robot, coulomb=size["asymmetry"], viscous=0.0),
        LoadFriction.on(robot, share=size["load_friction"]),
        FallingFriction.on(robot, share=size["falling_friction"], width=FALL_WIDTH, exponent=FALL_EXPONENT),
        TorsionalHysteresis.on(robot, lost_motion=size["hysteresis"] * LOST_MOTION, width=HYSTERESIS_WIDTH),
    )
    return tuple(effect for effect in found if not effect.is_null)
