"""Motor, current loop and servo: what becomes of the torque that is commanded (M1 to M4, K1)."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import NativeEffect, TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques
from ffgym.effects.wave import Wave, cycles_per_turn, phase
from ffgym.robot import RobotDescription


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Cogging(Wave, TorqueEffect):
    """Torque between magnets and teeth of the motor, without any current."""

    name = "cogging"
    code = "M1"
    title = "cogging"
    equation = r"\tau \mathrel{+}= A \sin(k \theta + \varphi)"
    side = "motor"
    signature = "torque: periodic in the motor angle, the same at any load, speed and direction"
    way_in = (
        "torque at every physics step; MuJoCo's dcmotor has cogging, but it would hide in the actuator that is the "
        "friction, and a recording is evaluated by the same formula"
    )
    confusable_with = ("F9", "M2", "T5")
    separating_motions = ("slow_triangles", "holds")
    patterns = (("periodic", "motor angle"),)

    amplitude: Array = parameter(
        "A, motor side",
        unit="N m",
        low=0.0,
        high=0.3,
        minimum=0.0,
        source="1 to 5 % of rated torque (MuJoCo's documentation of dcmotor), here of motors of 2 to 8 N m",
    )
    cycles: Array = cycles_per_turn(
        1.0, 72.0, 24.0, "least common multiple of poles and slots, 12 to 72, and 1 to 6 by eccentricity"
    )
    phase: Array = phase()

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        return Torques(motor=self.amplitude * self.wave(state.motor_angle)), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueRipple(Wave, TorqueEffect):
    """Torque that is more and less than commanded, by a share that is periodic in the motor angle."""

    name = "torque_ripple"
    code = "M2"
    title = "torque ripple"
    equation = r"\tau \mathrel{+}= r\, u \sin(k \theta + \varphi)"
    side = "motor"
    signature = "torque: periodic in the motor angle, amplitude proportional to the torque"
    way_in = "torque at every physics step, a share of what the servo commands"
    confusable_with = ("M1",)
    separating_motions = ("slow_triangles", "holds")
    patterns = (("periodic", "motor angle"),)

    share: Array = parameter(
        "r", unit="1", low=0.0, high=0.05, minimum=0.0, maximum=1.0, source="1 to 5 %; from memory of the literature"
    )
    cycles: Array = cycles_per_turn(1.0, 36.0, 6.0, "1, 2 and 6 times the electrical angle, with 1 to 6 pole pairs")
    phase: Array = phase()

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        return Torques(motor=self.share * state.motor_torque * self.wave(state.motor_angle)), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueConstant(TorqueEffect):
    """Torque per current other than documented, lower when the magnets are warm, and lower near the peak torque."""

    name = "torque_constant"
    code = "M3"
    title = "torque constant and saturation"
    equation = r"\tau \mathrel{+}= u \left( e + m (T - T_r) - c\, (u / u_{peak})^2 \right)"
    side = "motor"
    signature = "torque: a share of all of it, gravity, inertia and friction alike"
    way_in = "torque at every physics step, a share of what the servo commands"
    confusable_with = ("F6",)
    separating_motions = ("holds", "slow_triangles")
    patterns = (("function", "load"),)

    error: Array = parameter(
        "e", unit="1", low=-0.1, high=0.1, minimum=-0.9, source="tolerance of magnets and current sensors, 10 %"
    )
    saturation: Array = parameter(
        "c, share lost at peak torque",
        unit="1",
        low=0.0,
        high=0.2,
        minimum=0.0,
        maximum=0.3,
        source="chosen; above 1/3 more current would give less torque",
    )
    magnets: Array = parameter(
        "m, by temperature",
        unit="1/K",
        low=-0.002,
        high=0.0,
        source="-0.1 %/K for NdFeB, -0.2 %/K for ferrite magnets; from memory of data sheets",
    )
    reference: Array = parameter(
        "T_r, temperature at which the documented constant holds",
        unit="degC",
        null=None,
        low=20.0,
        high=60.0,
        minimum=-40.0,
        default=20.0,
        source="chosen: from the room's to that of a warm motor",
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        u = state.motor_torque
        warm = self.magnets * (state.temperature - self.reference)
        return Torques(motor=u * (self.error + warm - self.saturation * (u / state.peak_torque) ** 2)), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueOffset(TorqueEffect):
    """Offset of the current sensors."""

    name = "torque_offset"
    code = "M4"
    title = "torque offset"
    equation = r"\tau \mathrel{+}= c"
    side = "motor"
    signature = "torque: constant, at rest too"
    way_in = "torque at every physics step"
    confusable_with = ("F5", "G3")
    separating_motions = ("holds", "slow_triangles")

    offset: Array = parameter(
        "c, motor side",
        unit="N m",
        low=-0.1,
        high=0.1,
        source="up to 1 % of rated torque, here of motors of 2 to 8 N m",
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        return Torques(motor=self.offset + np.zeros_like(state.motor_angle)), memory


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
        """See base class."""
        servo = robot.servo
        tuned = replace(
            servo,
            position_gain=servo.position_gain * (1 + self.position),
            velocity_gain=servo.velocity_gain * (1 + self.velocity),
            integral_gain=servo.integral_gain * (1 + self.integral),
        )
        return replace(robot, servo=tuned)
