"""K1: a servo that is tuned otherwise than documented."""

from dataclasses import dataclass, replace
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import NativeEffect
from ffgym.effects.parameters import parameter
from ffgym.robot import RobotDescription


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ServoGains(NativeEffect):
    """Other gains in the machine's servos than in the description that its controller is computed from."""

    name = "servo_gains"
    code = "K1"
    title = "servo gains"
    equation = r"K_p \to (1 + a) K_p, \quad K_v \to (1 + b) K_v, \quad K_i \to (1 + c) K_i"
    side = "controller"
    signature = "tracking error other than simulated, while the torque over the motion fits"
    way_in = "native: gains of MuJoCo's pid actuator"
    separating_motions = ("excitation", "circles")

    position: Array = parameter("a", unit="1", low=-0.3, high=0.3, minimum=-0.9, source="chosen: a retuned servo")
    velocity: Array = parameter("b", unit="1", low=-0.3, high=0.3, minimum=-0.9, source="as a")
    integral: Array = parameter("c", unit="1", low=-0.5, high=0.5, minimum=-1.0, source="as a, and integrals more so")

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """Return the robot with the gains that its servos really have."""
        servo = robot.servo
        tuned = replace(
            servo,
            position_gain=servo.position_gain * (1 + self.position),
            velocity_gain=servo.velocity_gain * (1 + self.velocity),
            integral_gain=servo.integral_gain * (1 + self.integral),
        )
        return replace(robot, servo=tuned)
