"""T4: teeth that have room between them."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Backlash(TorqueEffect):
    """A gap in the middle of the spring's travel, in which it neither pulls nor damps."""

    name = "backlash"
    code = "T4"
    title = "backlash"
    equation = r"\tau_l = -k\, (\delta - \mathrm{clip}(\delta, \pm b)) - d\, \dot\delta\; [\,|\delta| \ge b\,]"
    side = "link"
    signature = "tool: a jump of 2 b where the load changes sign; torque: a dip, the motor runs free"
    way_in = "torque at every physics step on the spring"
    confusable_with = ("F1", "T3", "T9", "X6")
    separating_motions = ("slow_triangles", "holds")
    needs_elasticity = True

    half_gap: Array = parameter(
        "b, link side",
        unit="rad",
        low=0.0,
        high=3e-4,
        minimum=0.0,
        source="an arc minute or less in all when new, two when worn; from memory of data sheets",
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the torque that takes spring and damper away within the gap."""
        bent = state.deflection
        gap = np.minimum(np.maximum(bent, -self.half_gap), self.half_gap)
        free = np.abs(bent) < self.half_gap
        damping = np.where(free, state.joint_damping * state.deflection_rate, 0.0)
        return Torques(spring=state.joint_stiffness * gap + damping), memory
