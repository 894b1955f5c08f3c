"""F4: other bristles, and with them the first travel after a reversal."""

from dataclasses import dataclass, replace
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import NativeEffect
from ffgym.effects.parameters import parameter
from ffgym.robot import RobotDescription


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PreslidingStiffness(NativeEffect):
    """Stiffness and damping of the LuGre bristles higher or lower."""

    name = "presliding"
    code = "F4"
    title = "presliding stiffness and damping"
    equation = r"\sigma_0 \to (1 + a)\, \sigma_0, \quad \sigma_1 \to (1 + b)\, \sigma_1"
    side = "motor"
    signature = "torque: width and rounding of the loop over the travel since the last reversal; nothing in sliding"
    way_in = "native: sigma_0 and sigma_1 of MuJoCo's LuGre friction"
    confusable_with = ("F3", "F10", "T9")
    separating_motions = ("slow_triangles", "speed_ladder", "dwell_restart")
    at_low_speed = True
    needs_friction = True
    patterns = (("sign-locked function", "travel since the last reversal"),)

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
        """Return the robot with other bristles."""
        more = robot.friction.scale(bristle_stiffness=1 + self.stiffness, bristle_damping=1 + self.damping)
        return replace(robot, friction=more)
