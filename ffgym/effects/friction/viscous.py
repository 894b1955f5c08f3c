"""F2: another viscous friction."""

from dataclasses import dataclass, replace
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import NativeEffect
from ffgym.effects.parameters import parameter
from ffgym.robot import RobotDescription


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ViscousLevel(NativeEffect):
    """Viscous friction higher or lower."""

    name = "viscous_level"
    code = "F2"
    title = "viscous friction level"
    equation = r"\tau_f \mathrel{+}= a\, f_v\, v"
    side = "motor"
    signature = "torque: odd and linear in the speed, whatever place and load"
    way_in = "native: damping of MuJoCo's friction actuator"
    confusable_with = ("F7", "F8", "F12", "M5", "X3")
    separating_motions = ("speed_ladder", "warm_up", "excitation")
    needs_friction = True
    patterns = (("function", "motor speed"),)

    change: Array = parameter(
        "a, more viscous friction as a share of it",
        unit="1",
        low=-0.5,
        high=0.5,
        minimum=-1.0,
        source="halves over about 20 K of warm-up (Bittencourt et al. 2010); from memory of the literature",
        of=("friction", "viscous"),
    )

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """Return the robot with another viscous coefficient."""
        return replace(robot, friction=robot.friction.scale(viscous=1 + self.change))
