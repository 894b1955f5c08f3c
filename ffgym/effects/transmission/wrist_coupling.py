"""T6: friction of one axis that brakes another."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class WristCoupling(TorqueEffect):
    r"""A share of the Coulomb and viscous friction of motor j is borne by motor i, as where shafts run in each other.

    The exact loss is :math:`-c f(v_j + c\, v_i)` on motor i, which only takes energy; this is its first order in c.
    """

    name = "wrist_coupling"
    code = "T6"
    title = "coupling losses of the wrist"
    equation = r"\tau_{f,i} \mathrel{+}= \sum_{j \ne i} c_{ij} \left( f_{c,j}\, s(v_j) + f_{v,j}\, v_j \right)"
    side = "motor"
    signature = "torque of one joint: locked to the sign of another joint's speed"
    way_in = "torque at every physics step"
    confusable_with = ("F1", "G1")
    separating_motions = ("speed_ladder", "excitation")
    needs_friction = True

    share: Array = parameter(
        "c_ij, row: motor that is braked, column: motor that turns; 0 on the diagonal",
        unit="1",
        low=-0.3,
        high=0.3,
        per="pair",
        source="friction shares of 5 to 30 % between axes 4, 5 and 6; from memory of the literature",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if np.any(np.diagonal(self.share)):
            raise FFGymError(
                f"wrist_coupling.share has {np.diagonal(self.share).tolist()} on its diagonal, must be 0; more "
                f"friction of a motor itself is coulomb_level and viscous_level."
            )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the losses that each motor bears for the others."""
        loss = state.coulomb * state.friction_sign + state.viscous * state.motor_speed
        total = np.zeros_like(loss)
        for j in range(loss.shape[-1]):  # one by one, so that a row's bits depend on nothing else
            total = total - self.share[..., :, j] * loss[..., j : j + 1]
        return Torques(motor=total), memory
