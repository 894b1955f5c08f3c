"""G2: a motor that is heavier to turn than described."""

from dataclasses import dataclass, replace
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import NativeEffect
from ffgym.effects.parameters import parameter
from ffgym.robot import RobotDescription


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RotorInertia(NativeEffect):
    """More inertia of motor, brake and gear input."""

    name = "rotor_inertia"
    code = "G2"
    title = "rotor inertia"
    equation = r"J_m \to (1 + a)\, J_m"
    side = "motor"
    signature = "torque: proportional to the motor's own acceleration, on one joint only"
    way_in = "native: armature of the motor joint"
    confusable_with = ("G1", "M5", "T8")
    separating_motions = ("excitation",)
    patterns = (("function", "motor acceleration"),)

    change: Array = parameter(
        "a, more rotor inertia as a share of it",
        unit="1",
        low=-0.2,
        high=0.2,
        minimum=-0.9,
        source="chosen: brakes and gear inputs that data sheets leave out",
        of=("drive", "rotor_inertia"),
    )

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """Return the robot with another rotor inertia."""
        drive = robot.drive
        return replace(robot, drive=replace(drive, rotor_inertia=drive.rotor_inertia * (1 + self.change)))
