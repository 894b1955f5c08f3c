"""The numbers of a description that are fitted together: what they are called, and how far they may be off."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.calibration import LinkMass
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.signatures.variant import STEP
from ffgym.effects import Effect, NativeEffect
from ffgym.effects.effect import Side
from ffgym.effects.friction.coulomb import CoulombLevel
from ffgym.effects.friction.presliding import PreslidingStiffness
from ffgym.effects.friction.viscous import ViscousLevel
from ffgym.effects.load.rotor_inertia import RotorInertia
from ffgym.effects.parameters import parameter
from ffgym.effects.transmission.stiffness import JointStiffness
from ffgym.robot import RobotDescription

SPREAD = 2.0
"""Standard deviation of a number, in plausible ranges of its effect, which are those of identified robots; chosen."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Breakaway(NativeEffect):
    """Another Stribeck curve that never falls below the Coulomb torque; a number to be fitted, no effect to be named.

    As an effect to be named the peak counts in Coulomb torques, and a step of many numbers at once would leave what a
    description can say.
    """

    name: ClassVar[str] = "breakaway"
    title: ClassVar[str] = "breakaway torque above the Coulomb torque"
    equation: ClassVar[str] = r"f_s - f_c \to (1 + a) (f_s - f_c), \quad v_s \to (1 + b)\, v_s"
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = "torque: odd in the speed, only below three Stribeck velocities; peaks after reversals"
    way_in: ClassVar[str] = "native: static and Stribeck velocity of MuJoCo's LuGre friction"
    needs_friction: ClassVar[bool] = True

    level: Array = parameter("a", unit="1", low=-0.6, high=1.5, minimum=-0.95, source="chosen: as bristles")
    velocity: Array = parameter("b", unit="1", low=-0.5, high=1.0, minimum=-0.95, source="as of the Stribeck peak")

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """See base class."""
        friction = robot.friction
        static = friction.coulomb + (1 + self.level) * (friction.static - friction.coulomb)
        velocity = friction.stribeck_velocity * (1 + self.velocity)
        return replace(robot, friction=replace(friction, static=static, stribeck_velocity=velocity))


NUMBERS: tuple[type[Effect], ...] = (
    CoulombLevel,
    ViscousLevel,
    Breakaway,
    PreslidingStiffness,
    RotorInertia,
    LinkMass,
    JointStiffness,
)
"""What is fitted on every joint that has it, as shares of what the description says. Springs keep their damping ratio:
recordings tell it only at resonance."""


def as_described(robot: RobotDescription) -> tuple[Hypothesis, ...]:
    """All numbers as a description has them."""
    rigid = robot.drive.is_rigid
    return tuple(
        Hypothesis(
            kind=kind,
            joint=joint,
            source=None,
            values={name: np.array(p.neutral) for name, p in kind.parameters().items()},
        )
        for kind in NUMBERS
        for j, joint in enumerate(robot.joints)
        if not (kind.needs_elasticity and rigid[j])
    )


def distance(numbers: Iterable[Hypothesis]) -> Array:
    """How far all numbers are from the description, in practical steps."""
    return np.array(
        [
            (free.value - number.kind.parameters()[free.name].neutral) / free.step
            for number in numbers
            for free in number.free()
        ]
    )


PRECISION = (STEP / SPREAD) ** 2
"""Of that distance, before any recording."""


def with_numbers(robot: RobotDescription, numbers: Iterable[Hypothesis]) -> RobotDescription:
    """The description with other numbers."""
    for number in numbers:
        effect = number.effect(robot)
        assert isinstance(effect, NativeEffect)
        robot = effect.in_description(robot)
    return robot
