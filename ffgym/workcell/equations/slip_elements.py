"""Presliding of many asperities: Maxwell-slip elements in parallel, which break loose one after the other."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, TorqueEffect, Torques
from ffgym.effects.effect import Side
from ffgym.effects.parameters import parameter
from ffgym.robot.friction import advance_slip

_YIELDS = np.array([0.25, 0.5, 1.0])
"""Where elements break loose, in units of the last one; chosen: evenly spread in the logarithm."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SlipElements(TorqueEffect):
    r"""Rate-independent hysteresis beside the LuGre bristles.

    .. math:: \tau = -\frac{F}{3} \sum_i x_i / \Delta_i, \quad \dot x_i = v, \quad |x_i| \le \Delta_i

    Reference:
        Al-Bender, Lampaert, Swevers (2005), IEEE TAC 50(11): the generalised Maxwell-slip model, of which this is the
        part that does not depend on speed.
    """

    name: ClassVar[str] = "slip_elements"
    title: ClassVar[str] = "Presliding in steps"
    equation: ClassVar[str] = "tau_f += F/3 sum_i x_i/D_i, |x_i| <= D_i"
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = "loop of torque over displacement after a reversal, the same at any speed"
    way_in: ClassVar[str] = "torque on the motor"

    level: Array = parameter(
        "friction once all elements slip, F, motor side", unit="N m", low=0.0, high=0.2, source="chosen", minimum=0.0
    )
    travel: Array = parameter(
        "displacement at which the last element slips, motor side",
        unit="rad",
        low=0.005,
        high=0.1,
        source="chosen: some presliding displacements of the LuGre model",
        null=None,
        minimum=1e-6,
    )

    def initial_memory(self, state: State) -> Array:
        """Elements at rest carry nothing; shape (..., N, 3)."""
        return np.zeros((*state.motor_angle.shape, len(_YIELDS)))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        total = memory[..., 0] + memory[..., 1] + memory[..., 2]
        widths = self.travel[..., None] * _YIELDS
        after = advance_slip(memory, state.motor_speed, state.motor_speed, dt, widths)
        return Torques(motor=-self.level / len(_YIELDS) * total), after
