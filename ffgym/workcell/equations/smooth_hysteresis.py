"""Hysteresis of the gear's elasticity by the Bouc-Wen model, rounder than elements that stick and slip."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, TorqueEffect, Torques
from ffgym.effects.effect import Side
from ffgym.effects.parameters import parameter


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SmoothHysteresis(TorqueEffect):
    r"""Torque that lags the deflection delta of the elasticity, whatever the rate.

    .. math:: \tau = -h z, \quad \dot z = \frac{\dot\delta}{\delta_y} \left(1 - |z|^p \,
        \frac{1 + \mathrm{sgn}(z \dot\delta)}{2}\right)

    Reference:
        Wen (1976), ASCE Journal of the Engineering Mechanics Division 102(2), with equal parts beta and gamma.
    """

    name: ClassVar[str] = "smooth_hysteresis"
    title: ClassVar[str] = "Hysteresis of the elasticity"
    equation: ClassVar[str] = "tau_spring += h z, Bouc-Wen z of yield dy and exponent p"
    side: ClassVar[Side] = "link"
    signature: ClassVar[str] = "lost motion of the tool where the load changes its direction"
    way_in: ClassVar[str] = "torque in the spring"
    needs_elasticity: ClassVar[bool] = True

    level: Array = parameter(
        "largest hysteresis torque h, link side", unit="N m", low=0.0, high=60.0, source="chosen", minimum=0.0
    )
    yielding: Array = parameter(
        "deflection over which it turns round, link side",
        unit="rad",
        low=2e-5,
        high=5e-4,
        source="chosen: a tenth to one lost motion of an arc minute",
        null=None,
        minimum=1e-7,
    )
    exponent: Array = parameter("p", unit="1", low=1.0, high=3.0, source="chosen", null=None, minimum=1.0)

    def initial_memory(self, state: State) -> Array:
        """Relaxed at rest, shape (..., N, 1)."""
        return np.zeros((*state.motor_angle.shape, 1))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        z, rate = memory[..., 0], state.deflection_rate
        loading = (1 + np.sign(z * rate)) / 2
        moved = z + rate * dt / self.yielding * (1 - np.abs(z) ** self.exponent * loading)
        return Torques(spring=-self.level * z), np.minimum(np.maximum(moved, -1.0), 1.0)[..., None]
