"""M4: a motor that gives torque when none is commanded."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueOffset(TorqueEffect):
    """Offset of the current sensors."""

    name = "torque_offset"
    code = "M4"
    title = "torque offset"
    equation = r"\tau \mathrel{+}= c"
    side = "motor"
    signature = "torque: constant, at rest too"
    way_in = "torque at every physics step"
    confusable_with = ("F5", "G3")
    separating_motions = ("holds", "slow_triangles")

    offset: Array = parameter(
        "c, motor side",
        unit="N m",
        low=-0.1,
        high=0.1,
        source="up to 1 % of rated torque, here of motors of 2 to 8 N m",
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the offset, whatever the motion."""
        return Torques(motor=self.offset + np.zeros_like(state.motor_angle)), memory
