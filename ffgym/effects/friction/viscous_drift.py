"""F12: viscous friction that falls while the machine runs."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import FrictionEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State

_REFERENCE = 100.0
"""v_r [rad/s], motor side; chosen: 1000 turns per minute, a medium speed of robot motors."""


_NEAR_REST = 1e-3
"""Speed, over that, below which the power law goes over into a straight line; chosen: less than any that is held."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ViscousDrift(FrictionEffect):
    r"""Warm-up without measured temperature: the description holds when the machine is switched on.

    What is lost grows with the speed as the friction of a power-law fluid does, as greases are (shear thinning, p < 1),
    and is the share c at :math:`v_r` = 100 rad/s.
    """

    name = "viscous_drift"
    code = "F12"
    title = "viscous friction that falls with time, as in a warm-up"
    equation = (
        r"\tau_f \mathrel{+}= c f_v \left( e^{-t / T_w} - 1 \right) v_r \left| v / v_r \right|^p \operatorname{sgn}(v)"
    )
    signature = "torque: odd in the speed and growing with it, less from motion to motion of a session"
    way_in = "torque at every physics step, from the time that the machine of a climate has run"
    confusable_with = ("F2", "F7", "F13")
    separating_motions = ("warm_up", "speed_ladder")
    varies_with = ("running",)
    patterns = (("sign-locked function", "time"),)

    share: Array = parameter(
        "c, share of viscous friction that is lost in the end",
        unit="1",
        low=0.0,
        high=0.5,
        minimum=-1.0,
        maximum=1.0,
        source="halves over about 20 K of warm-up (Bittencourt et al. 2010); from memory of the literature",
    )
    duration: Array = parameter(
        "T_w, time after which 63 % of it is lost",
        unit="s",
        null=None,
        low=300.0,
        high=7200.0,
        minimum=1.0,
        default=1800.0,
        tries=(600.0, 1800.0, 5400.0),
        source="5 to 20 min of a gearbox (simulator of FloBaRoID) to some hours of a heavy arm",
    )

    exponent: Array = parameter(
        "p, of the speed",
        unit="1",
        null=None,
        low=0.3,
        high=1.0,
        minimum=0.1,
        maximum=2.0,
        default=1.0,
        source="1: an oil; flow index of lubricating greases 0.3 to 1; from memory of the literature",
    )

    def friction(self, state: State) -> Array:
        """Return the change of viscous friction since the machine was switched on."""
        lost = self.share * np.expm1(-state.running / self.duration)
        faster = (state.motor_speed / _REFERENCE) ** 2 + _NEAR_REST**2
        thinned = faster ** (0.5 * (self.exponent - 1.0))
        return lost * state.viscous * state.motor_speed * thinned
