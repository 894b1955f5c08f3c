"""F1: another Coulomb level."""

from dataclasses import dataclass, replace
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import NativeEffect
from ffgym.effects.parameters import parameter
from ffgym.robot import RobotDescription


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CoulombLevel(NativeEffect):
    """Coulomb and breakaway torque higher or lower by the same amount."""

    name = "coulomb_level"
    code = "F1"
    title = "Coulomb friction level"
    equation = r"\tau_f \mathrel{+}= a\, f_c\, s(v)"
    side = "motor"
    signature = "torque: square wave locked to the sign of the speed, whatever speed, place and load"
    way_in = "native: coulomb and static of MuJoCo's LuGre friction"
    confusable_with = ("F7", "F13", "T3", "T4", "T6", "T9")
    separating_motions = ("slow_triangles", "warm_up")
    needs_friction = True
    patterns = (("sign-locked function", "motor speed"),)

    change: Array = parameter(
        "a, more Coulomb and breakaway torque as a share of the Coulomb torque",
        unit="1",
        low=-0.3,
        high=0.3,
        minimum=-0.95,
        source="friction levels of one robot type differ by 30 % with temperature, load and wear (Bittencourt 2012)",
        of=("friction", "coulomb"),
    )

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """Return the robot with Coulomb and breakaway torque raised by the same amount."""
        friction = robot.friction
        more = self.change * friction.coulomb
        return replace(
            robot, friction=replace(friction, coulomb=friction.coulomb + more, static=friction.static + more)
        )
