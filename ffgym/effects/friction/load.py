"""F6: friction that grows with the torque the gearbox carries."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import FrictionEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LoadFriction(FrictionEffect):
    """Coulomb friction in proportion to the transmitted torque, as of a gearbox with an efficiency."""

    name = "load_friction"
    code = "F6"
    title = "load-dependent friction"
    equation = r"\tau_f \mathrel{+}= \mu\, |\tau_l| / n \; s(v)"
    signature = "torque: odd in the speed, amplitude proportional to |gravity + inertia + payload|"
    way_in = "torque at every physics step; MuJoCo has no friction that depends on load"
    confusable_with = ("G1", "M3", "T10")
    separating_motions = ("slow_triangles", "holds")
    patterns = (("sign-locked function", "load"),)

    share: Array = parameter(
        "lost share of the transmitted torque",
        unit="1",
        low=0.0,
        high=0.15,
        minimum=0.0,
        maximum=1.0,
        source="0.06 for a 50:1 and 0.15 for a 100:1 gear unit (parameter files of Rhoban BAM)",
    )

    def friction(self, state: State) -> Array:
        """Return the share of the transmitted torque that the gearbox loses."""
        return self.share * np.abs(state.load_at_motor) * state.friction_sign
