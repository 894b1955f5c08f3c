"""F12: viscous friction that falls while the machine runs."""

from dataclasses import dataclass
from typing import ClassVar, Literal, final

import numpy as np

from ffgym.effects.effect import Side, TorqueEffect
from ffgym.effects.parameter import parameter
from ffgym.effects.state import State, Torques
from ffgym.types import Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ViscousDrift(TorqueEffect):
    """Warm-up where nobody measured a temperature: the description holds when the machine is switched on."""

    name: ClassVar[str] = "viscous_drift"
    code: ClassVar[str] = "F12"
    title: ClassVar[str] = "viscous friction that falls with time, as in a warm-up"
    equation: ClassVar[str] = r"\tau_f \mathrel{+}= c f_v \left( e^{-t / T_w} - 1 \right) v"
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = "torque: odd and linear in the speed, less from motion to motion of a session"
    way_in: ClassVar[str] = "torque at every physics step, from the time that the machine of a climate has run"
    confusable_with: ClassVar[tuple[str, ...]] = ("F2", "F7", "F13")
    separating_motions: ClassVar[tuple[str, ...]] = ("warm_up", "speed_ladder")
    varies_with: ClassVar[tuple[Literal["temperature", "running"], ...]] = ("running",)
    needs_friction: ClassVar[bool] = True

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

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        lost = self.share * np.expm1(-state.running / self.duration)
        return Torques(motor=-lost * state.viscous * state.motor_speed), memory
