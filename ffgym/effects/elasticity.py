"""The spring between motor and link: stiffness, hardening, hysteresis, backlash (T1 to T4)."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import NativeEffect, TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques
from ffgym.robot import RobotDescription
from ffgym.robot.friction import advance_slip, advance_slip_along


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class JointStiffness(NativeEffect):
    """Another stiffness of the joints; their damping follows, so that the damping ratio stays."""

    name = "joint_stiffness"
    code = "T1"
    title = "joint stiffness"
    equation = r"k \to (1 + e)\, k, \quad d \to \sqrt{1 + e}\, d"
    side = "link"
    signature = "tool: proportional to the load of each joint, over its stiffness; torque: near resonance"
    way_in = "native: stiffness and damping of the deflection joint"
    confusable_with = ("G1", "T2", "T7", "T8", "X1", "X2")
    separating_motions = ("holds", "excitation")
    needs_elasticity = True

    change: Array = parameter(
        "e, more stiffness as a share of it",
        unit="1",
        low=-0.3,
        high=0.3,
        minimum=-0.9,
        source="tolerance of gearboxes' torsional stiffness, 20 to 30 %; from memory of data sheets",
        of=("drive", "joint_stiffness"),
    )

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """See base class."""
        drive, factor = robot.drive, 1 + self.change
        stiffer = replace(
            drive,
            joint_stiffness=drive.joint_stiffness * factor,
            joint_damping=drive.joint_damping * np.sqrt(factor),
        )
        return replace(robot, drive=stiffer)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Hardening(TorqueEffect):
    """Stiffness that grows with the square of the deflection; the described one is that at no load."""

    name = "hardening"
    code = "T2"
    title = "hardening stiffness"
    equation = r"\tau_l = -k\, \delta\, (1 + h\, \delta^2)"
    side = "link"
    signature = "tool over load: bent like an S, with a third harmonic"
    way_in = (
        "torque at every physics step on the spring; MuJoCo's stiffness polynomial would do, but a recording is "
        "evaluated by the same formula"
    )
    confusable_with = ("T1", "T3")
    separating_motions = ("holds", "excitation")
    needs_elasticity = True

    growth: Array = parameter(
        "h",
        unit="1/rad^2",
        low=0.0,
        high=5e5,
        minimum=0.0,
        source="slope 1.5 to 4 times as steep at rated torque, 1 to 1.5 mrad, as at none; strain wave gears, "
        "from memory of the literature",
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        bent = state.deflection
        return Torques(spring=-state.joint_stiffness * self.growth * (bent * bent * bent)), memory


SHARES = np.array([0.25, 0.5, 0.75, 1.0])
"""Of the yield deflection, at which the elements slip. Chosen: four round the corner of the loop off."""


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
    confusable_with = ("F1", "T2", "T4")
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
        """See base class; elements are relaxed."""
        return np.zeros((*state.deflection.shape, len(SHARES)))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class; the last physics step moved the spring by its present rate."""
        rate = state.deflection_rate
        slip = advance_slip(memory, rate, rate, dt, self.width[..., None] * SHARES)
        return self._lost(state, slip), slip

    def torques_over(self, states: State, dt: float) -> Torques:
        """See base class."""
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
    confusable_with = ("F1", "T3", "X6")
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
        """See base class."""
        bent = state.deflection
        gap = np.minimum(np.maximum(bent, -self.half_gap), self.half_gap)
        free = np.abs(bent) < self.half_gap
        damping = np.where(free, state.joint_damping * state.deflection_rate, 0.0)
        return Torques(spring=state.joint_stiffness * gap + damping), memory
