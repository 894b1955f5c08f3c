"""Friction that depends on direction, load, speed and place otherwise than LuGre friction (F5 to F14)."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import FrictionEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State
from ffgym.effects.wave import Wave, phase


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Asymmetry(FrictionEffect):
    """Coulomb and viscous friction higher forwards and lower backwards by the same share."""

    name = "asymmetry"
    code = "F5"
    title = "friction that depends on direction"
    equation = r"\tau_f \mathrel{+}= a f_c\, |s(v)| + b f_v\, |v|"
    signature = "torque: even in the speed, an offset while moving that disappears at rest"
    way_in = "torque at every physics step; MuJoCo's friction is symmetric"
    confusable_with = ("G3", "M4")
    separating_motions = ("holds", "slow_triangles")
    patterns = (
        ("sign-locked function", "motor speed"),
        ("function", "size of the motor speed"),
        ("function", "motor speed"),
    )

    coulomb: Array = parameter(
        "a, of the Coulomb torque",
        unit="1",
        low=-0.2,
        high=0.2,
        minimum=-1.0,
        maximum=1.0,
        source="up to 0.2; needed for DC servos (Elhami and Brookfield 1997, as cited in reviews)",
    )
    viscous: Array = parameter(
        "b, of viscous friction", unit="1", low=-0.2, high=0.2, minimum=-1.0, maximum=1.0, source="as a"
    )

    def friction(self, state: State) -> Array:
        """See base class."""
        more = self.coulomb * state.coulomb * np.abs(state.friction_sign)
        return more + self.viscous * state.viscous * np.abs(state.motor_speed)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LoadFriction(FrictionEffect):
    """Coulomb friction in proportion to the transmitted torque, as of a gearbox with an efficiency."""

    name = "load_friction"
    code = "F6"
    title = "load-dependent friction"
    equation = r"\tau_f \mathrel{+}= \mu\, |\tau_l| / n \; s(v)"
    signature = "torque: odd in the speed, amplitude proportional to |gravity + inertia + payload|"
    way_in = "torque at every physics step; MuJoCo has no friction that depends on load"
    confusable_with = ("G1", "M3")
    separating_motions = ("slow_triangles", "holds")
    patterns = (("sign-locked function", "load"),)

    share: Array = parameter(
        "lost share of the transmitted torque",
        unit="1",
        low=0.0,
        high=0.15,
        minimum=0.0,
        maximum=1.0,
        source="0.06 for a 50:1 and 0.15 for a 100:1 gear unit (parameter files of Rhoban BAM)",
    )

    def friction(self, state: State) -> Array:
        """See base class."""
        return self.share * np.abs(state.load_at_motor) * state.friction_sign


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class NonlinearViscous(FrictionEffect):
    """Viscous friction with a square term; a negative one is a lubricant that thins when it is sheared."""

    name = "nonlinear_viscous"
    code = "F8"
    title = "nonlinear viscous friction"
    equation = r"\tau_f \mathrel{+}= a f_v\, v\, |v| / v_r"
    signature = "torque: odd in the speed, curved at high speed"
    way_in = (
        "torque at every physics step; MuJoCo's damping polynomial would do, but a recording is evaluated by the same "
        "formula"
    )
    confusable_with = ("F2", "F7")
    separating_motions = ("speed_ladder",)
    patterns = (
        ("sign-locked function", "size of the motor speed"),
        ("function", "motor speed"),
    )

    share: Array = parameter(
        "a, more viscous friction at speed v_r, as a share of it",
        unit="1",
        low=-0.3,
        high=0.3,
        source="chosen: a third of viscous friction at top speed",
    )
    speed: Array = parameter(
        "v_r, motor side",
        unit="rad/s",
        null=None,
        low=100.0,
        high=600.0,
        minimum=1e-3,
        default=300.0,
        scale="top_speed",
        source="top speed of robot motors, 1000 to 6000 turns per minute",
    )

    def friction(self, state: State) -> Array:
        """See base class."""
        v = state.motor_speed
        return self.share * state.viscous * v * np.abs(v) / self.speed


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PositionFriction(Wave, FrictionEffect):
    """Coulomb friction that rises and falls along the joint's turn."""

    name = "position_friction"
    code = "F9"
    title = "position-dependent friction"
    equation = r"\tau_f \mathrel{+}= a f_c \sin(k q + \varphi)\, s(v)"
    signature = "torque: sign of the speed times a periodic function of the joint angle"
    confusable_with = ("M1", "T5")
    separating_motions = ("slow_triangles", "speed_ladder")
    patterns = (("sign-locked function", "motor angle"),)

    share: Array = parameter(
        "a, of the Coulomb torque",
        unit="1",
        low=0.0,
        high=0.2,
        minimum=0.0,
        maximum=1.0,
        source="up to 0.2; from memory of the literature",
    )
    cycles: Array = parameter(
        "k, per radian of the joint (per metre of a slide)",
        role="cycles",
        unit="1/rad",
        null=None,
        low=1.0,
        high=40.0,
        minimum=0.0,
        default=10.0,
        tries=(1.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0),
        source="chosen: from a turn of the joint to that of a planet wheel",
    )
    phase: Array = phase("any")

    def friction(self, state: State) -> Array:
        """See base class."""
        level = self.share * state.coulomb * self.wave(state.joint_angle)
        return level * state.friction_sign


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class StribeckExponent(FrictionEffect):
    """Stribeck curve of the description with another exponent; height and width stay."""

    name = "stribeck_exponent"
    code = "F11"
    title = "exponent of the Stribeck curve"
    equation = r"\tau_f \mathrel{+}= (f_s - f_c) \left( e^{-|v / v_s|^a} - e^{-(v / v_s)^2} \right) s(v)"
    signature = "torque: odd in the speed, changes sign at the Stribeck velocity, gone above three of it"
    way_in = "torque at every physics step; MuJoCo's exponent is 2"
    confusable_with = ("F3", "F14")
    separating_motions = ("speed_ladder",)
    at_low_speed = True

    exponent: Array = parameter(
        "a",
        unit="1",
        null=2.0,
        low=0.5,
        high=3.0,
        minimum=0.1,
        source="0.5 to 3 in the literature, 1.1 to 3 in the parameter files of Rhoban BAM",
    )

    def friction(self, state: State) -> Array:
        """See base class."""
        x = np.abs(state.motor_speed / state.stribeck_velocity)
        peak = (state.static - state.coulomb) * (np.exp(-(x**self.exponent)) - np.exp(-(x**2)))
        return peak * state.friction_sign


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FallingFriction(FrictionEffect):
    """A further peak at low speed with wide skirts, or a narrow tip: of its own width and exponent.

    Reference:
        Armstrong-Helouvry, Dupont, Canudas de Wit (1994), Automatica 30(7): exponents of Stribeck curves from 0.5 to 2
        and the Lorentz form, which exponents little above 1 come near to.
    """

    name = "falling_friction"
    code = "F14"
    title = "friction that falls with speed"
    equation = r"\tau_f \mathrel{+}= a f_c\, e^{-|v / (w v_s)|^p}\, s(v)"
    signature = "torque: odd in the speed, largest after reversals, still there at many Stribeck velocities"
    way_in = "torque at every physics step; MuJoCo's exponent is 2"
    confusable_with = ("F3", "F10", "F11")
    separating_motions = ("speed_ladder", "dwell_restart")
    at_low_speed = True
    generalises = ("stribeck_peak",)
    patterns = (("sign-locked function", "size of the motor speed"),)

    share: Array = parameter(
        "a, of the Coulomb torque",
        unit="1",
        low=0.0,
        high=1.0,
        minimum=0.0,
        source="as the level of stribeck_peak",
    )
    width: Array = parameter(
        "w, of the Stribeck velocity",
        unit="1",
        null=None,
        low=0.3,
        high=3.0,
        minimum=0.01,
        default=1.0,
        tries=(0.7, 1.5),
        source="chosen: a third to three times; beyond that it is a Coulomb level",
    )
    exponent: Array = parameter(
        "p",
        unit="1",
        null=None,
        low=0.5,
        high=3.0,
        minimum=0.1,
        default=1.0,
        tries=(0.9, 2.0),
        source="0.5 to 3 in the literature, 1.1 to 3 in the parameter files of Rhoban BAM",
    )

    def friction(self, state: State) -> Array:
        """See base class."""
        x = np.abs(state.motor_speed / (self.width * state.stribeck_velocity))
        peak = self.share * state.coulomb * np.exp(-(x**self.exponent))
        return peak * state.friction_sign
