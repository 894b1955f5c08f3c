"""Gears that do not turn their output in proportion, and axes that brake each other (T5, T6)."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques
from ffgym.effects.wave import Wave, cycles_per_turn, phase


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class KinematicError(Wave, TorqueEffect):
    r"""Output of the gearbox ahead of or behind the ideal one, periodic in the motor angle.

    The spring is wound by :math:`\delta - e(\theta)` in place of :math:`\delta`. Its energy gives what acts on the
    deflection, :math:`k e + d \dot e`, and what acts back on the motor, :math:`-\tau_l\, \partial e / \partial \theta`,
    with the load :math:`\tau_l` passed on, so that no energy is made. Several on one joint are waves of one error.
    """

    name = "kinematic_error"
    code = "T5"
    title = "kinematic error of the gearbox"
    equation = r"q = \theta / n + A \sin(k \theta + \varphi)"
    side = "link"
    signature = "tool: periodic in the motor angle at any speed; torque: grows with the speed squared"
    way_in = "torque at every physics step on spring and motor"
    confusable_with = ("F9", "M1", "M6")
    separating_motions = ("slow_triangles", "circles")
    needs_elasticity = True
    follows_motor = True
    patterns = (("periodic", "motor angle"),)

    amplitude: Array = parameter(
        "A, link side",
        unit="rad",
        low=0.0,
        high=3e-4,
        minimum=0.0,
        source="0.1 to 0.3 mrad, strain wave gears; from memory of the literature",
    )
    cycles: Array = cycles_per_turn(
        1.0, 2.0, 2.0, "strain wave gears: two per turn of the wave generator, that of the motor"
    )
    phase: Array = phase()

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        error, slope = self.amplitude * self.wave(state.motor_angle), self.lead_slope(state)
        spring = state.joint_stiffness * error + state.joint_damping * slope * state.motor_speed
        return Torques(spring=spring, motor=-(state.load + spring) * slope), memory

    def lead_slope(self, state: State) -> Array:
        """See base class."""
        return self.slope(self.amplitude, state.motor_angle)


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
        """See base class."""
        loss = state.coulomb * state.friction_sign + state.viscous * state.motor_speed
        total = np.zeros_like(loss)
        for j in range(loss.shape[-1]):  # one by one, so that a row's bits depend on nothing else
            total = total - self.share[..., :, j] * loss[..., j : j + 1]
        return Torques(motor=total), memory
