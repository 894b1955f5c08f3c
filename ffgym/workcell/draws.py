"""Workcells by seed: robots of one kind that differ as machines of one series and of all ages do."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from ffgym.core.errors import check_whole
from ffgym.core.types import Array
from ffgym.effects import Effect
from ffgym.effects.frames import TrackerFrame
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Climate, LogUniform, PlantDistribution, Uniform
from ffgym.workcell.cell import SealedMachine, Workcell
from ffgym.workcell.equations import (
    ColdOil,
    GearError,
    GearLosses,
    OneWayFriction,
    ResolverEccentricity,
    SlipElements,
    SlowStribeck,
    SmoothHysteresis,
    TorqueRipple,
)
from ffgym.workcell.instances import workcell

NUMBERS = PlantDistribution(
    friction_level=LogUniform(0.75, 1.35),
    viscous=LogUniform(0.5, 2.0),
    joint_stiffness=LogUniform(0.7, 1.4),
    link_inertia=LogUniform(0.85, 1.18),
    rotor_inertia=LogUniform(0.85, 1.18),
    payload=Uniform(0.0, 10.0),
)
"""Numbers of the robot, about those its controller has; chosen: friction as it differs within a series, and half of the
uncertainty that docs/robots states of the rest."""

PRESENT = 0.6
"""Chosen: probability that a machine has an effect."""

Draw = Callable[[np.random.Generator, RobotDescription], Effect]


def draw(seed: int) -> Workcell:
    """A workcell by its seed: numbers of its robot, effects, payload and temperature are drawn, in this order.

    Raises:
        FFGymError: if the seed is no whole number from 0 on.
    """
    seed = check_whole("seed", seed, low=0)
    rng = np.random.default_rng(seed)
    like = workcell("thesis")
    robot = NUMBERS.draw(like.robot, rng)
    drawn = [(rng.random(), one(rng, robot)) for one in EFFECT_DRAWS.values()]
    machine = SealedMachine(
        label=f"seed {seed}",
        robot=robot,
        effects=tuple(effect for chance, effect in drawn if chance < PRESENT),
        climate=_climate(rng, robot.n_joints),
    )
    title = f"a machine of the same kind, drawn with seed {seed}"
    return Workcell(name=f"seed-{seed}", title=title, arm=like.arm, machine=machine, sensors=like.sensors)


def _climate(rng: np.random.Generator, n: int) -> Climate:
    """From a cold hall to a hot one, from just switched on to the end of a shift."""
    return Climate(
        ambient=rng.uniform(10.0, 30.0),
        rise=rng.uniform(8.0, 22.0, size=n),
        time_constant=rng.uniform(900.0, 2400.0),
        running_since=rng.uniform(0.0, 4 * 3600.0),
    )


def _shares(rng: np.random.Generator, robot: RobotDescription, low: float, high: float) -> Array:
    """Torques [N m], uniform in shares of each joint's Coulomb friction, shape (N,)."""
    return robot.friction.coulomb * rng.uniform(low, high, size=robot.n_joints)


def _phases(rng: np.random.Generator, robot: RobotDescription) -> Array:
    return rng.uniform(-np.pi, np.pi, size=robot.n_joints)


def _lost(rng: np.random.Generator, robot: RobotDescription) -> Effect:
    driving = rng.uniform(0.005, 0.05, size=robot.n_joints)
    return GearLosses.on(robot, driving=driving, driven=driving * rng.uniform(1.0, 2.0, size=robot.n_joints))


def _oil(rng: np.random.Generator, robot: RobotDescription) -> Effect:
    share = rng.uniform(0.5, 0.95)
    return ColdOil.on(robot, viscous=share * robot.friction.viscous, vogel=rng.uniform(600.0, 1200.0), reference=38.0)


def _hysteresis(rng: np.random.Generator, robot: RobotDescription) -> Effect:
    lost = rng.uniform(5e-6, 4e-5, size=robot.n_joints)  # of an arc minute, 2.9e-4 rad, at the upper end a seventh
    return SmoothHysteresis.on(
        robot,
        level=lost * robot.drive.joint_stiffness,
        yielding=rng.uniform(5e-5, 2e-4),
        exponent=rng.uniform(1.0, 2.5),
    )


def _gear_error(rng: np.random.Generator, robot: RobotDescription) -> Effect:
    amplitude = rng.uniform(2e-6, 3e-5, size=robot.n_joints)
    return GearError.on(robot, amplitude=amplitude, cycles=float(rng.integers(1, 4)), phase=_phases(rng, robot))


def _ripple(rng: np.random.Generator, robot: RobotDescription) -> Effect:
    cycles = float(rng.choice([1, 2, 3, 6]))
    return TorqueRipple.on(
        robot, share=rng.uniform(0.003, 0.03, size=robot.n_joints), cycles=cycles, phase=_phases(rng, robot)
    )


def _resolver(rng: np.random.Generator, robot: RobotDescription) -> Effect:
    return ResolverEccentricity.on(
        robot, amplitude=rng.uniform(1e-4, 1.5e-3, size=robot.n_joints), phase=_phases(rng, robot)
    )


def _tracker(rng: np.random.Generator, robot: RobotDescription) -> Effect:
    shift, turn = rng.uniform(-1e-3, 1e-3, size=3), rng.uniform(-5e-4, 5e-4, size=3)
    return TrackerFrame.on(robot, shift=shift, turn=turn, scale=rng.uniform(-5e-5, 5e-5))


EFFECT_DRAWS: Mapping[str, Draw] = MappingProxyType(
    {
        SlowStribeck.name: lambda rng, robot: SlowStribeck.on(
            robot, level=_shares(rng, robot, 0.0, 0.25), speed=rng.uniform(0.5, 4.0)
        ),
        SlipElements.name: lambda rng, robot: SlipElements.on(
            robot, level=_shares(rng, robot, 0.02, 0.2), travel=rng.uniform(0.01, 0.08)
        ),
        OneWayFriction.name: lambda rng, robot: OneWayFriction.on(
            robot, level=_shares(rng, robot, -0.15, 0.15), speed=rng.uniform(2.0, 20.0)
        ),
        GearLosses.name: _lost,
        ColdOil.name: _oil,
        SmoothHysteresis.name: _hysteresis,
        GearError.name: _gear_error,
        TorqueRipple.name: _ripple,
        ResolverEccentricity.name: _resolver,
        TrackerFrame.name: _tracker,
    }
)
"""How each effect is drawn; sizes are within the ranges of the literature that `ffgym.effects` gives."""
