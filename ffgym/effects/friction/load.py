"""F6: friction that grows with the torque the gearbox carries."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import Side, TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LoadFriction(TorqueEffect):
    """Coulomb friction in proportion to the transmitted torque, as of a gearbox with an efficiency."""

    name: ClassVar[str] = "load_friction"
    code: ClassVar[str] = "F6"
    title: ClassVar[str] = "load-dependent friction"
    equation: ClassVar[str] = r"\tau_f \mathrel{+}= \mu\, |\tau_l| / n \; s(v)"
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = "torque: odd in the speed, amplitude proportional to |gravity + inertia + payload|"
    way_in: ClassVar[str] = "torque at every physics step; MuJoCo has no friction that depends on load"
    confusable_with: ClassVar[tuple[str, ...]] = ("G1", "M3")
    separating_motions: ClassVar[tuple[str, ...]] = ("slow_triangles", "holds")
    needs_friction: ClassVar[bool] = True
    patterns: ClassVar[tuple[tuple[str, str], ...]] = (("sign-locked function", "load"),)

    share: Array = parameter(
        "lost share of the transmitted torque",
        unit="1",
        low=0.0,
        high=0.15,
        minimum=0.0,
        maximum=1.0,
        source="0.06 for a 50:1 and 0.15 for a 100:1 gear unit (parameter files of Rhoban BAM)",
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        lost = self.share * np.abs(state.load_at_motor) * state.friction_sign
        return Torques(motor=-lost), memory
