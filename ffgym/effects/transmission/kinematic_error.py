"""T5: the gearbox does not turn its output in exact proportion to its input."""

from dataclasses import dataclass
from typing import final

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
        """Return the torque that winds the spring, and the one that acts back on the motor."""
        error, slope = self.amplitude * self.wave(state.motor_angle), self.lead_slope(state)
        spring = state.joint_stiffness * error + state.joint_damping * slope * state.motor_speed
        return Torques(spring=spring, motor=-(state.load + spring) * slope), memory

    def lead_slope(self, state: State) -> Array:
        """Return the slope of the wave at the motor angle."""
        return self.slope(self.amplitude, state.motor_angle)
