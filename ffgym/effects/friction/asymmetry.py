"""F5: more friction in one direction than in the other."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import Side, TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Asymmetry(TorqueEffect):
    """Coulomb and viscous friction higher forwards and lower backwards by the same share."""

    name: ClassVar[str] = "asymmetry"
    code: ClassVar[str] = "F5"
    title: ClassVar[str] = "friction that depends on direction"
    equation: ClassVar[str] = r"\tau_f \mathrel{+}= a f_c\, |s(v)| + b f_v\, |v|"
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = "torque: even in the speed, an offset while moving that disappears at rest"
    way_in: ClassVar[str] = "torque at every physics step; MuJoCo's friction is symmetric"
    confusable_with: ClassVar[tuple[str, ...]] = ("G3", "M4")
    separating_motions: ClassVar[tuple[str, ...]] = ("holds", "slow_triangles")
    needs_friction: ClassVar[bool] = True
    patterns: ClassVar[tuple[tuple[str, str], ...]] = (
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

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        more = self.coulomb * state.coulomb * np.abs(state.friction_sign)
        return Torques(motor=-(more + self.viscous * state.viscous * np.abs(state.motor_speed))), memory
