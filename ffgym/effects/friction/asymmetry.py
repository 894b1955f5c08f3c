"""F5: more friction in one direction than in the other."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import FrictionEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Asymmetry(FrictionEffect):
    """Coulomb and viscous friction higher forwards and lower backwards by the same share."""

    name = "asymmetry"
    code = "F5"
    title = "friction that depends on direction"
    equation = r"\tau_f \mathrel{+}= a f_c\, |s(v)| + b f_v\, |v|"
    signature = "torque: even in the speed, an offset while moving that disappears at rest"
    way_in = "torque at every physics step; MuJoCo's friction is symmetric"
    confusable_with = ("G3", "M4")
    separating_motions = ("holds", "slow_triangles")
    patterns = (
        ("sign-locked function", "motor speed"),
        ("function", "size of the motor speed"),
        ("function", "motor speed"),
    )

    coulomb: Array = parameter(
        "a, of the Coulomb torque",
        unit="1",
        low=-0.2,
        high=0.2,
        minimum=-1.0,
        maximum=1.0,
        source="up to 0.2; needed for DC servos (Elhami and Brookfield 1997, as cited in reviews)",
    )
    viscous: Array = parameter(
        "b, of viscous friction", unit="1", low=-0.2, high=0.2, minimum=-1.0, maximum=1.0, source="as a"
    )

    def friction(self, state: State) -> Array:
        """Return the part of the friction that is even in the speed."""
        more = self.coulomb * state.coulomb * np.abs(state.friction_sign)
        return more + self.viscous * state.viscous * np.abs(state.motor_speed)
