"""F11: a breakaway peak that falls off with another power of the speed than MuJoCo's."""

from dataclasses import dataclass
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import FrictionEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State
from ffgym.robot.friction import stribeck_decay


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
        """Return the difference of both Stribeck curves."""
        speed, velocity = state.motor_speed, state.stribeck_velocity
        change = stribeck_decay(speed, velocity, self.exponent) - stribeck_decay(speed, velocity)
        return (state.static - state.coulomb) * change * state.friction_sign
