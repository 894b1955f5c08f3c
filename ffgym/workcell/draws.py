"""Draw workcells by seed: robots of one kind, which differ as machines of one series and of all ages do."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from ffgym.core.errors import check_choice, check_whole
from ffgym.core.types import Array
from ffgym.effects import Effect
from ffgym.effects.measurement.tracker_frame import TrackerFrame
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
from ffgym.workcell.reading import workcell

NUMBERS = PlantDistribution(
    friction_level=LogUniform(0.75, 1.35),
    viscous=LogUniform(0.5, 2.0),
    joint_stiffness=LogUniform(0.7, 1.4),
    link_inertia=LogUniform(0.85, 1.18),
    rotor_inertia=LogUniform(0.85, 1.18),
    payload=Uniform(0.0, 10.0),
)
"""Distribution of the robot's numbers about those of its controller; chosen: friction as it differs within a series,
and half of the uncertainty that docs/robots states of the rest."""

_WITH_DRIVES = replace(
    NUMBERS,
    arm_share=Uniform(0.2, 0.9),
    torque_lag=LogUniform(0.5, 2.0),
    torque_delay=LogUniform(0.5, 2.0),
    torque_rate=LogUniform(0.5, 2.0),
)
"""The same for machines with friction behind their springs and drives that are not ideal; chosen: shares about those
that the published errors give (0.35 to 0.86, docs/published_robot.md), and drives within a factor of two."""

SERIES: Mapping[str, tuple[str, PlantDistribution]] = MappingProxyType(
    {"": ("thesis", NUMBERS), "drives": ("thesis_drives", _WITH_DRIVES)}
)
"""Workcell that the machines of each series are like, and the distribution of their numbers. Machines of series
'drives' are named workcell:drives-<seed>, those of the first one workcell:<seed>."""

PRESENT = 0.6
"""Chosen: probability that a machine has an effect."""

Draw = Callable[[np.random.Generator, RobotDescription], Effect]


def draw(seed: int, series: str = "") -> Workcell:
    """Draw a workcell by its seed: first numbers of its robot with the payload, then effects, then temperatures.

    Args:
        seed: whole number from 0 on.
        series: "", or "drives" for friction behind the springs and drives that are not ideal.

    Raises:
        FFGymError: if the seed is no whole number from 0 on, or there is no such series.
    """
    seed = check_whole("seed", seed, low=0)
    name, numbers = SERIES[check_choice("series", series, list(SERIES))]
    rng = np.random.default_rng(seed)
    # every draw is made, so that one effect does not shift the draws of the next
    like = workcell(name)
    robot = numbers.draw(like.robot, rng)
    drawn = [(rng.random(), one(rng, robot)) for one in EFFECT_DRAWS.values()]
    label = f"{series}-{seed}" if series else f"seed {seed}"
    machine = SealedMachine(
        label=label,
        robot=robot,
        effects=tuple(effect for chance, effect in drawn if chance < PRESENT),
        climate=Climate(  # from a cold hall to a hot one, from just switched on to the end of a shift
            ambient=rng.uniform(10.0, 30.0),
            rise=rng.uniform(8.0, 22.0, size=robot.n_joints),
            time_constant=rng.uniform(900.0, 2400.0),
            running_since=rng.uniform(0.0, 4 * 3600.0),
        ),
    )
    title = f"a machine of the same kind, drawn with seed {seed}"
    return replace(like, name=label.replace(" ", "-"), title=title, machine=machine)


def _shares(rng: np.random.Generator, robot: RobotDescription, low: float, high: float) -> Array:
    """Draw torques [N m], uniform in shares of each joint's Coulomb friction, shape (N,)."""
    return robot.friction.coulomb * rng.uniform(low, high, size=robot.n_joints)


def _gear_losses(rng: np.random.Generator, robot: RobotDescription) -> Effect:
    driving = rng.uniform(0.005, 0.05, size=robot.n_joints)
    return GearLosses.on(robot, driving=driving, driven=driving * rng.uniform(1.0, 2.0, size=robot.n_joints))


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
        GearLosses.name: _gear_losses,
        ColdOil.name: lambda rng, robot: ColdOil.on(
            robot,
            viscous=rng.uniform(0.5, 0.95) * robot.friction.viscous,
            vogel=rng.uniform(600.0, 1200.0),
            reference=38.0,
        ),
        SmoothHysteresis.name: lambda rng, robot: SmoothHysteresis.on(
            robot,  # of an arc minute, 2.9e-4 rad, what is lost is a seventh at the upper end
            level=rng.uniform(5e-6, 4e-5, size=robot.n_joints) * robot.drive.joint_stiffness,
            yielding=rng.uniform(5e-5, 2e-4),
            exponent=rng.uniform(1.0, 2.5),
        ),
        GearError.name: lambda rng, robot: GearError.on(
            robot,
            amplitude=rng.uniform(2e-6, 3e-5, size=robot.n_joints),
            cycles=float(rng.integers(1, 4)),
            phase=rng.uniform(-np.pi, np.pi, size=robot.n_joints),
        ),
        TorqueRipple.name: lambda rng, robot: TorqueRipple.on(
            robot,
            cycles=float(rng.choice([1, 2, 3, 6])),
            share=rng.uniform(0.003, 0.03, size=robot.n_joints),
            phase=rng.uniform(-np.pi, np.pi, size=robot.n_joints),
        ),
        ResolverEccentricity.name: lambda rng, robot: ResolverEccentricity.on(
            robot,
            amplitude=rng.uniform(1e-4, 1.5e-3, size=robot.n_joints),
            phase=rng.uniform(-np.pi, np.pi, size=robot.n_joints),
        ),
        TrackerFrame.name: lambda rng, robot: TrackerFrame.on(
            robot,
            shift=rng.uniform(-1e-3, 1e-3, size=3),
            turn=rng.uniform(-5e-4, 5e-4, size=3),
            scale=rng.uniform(-5e-5, 5e-5),
        ),
    }
)
"""Distributions of each effect, drawn in the order of its arguments; sizes are within the ranges of the literature that
`ffgym.effects` gives."""
