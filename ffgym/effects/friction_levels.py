"""Friction of the description with other numbers: levels, Stribeck peak, bristles (F1 to F4)."""

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
    confusable_with = ("F7", "F13", "T3", "T4", "T6")
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
        """See base class."""
        friction = robot.friction
        more = self.change * friction.coulomb
        return replace(
            robot, friction=replace(friction, coulomb=friction.coulomb + more, static=friction.static + more)
        )


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
        """See base class."""
        return replace(robot, friction=robot.friction.scaled(viscous=1 + self.change))


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
        """See base class."""
        friction = robot.friction
        return replace(
            robot,
            friction=replace(
                friction,
                static=friction.static + self.level * friction.coulomb,
                stribeck_velocity=friction.stribeck_velocity * (1 + self.velocity),
            ),
        )


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
    confusable_with = ("F3", "F10")
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
        """See base class."""
        more = robot.friction.scaled(bristle_stiffness=1 + self.stiffness, bristle_damping=1 + self.damping)
        return replace(robot, friction=more)
