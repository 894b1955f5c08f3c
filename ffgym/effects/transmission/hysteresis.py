"""T3: a gearbox that does not spring back all the way."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques
from ffgym.robot.friction import advance_slip, advance_slip_along

SHARES = np.array([0.25, 0.5, 0.75, 1.0])
"""Shares of the yield deflection at which the elements slip. Chosen: four round the corner of the loop off."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TorsionalHysteresis(TorqueEffect):
    r"""Springs that slip, in parallel with the elasticity: Maxwell slip, independent of how fast it goes.

    A loop between deflections :math:`\pm A` beyond the yield deflection takes the energy
    :math:`4\, k\, h\, (A - \bar w)`, with the mean :math:`\bar w` of the widths :math:`w_i`.
    """

    name = "torsional_hysteresis"
    code = "T3"
    title = "torsional hysteresis, lost motion"
    equation = (
        r"\tau_l = -k\, \delta - k\, h\, \tfrac14 \sum_{i=1}^{4} s_i, \quad "
        r"s_i \to \mathrm{clip}(s_i + \Delta \delta / w_i, \pm 1), \quad w_i = \tfrac{i}{4} w"
    )
    side = "link"
    signature = "tool over load: a loop, the same at any speed, that turns where the load turns"
    way_in = "torque at every physics step on the spring, with memory"
    confusable_with = ("F1", "T2", "T4", "T9")
    separating_motions = ("slow_triangles",)
    needs_elasticity = True

    lost_motion: Array = parameter(
        "h, half the width of the loop at no load, link side",
        unit="rad",
        low=0.0,
        high=1.5e-4,
        minimum=0.0,
        source="lost motion of an arc minute or less, data sheets of precision gearboxes; from memory",
    )
    width: Array = parameter(
        "w, deflection after a reversal at which all elements slip, link side",
        tries=(1e-4, 3e-4),
        unit="rad",
        null=None,
        low=1e-4,
        high=5e-4,
        minimum=1e-6,
        default=3e-4,
        source="lost motion is measured within 3 % of rated torque; from memory of data sheets",
    )

    def initial_memory(self, state: State) -> Array:
        """Return relaxed elements."""
        return np.zeros((*state.deflection.shape, len(SHARES)))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the torque of the elements; the last physics step moved the spring by its present rate."""
        rate = state.deflection_rate
        slip = advance_slip(memory, rate, rate, dt, self.width[..., None] * SHARES)
        return self._lost(state, slip), slip

    def torques_over(self, states: State, dt: float) -> Torques:
        """Let elements slip along all samples, then compute all torques at once."""
        rate = np.broadcast_to(states.deflection_rate, states.motor_angle.shape)
        return self._lost(states, advance_slip_along(rate, dt, self.width[..., None] * SHARES))

    def _lost(self, state: State, slip: Array) -> Torques:
        return Torques(spring=-state.joint_stiffness * self.lost_motion * _mean(slip))


def _mean(slip: Array) -> Array:
    """Mean of the elements, added up one by one, so that its bits depend on nothing else."""
    total = slip[..., 0]
    for k in range(1, slip.shape[-1]):
        total = total + slip[..., k]
    mean: Array = total / slip.shape[-1]
    return mean
