"""F4: other bristles, and with them the first travel after a reversal."""

from dataclasses import dataclass, replace
from typing import ClassVar, final

from ffgym.core.types import Array
from ffgym.effects.effect import NativeEffect, Side
from ffgym.effects.parameters import parameter
from ffgym.robot import RobotDescription


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PreslidingStiffness(NativeEffect):
    """Stiffness and damping of the LuGre bristles higher or lower."""

    name: ClassVar[str] = "presliding"
    code: ClassVar[str] = "F4"
    title: ClassVar[str] = "presliding stiffness and damping"
    equation: ClassVar[str] = r"\sigma_0 \to (1 + a)\, \sigma_0, \quad \sigma_1 \to (1 + b)\, \sigma_1"
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = (
        "torque: width and rounding of the loop over the travel since the last reversal; nothing in sliding"
    )
    way_in: ClassVar[str] = "native: sigma_0 and sigma_1 of MuJoCo's LuGre friction"
    confusable_with: ClassVar[tuple[str, ...]] = ("F3", "F10")
    separating_motions: ClassVar[tuple[str, ...]] = ("slow_triangles", "speed_ladder", "dwell_restart")
    at_low_speed: ClassVar[bool] = True
    needs_friction: ClassVar[bool] = True
    patterns: ClassVar[tuple[tuple[str, str], ...]] = (("sign-locked function", "travel since the last reversal"),)

    stiffness: Array = parameter(
        "a, more bristle stiffness as a share of it",
        unit="1",
        low=-0.6,
        high=1.5,
        minimum=-0.95,
        source="travel until sliding 20 to 200 microrad behind the gearbox; from memory of the literature",
        of=("friction", "bristle_stiffness"),
    )
    damping: Array = parameter(
        "b, more bristle damping as a share of it",
        unit="1",
        low=-0.6,
        high=1.5,
        minimum=-1.0,
        source="chosen: as wide as that of the stiffness",
        of=("friction", "bristle_damping"),
    )

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """See base class."""
        more = robot.friction.scaled(bristle_stiffness=1 + self.stiffness, bristle_damping=1 + self.damping)
        return replace(robot, friction=more)
