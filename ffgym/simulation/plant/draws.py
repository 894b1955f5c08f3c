"""Random robots: draws of the numbers that differ from machine to machine, from declared distributions."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import final

import numpy as np

from ffgym.core.errors import FFGymError, check_number
from ffgym.core.types import Array
from ffgym.robot import RobotDescription
from ffgym.robot.description import with_payload as with_payload


class Distribution(ABC):
    """Distribution of one number."""

    @abstractmethod
    def draw(self, rng: np.random.Generator, n: int) -> Array:
        """Return `n` independent numbers, shape (n,)."""


@final
@dataclass(frozen=True)
class Uniform(Distribution):
    """Every number of [low, high] is equally likely."""

    low: float
    high: float

    def __post_init__(self) -> None:
        check_number("low", self.low)
        check_number("high", self.high, low=self.low)

    def draw(self, rng: np.random.Generator, n: int) -> Array:
        """Draw uniformly between low and high."""
        return rng.uniform(self.low, self.high, size=n)


@final
@dataclass(frozen=True)
class LogUniform(Distribution):
    """The logarithm is uniform on [log low, log high], so that half and double are equally likely."""

    low: float
    high: float

    def __post_init__(self) -> None:
        check_number("low", self.low, low=0.0, open_low=True)
        check_number("high", self.high, low=self.low)

    def draw(self, rng: np.random.Generator, n: int) -> Array:
        """Draw uniformly in the logarithm between low and high; the same numbers on all processors.

        In double precision numpy takes functions of the processor, whose last bits differ with AVX-512 and without.
        """
        low, high = (float(np.log(np.longdouble(end))) for end in (self.low, self.high))
        drawn: Array = np.exp(rng.uniform(low, high, size=n).astype(np.longdouble)).astype(np.float64)
        return drawn


_TORQUE_PATH = ("torque_lag", "torque_delay", "torque_rate")
"""Groups of the drive that a robot need not have."""


@dataclass(frozen=True, kw_only=True)
class PlantDistribution:
    """Distribution of robots of one kind: factors on the parameters, and a payload. None leaves a group alone.

    Factors are independent from joint to joint. All defaults are chosen: friction changes by tens of per cent with
    temperature, load and wear, its viscous part most; gearbox stiffness and masses are known far better.
    """

    friction_level: Distribution | None = LogUniform(0.7, 1.4)
    """Factor on Coulomb and breakaway torque together."""
    viscous: Distribution | None = LogUniform(0.6, 1.6)
    """Factor on viscous friction, which temperature changes most."""
    stribeck_velocity: Distribution | None = LogUniform(0.7, 1.4)
    """Factor on the Stribeck velocity."""
    bristle_stiffness: Distribution | None = LogUniform(0.7, 1.4)
    """Factor on the LuGre bristle stiffness."""
    bristle_damping: Distribution | None = LogUniform(0.7, 1.4)
    """Factor on the LuGre bristle damping."""
    joint_stiffness: Distribution | None = LogUniform(0.85, 1.15)
    """Factor on the joint stiffness; its damping follows, so that the damping ratio stays."""
    link_inertia: Distribution | None = LogUniform(0.95, 1.05)
    """Factor on mass and inertia of each link."""
    rotor_inertia: Distribution | None = LogUniform(0.97, 1.03)
    """Factor on the rotor inertia of each motor."""
    arm_share: Distribution | None = None
    """Share of friction behind the elasticity, in place of the robot's own on joints that have one, or on all joints
    of a robot without; plants of environments are drawn from robots that have one."""
    torque_lag: Distribution | None = None
    """Factor on the time constant of the torque loop, for drives that have one."""
    torque_delay: Distribution | None = None
    """Factor on the delay of torque, for drives that have one."""
    torque_rate: Distribution | None = None
    """Factor on the fastest change of torque, for drives that limit it."""
    payload: Distribution | None = Uniform(0.0, 5.0)
    """Point mass at the TCP [kg], beside the tool."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None and not isinstance(value, Distribution):
                raise FFGymError(
                    f"{field.name} = {value!r} must be a distribution, e.g. LogUniform(0.8, 1.25), or None for no draw."
                )

    def draw(self, robot: RobotDescription, rng: np.random.Generator) -> RobotDescription:
        """Return a robot like `robot`; groups are drawn in the order of the fields, so that a seed means one robot.

        Raises:
            FFGymError: if a drawn number is not physical, for example a negative factor.
        """
        n = robot.n_joints
        # factors on the nominal numbers, by joint; groups that do not vary keep 1
        groups = {field.name: getattr(self, field.name) for field in fields(self)[:-1]}
        factor = {name: np.ones(n) if group is None else group.draw(rng, n) for name, group in groups.items()}
        level = factor.pop("friction_level")
        stiffness, links, rotor = (factor.pop(name) for name in ("joint_stiffness", "link_inertia", "rotor_inertia"))
        for name, values in {"stiffness": stiffness, "links": links, "rotor": rotor}.items():
            if np.any(values <= 0):
                raise FFGymError(f"The drawn factors of {name} = {values} must be > 0; use a distribution above 0.")
        tool = robot.tool
        if tool is not None and self.payload is not None:
            tool = with_payload(robot, float(self.payload.draw(rng, 1).item())).tool
        friction, share = robot.friction, factor.pop("arm_share")
        if self.arm_share is not None:
            own = np.ones(n) if friction.arm_share is None else friction.arm_share
            friction = replace(friction, arm_share=np.where(own > 0, share, 0.0))
        # damping goes with the root of the stiffness, which keeps the damping ratio at equal inertia
        drive, bodies = robot.drive, robot.bodies
        loops = {name: (getattr(drive, name), factor.pop(name)) for name in _TORQUE_PATH}
        for name, (values, _) in loops.items():
            if values is None and getattr(self, name) is not None:
                raise FFGymError(f"Robot {robot.name!r} has no drive.{name} to draw factors on; give it one, or None.")
        return replace(
            robot,
            friction=friction.scale(coulomb=level, static=level, **factor),
            drive=replace(
                drive,
                joint_stiffness=drive.joint_stiffness * stiffness,
                joint_damping=drive.joint_damping * np.sqrt(stiffness),
                rotor_inertia=drive.rotor_inertia * rotor,
                **{name: values * factors for name, (values, factors) in loops.items() if values is not None},
            ),
            bodies=replace(bodies, mass=bodies.mass * links, inertia=bodies.inertia * links[:, None]),
            tool=tool,
            quantities=MappingProxyType({}),  # origins of the numbers that were just changed
        )
