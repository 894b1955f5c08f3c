"""F7: friction that changes while the machine warms up."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import FrictionEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State
from ffgym.robot.friction import stribeck_decay


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TemperatureFriction(FrictionEffect):
    """Viscous friction falls exponentially with temperature; Coulomb torque and Stribeck peak change linearly.

    Reference:
        Bittencourt, Wernholt, Sander-Tavallaey, Brogardh (2010), "An extended friction model to capture load and
        temperature effects in robot joints", IROS: the shapes, not the numbers.
    """

    name = "temperature_friction"
    code = "F7"
    title = "temperature-dependent friction"
    equation = (
        r"\tau_f \mathrel{+}= c f_v \left( e^{-\Delta T / T_o} - 1 \right) v + \Delta T "
        r"\left( a f_c + b f_s\, e^{-(v / v_s)^2} \right) s(v), \quad \Delta T = T - T_r"
    )
    signature = "torque: odd in the speed, drifts along the session with the temperature"
    way_in = "torque at every physics step, from the temperature of the machine's climate"
    confusable_with = ("F1", "F2", "F8", "F12", "F13")
    separating_motions = ("warm_up", "speed_ladder")
    varies_with = ("temperature",)
    patterns = (("sign-locked function", "temperature"),)

    viscous: Array = parameter(
        "c, share of viscous friction that depends on temperature",
        unit="1",
        low=0.0,
        high=1.0,
        minimum=0.0,
        maximum=1.0,
        source="lubricant in the gearbox, seals not; all of it at most",
    )
    scale: Array = parameter(
        "T_o, rise over which that share falls to 37 %",
        unit="K",
        null=None,
        low=15.0,
        high=60.0,
        minimum=1.0,
        default=25.0,
        source="viscous friction halves over about 20 K; 19 to 51 degC studied by Park et al. 2022",
    )
    coulomb: Array = parameter(
        "a, of the Coulomb torque",
        unit="1/K",
        low=-0.005,
        high=0.005,
        source="12 % over a warm-up of some 20 K (simulator of FloBaRoID)",
    )
    breakaway: Array = parameter(
        "b, of the breakaway torque", unit="1/K", low=-0.005, high=0.01, source="chosen: as a, and more when cold"
    )
    reference: Array = parameter(
        "T_r, temperature at which the description holds",
        unit="degC",
        null=None,
        low=20.0,
        high=60.0,
        minimum=-40.0,
        default=20.0,
        source="chosen: from the room's to that of a warm gearbox",
    )

    def friction(self, state: State) -> Array:
        """Return the change of friction at the present temperature."""
        warmer, v = state.temperature - self.reference, state.motor_speed
        viscous = self.viscous * state.viscous * np.expm1(-warmer / self.scale) * v
        peak = state.static * stribeck_decay(v, state.stribeck_velocity)
        level = warmer * (self.coulomb * state.coulomb + self.breakaway * peak) * state.friction_sign
        return viscous + level
