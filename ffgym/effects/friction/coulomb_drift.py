"""F13: Coulomb friction that changes while the machine runs."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import FrictionEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CoulombDrift(FrictionEffect):
    """Coulomb friction that grows or falls with the time of a session: seals and preload that warm up, or run in."""

    name = "coulomb_drift"
    code = "F13"
    title = "Coulomb friction that changes with time"
    equation = r"\tau_f \mathrel{+}= c f_c \left( 1 - e^{-t / T_w} \right) s(v)"
    signature = "torque: square wave locked to the sign of the speed, other from motion to motion"
    way_in = "torque at every physics step, from the time that the machine of a climate has run"
    confusable_with = ("F1", "F7", "F12")
    separating_motions = ("warm_up", "slow_triangles")
    varies_with = ("running",)
    patterns = (("sign-locked function", "time"),)

    share: Array = parameter(
        "c, change in the end as a share of the Coulomb torque",
        unit="1",
        low=-0.3,
        high=0.3,
        minimum=-1.0,
        source="12 % over a warm-up (simulator of FloBaRoID), and as much again for wear; chosen",
    )
    duration: Array = parameter(
        "T_w, time after which 63 % of it has happened",
        unit="s",
        null=None,
        low=300.0,
        high=7200.0,
        minimum=1.0,
        default=1800.0,
        tries=(600.0, 1800.0, 5400.0),
        source="as of viscous_drift",
    )

    def friction(self, state: State) -> Array:
        """Return the change of Coulomb friction since the machine was switched on."""
        more = -self.share * np.expm1(-state.running / self.duration)
        return more * state.coulomb * state.friction_sign
