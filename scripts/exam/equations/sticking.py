"""What happens before and just after contacts slip: Maxwell slip for bristles, rate and state for ageing."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, TorqueEffect, Torques
from ffgym.effects.effect import Side
from ffgym.effects.parameters import parameter
from ffgym.robot.friction import advance_slip
from scripts.exam.equations.variant import Variant

_WIDTHS = np.array([0.25, 0.5, 0.75, 1.0])
"""Where elements break loose, in units of the last one; chosen: even."""

_LONG = 10.0
"""Rest [s] at which the breakaway torque has grown by its share; also what a machine at rest has rested."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class MaxwellSlip(Variant, TorqueEffect):
    r"""A share of the friction is carried by springs that break loose one after the other, not by bristles.

    In sliding both carry the same. Stiffer than the bristles if they break loose earlier than these.

    Reference:
        Al-Bender, Lampaert, Swevers (2005), IEEE TAC 50(11): generalised Maxwell slip, without its dynamics in sliding.
    """

    name: ClassVar[str] = "maxwell_slip"
    variant_of: ClassVar[str] = "presliding"
    title: ClassVar[str] = "presliding by Maxwell slip"
    equation: ClassVar[str] = (
        r"\tau_f \mathrel{+}= a f_c \left( \tfrac14 \sum_i x_i / \Delta_i - s(v) \right), \quad "
        r"\dot x_i = v,\; |x_i| \le \Delta_i"
    )
    side: ClassVar[Side] = "motor"
    needs_friction: ClassVar[bool] = True

    share: Array = parameter(
        "a, of the Coulomb torque", unit="1", low=0.0, high=0.8, minimum=0.0, maximum=1.0, source="chosen: most of it"
    )
    travel: Array = parameter(
        "travel at which the last element slips, motor side",
        unit="rad",
        null=None,
        low=0.02,
        high=0.06,
        minimum=1e-6,
        source="chosen: wider than the bristles of the built-in robots, 8 mrad",
    )

    def initial_memory(self, state: State) -> Array:
        """Elements at rest carry nothing; shape (..., N, 4)."""
        return np.zeros((*state.motor_angle.shape, len(_WIDTHS)))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        carried = (memory[..., 0] + memory[..., 1] + memory[..., 2] + memory[..., 3]) / len(_WIDTHS)
        later = advance_slip(memory, state.motor_speed, state.motor_speed, dt, self.travel[..., None] * _WIDTHS)
        return Torques(motor=-self.share * state.coulomb * (carried - state.friction_sign)), later


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RateAndState(Variant, TorqueEffect):
    r"""Breakaway that grows with the logarithm of the time of rest, and is used up by slip.

    The memory :math:`\theta` is the age of the contacts [s]; the exact solution at constant speed is taken.

    Reference:
        Dieterich (1979), J. Geophys. Res. 84(B5): rate- and state-dependent friction with its ageing law.
    """

    name: ClassVar[str] = "rate_and_state"
    variant_of: ClassVar[str] = "dwell_stiction"
    title: ClassVar[str] = "breakaway that grows with the logarithm of the time of rest"
    equation: ClassVar[str] = (
        r"\tau_f \mathrel{+}= a f_s \frac{\ln(1 + \theta / t_0)}{\ln(1 + 10\,\mathrm{s} / t_0)}\, s(v), \quad "
        r"\dot\theta = 1 - \theta\, |v| / x_s"
    )
    side: ClassVar[Side] = "motor"
    needs_friction: ClassVar[bool] = True

    share: Array = parameter(
        "a, of the breakaway torque, after ten seconds of rest",
        unit="1",
        low=0.0,
        high=0.5,
        minimum=0.0,
        source="as dwell_stiction",
    )
    time: Array = parameter(
        "t_0, rest after which growth is felt", unit="s", null=None, low=0.05, high=0.5, minimum=1e-3, source="chosen"
    )
    slip: Array = parameter(
        "x_s, slip that renews contacts, motor side",
        unit="rad",
        null=None,
        low=0.005,
        high=0.05,
        minimum=1e-5,
        source="as dwell_stiction",
    )

    def initial_memory(self, state: State) -> Array:
        """Contacts of a machine at rest are old."""
        return np.full((*state.motor_angle.shape, 1), _LONG)

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        age, rate = memory[..., 0], np.abs(state.motor_speed) / self.slip
        decay = rate * dt
        passed = np.where(decay > 0, -np.expm1(-decay) / np.where(rate > 0, rate, 1.0), dt)
        grown = np.log1p(age / self.time) / np.log1p(_LONG / self.time)
        torque = -self.share * state.static * grown * state.friction_sign
        return Torques(motor=torque), (age * np.exp(-decay) + passed)[..., None]
