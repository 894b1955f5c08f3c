"""F3: another breakaway peak at low speed, in height and width."""

from dataclasses import dataclass, replace
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import NativeEffect
from ffgym.effects.parameters import parameter
from ffgym.robot import RobotDescription


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class StribeckPeak(NativeEffect):
    r"""Height and width of the Stribeck curve; its exponent is that of MuJoCo, 2.

    Both changes are shares, of the Coulomb torque and of the Stribeck velocity.
    """

    name = "stribeck_peak"
    code = "F3"
    title = "Stribeck peak"
    equation = r"g(v) = f_c + (f_s + a f_c - f_c)\, e^{-(v / ((1 + b) v_s))^2}"
    side = "motor"
    signature = "torque: odd in the speed, only below three Stribeck velocities; peaks after reversals"
    way_in = "native: static and Stribeck velocity of MuJoCo's LuGre friction"
    confusable_with = ("F4", "F10", "F11", "F14")
    separating_motions = ("speed_ladder", "dwell_restart")
    at_low_speed = True
    needs_friction = True

    level: Array = parameter(
        "a, more breakaway torque as a share of the Coulomb torque",
        unit="1",
        low=0.0,
        high=1.0,
        source="breakaway 1.1 to 2 times Coulomb torque; from memory of the literature",
    )
    velocity: Array = parameter(
        "b, more Stribeck velocity as a share of it",
        unit="1",
        low=-0.5,
        high=1.0,
        minimum=-0.95,
        source="chosen: half to double; it rises with temperature (shape: Bittencourt et al. 2010)",
    )

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """Return the robot with another breakaway torque and Stribeck velocity."""
        friction = robot.friction
        return replace(
            robot,
            friction=replace(
                friction,
                static=friction.static + self.level * friction.coulomb,
                stribeck_velocity=friction.stribeck_velocity * (1 + self.velocity),
            ),
        )
