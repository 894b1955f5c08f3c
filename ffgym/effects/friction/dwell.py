"""F10: friction that grows while surfaces stick."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class DwellStiction(TorqueEffect):
    r"""Breakaway torque that grows with the time of rest and is used up by the first slip.

    The memory c is how far contacts have aged: they age towards 1 at rest, and slip renews them. The equation is linear
    in c, so that its exact solution over a step is taken.

    Reference:
        Ruina (1983), J. Geophys. Res. 88(B12): ageing law of rate-and-state friction; here with an end of ageing.
    """

    name = "dwell_stiction"
    code = "F10"
    title = "breakaway that grows with the time of rest"
    equation = r"\tau_f \mathrel{+}= a f_s\, c\, s(v), \quad \dot c = (1 - c) / t_d - c\, \max(s v, 0) / x_s"
    side = "motor"
    signature = "torque: a peak at the restart only, that grows with the rest before it"
    way_in = "torque at every physics step, with memory"
    confusable_with = ("F3", "F4", "F14")
    separating_motions = ("dwell_restart",)
    at_low_speed = True
    needs_friction = True
    patterns = (("sign-locked function", "time at rest before the move"),)

    share: Array = parameter(
        "a, more breakaway torque after a long rest, as a share of it",
        unit="1",
        low=0.0,
        high=0.5,
        minimum=0.0,
        source="0.1 to 0.5; from memory of the literature",
    )
    time: Array = parameter(
        "t_d, time of rest after which 63 % of that is there",
        tries=(0.3, 2.0),
        unit="s",
        null=None,
        low=0.1,
        high=10.0,
        minimum=1e-3,
        default=1.0,
        source="0.1 to 10; from memory of the literature",
    )
    slip: Array = parameter(
        "x_s, slip that renews contacts, motor side",
        unit="rad",
        null=None,
        low=0.005,
        high=0.1,
        minimum=1e-5,
        default=0.02,
        source="chosen: some bristle lengths f_c / sigma_0, 8 mrad on the built-in robots",
    )

    def initial_memory(self, state: State) -> Array:
        """Return contacts that have aged to the end: a machine at rest has rested for long."""
        return np.ones((*state.motor_angle.shape, 1))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the breakaway torque of the contacts, and their age a step later."""
        end, left = self._ageing(state, dt)
        aged = memory[..., 0]
        later = end + (aged - end) * left
        return self._felt(state, aged), later[..., None]

    def torques_over(self, states: State, dt: float) -> Torques:
        """Age contacts from sample to sample, then compute all torques at once."""
        end, left = self._ageing(states, dt)
        aged = np.ones((len(left) + 1, *left.shape[1:]))
        for k in range(len(left)):
            aged[k + 1] = end[k] + (aged[k] - end[k]) * left[k]
        return self._felt(states, aged[:-1])

    def _felt(self, state: State, aged: Array) -> Torques:
        return Torques(motor=-self.share * state.static * aged * state.friction_sign)

    def _ageing(self, state: State, dt: float) -> tuple[Array, Array]:
        """Return the age that contacts approach in a step, and the share of the way that is left after it."""
        slipping = np.maximum(state.friction_sign * state.motor_speed, 0.0)
        rate = 1 / self.time + slipping / self.slip
        return 1 / (self.time * rate), np.exp(-rate * dt)
