"""F14: friction that falls with speed in another way than the Stribeck curve of MuJoCo."""

from dataclasses import dataclass
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import FrictionEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State
from ffgym.robot.friction import stribeck_decay


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
        """Return the further peak at low speed."""
        decay = stribeck_decay(state.motor_speed, self.width * state.stribeck_velocity, self.exponent)
        return self.share * state.coulomb * decay * state.friction_sign
