"""Friction that changes with temperature, rest and the time of a session (F7, F10, F12, F13)."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import FrictionEffect, TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TemperatureFriction(FrictionEffect):
    """Viscous friction falls exponentially with temperature; Coulomb torque and Stribeck peak change linearly.

    Reference:
        Bittencourt, Wernholt, Sander-Tavallaey, Brogardh (2010), "An extended friction model to capture load and
        temperature effects in robot joints", IROS: the shapes, not the numbers.
    """

    name = "temperature_friction"
    code = "F7"
    title = "temperature-dependent friction"
    equation = (
        r"\tau_f \mathrel{+}= c f_v \left( e^{-\Delta T / T_o} - 1 \right) v + \Delta T "
        r"\left( a f_c + b f_s\, e^{-(v / v_s)^2} \right) s(v), \quad \Delta T = T - T_r"
    )
    signature = "torque: odd in the speed, drifts along the session with the temperature"
    way_in = "torque at every physics step, from the temperature of the machine's climate"
    confusable_with = ("F1", "F2", "F8", "F12", "F13")
    separating_motions = ("warm_up", "speed_ladder")
    varies_with = ("temperature",)
    patterns = (("sign-locked function", "temperature"),)

    viscous: Array = parameter(
        "c, share of viscous friction that depends on temperature",
        unit="1",
        low=0.0,
        high=1.0,
        minimum=0.0,
        maximum=1.0,
        source="lubricant in the gearbox, seals not; all of it at most",
    )
    scale: Array = parameter(
        "T_o, rise over which that share falls to 37 %",
        unit="K",
        null=None,
        low=15.0,
        high=60.0,
        minimum=1.0,
        default=25.0,
        source="viscous friction halves over about 20 K; 19 to 51 degC studied by Park et al. 2022",
    )
    coulomb: Array = parameter(
        "a, of the Coulomb torque",
        unit="1/K",
        low=-0.005,
        high=0.005,
        source="12 % over a warm-up of some 20 K (simulator of FloBaRoID)",
    )
    breakaway: Array = parameter(
        "b, of the breakaway torque", unit="1/K", low=-0.005, high=0.01, source="chosen: as a, and more when cold"
    )
    reference: Array = parameter(
        "T_r, temperature at which the description holds",
        unit="degC",
        null=None,
        low=20.0,
        high=60.0,
        minimum=-40.0,
        default=20.0,
        source="chosen: from the room's to that of a warm gearbox",
    )

    def friction(self, state: State) -> Array:
        """See base class."""
        warmer, v = state.temperature - self.reference, state.motor_speed
        viscous = self.viscous * state.viscous * np.expm1(-warmer / self.scale) * v
        peak = state.static * np.exp(-((v / state.stribeck_velocity) ** 2))
        level = warmer * (self.coulomb * state.coulomb + self.breakaway * peak) * state.friction_sign
        return viscous + level


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
        """See base class; a machine at rest has rested for long."""
        return np.ones((*state.motor_angle.shape, 1))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        end, left = self._ageing(state, dt)
        aged = memory[..., 0]
        later = end + (aged - end) * left
        return self._felt(state, aged), later[..., None]

    def torques_over(self, states: State, dt: float) -> Torques:
        """See base class."""
        end, left = self._ageing(states, dt)
        aged = np.ones((len(left) + 1, *left.shape[1:]))
        for k in range(len(left)):
            aged[k + 1] = end[k] + (aged[k] - end[k]) * left[k]
        return self._felt(states, aged[:-1])

    def _felt(self, state: State, aged: Array) -> Torques:
        return Torques(motor=-self.share * state.static * aged * state.friction_sign)

    def _ageing(self, state: State, dt: float) -> tuple[Array, Array]:
        """The age that contacts approach in a step, and the share of the way that is left after it."""
        slipping = np.maximum(state.friction_sign * state.motor_speed, 0.0)
        rate = 1 / self.time + slipping / self.slip
        return 1 / (self.time * rate), np.exp(-rate * dt)


_REFERENCE = 100.0
"""v_r [rad/s], motor side; chosen: 1000 turns per minute, a medium speed of robot motors."""

_NEAR_REST = 1e-3
"""Speed, over that, below which the power law goes over into a straight line; chosen: less than any that is held."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ViscousDrift(FrictionEffect):
    r"""Warm-up where nobody measured a temperature: the description holds when the machine is switched on.

    What is lost grows with the speed as the friction of a power-law fluid does, as greases are (shear thinning, p < 1),
    and is the share c at :math:`v_r` = 100 rad/s.
    """

    name = "viscous_drift"
    code = "F12"
    title = "viscous friction that falls with time, as in a warm-up"
    equation = (
        r"\tau_f \mathrel{+}= c f_v \left( e^{-t / T_w} - 1 \right) v_r \left| v / v_r \right|^p \operatorname{sgn}(v)"
    )
    signature = "torque: odd in the speed and growing with it, less from motion to motion of a session"
    way_in = "torque at every physics step, from the time that the machine of a climate has run"
    confusable_with = ("F2", "F7", "F13")
    separating_motions = ("warm_up", "speed_ladder")
    varies_with = ("running",)
    patterns = (("sign-locked function", "time"),)

    share: Array = parameter(
        "c, share of viscous friction that is lost in the end",
        unit="1",
        low=0.0,
        high=0.5,
        minimum=-1.0,
        maximum=1.0,
        source="halves over about 20 K of warm-up (Bittencourt et al. 2010); from memory of the literature",
    )
    duration: Array = parameter(
        "T_w, time after which 63 % of it is lost",
        unit="s",
        null=None,
        low=300.0,
        high=7200.0,
        minimum=1.0,
        default=1800.0,
        tries=(600.0, 1800.0, 5400.0),
        source="5 to 20 min of a gearbox (simulator of FloBaRoID) to some hours of a heavy arm",
    )

    exponent: Array = parameter(
        "p, of the speed",
        unit="1",
        null=None,
        low=0.3,
        high=1.0,
        minimum=0.1,
        maximum=2.0,
        default=1.0,
        source="1: an oil; flow index of lubricating greases 0.3 to 1; from memory of the literature",
    )

    def friction(self, state: State) -> Array:
        """See base class."""
        lost = self.share * np.expm1(-state.running / self.duration)
        faster = (state.motor_speed / _REFERENCE) ** 2 + _NEAR_REST**2
        thinned = faster ** (0.5 * (self.exponent - 1.0))
        return lost * state.viscous * state.motor_speed * thinned


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CoulombDrift(FrictionEffect):
    """Coulomb friction that grows or falls with the time of a session: seals and preload that warm up, or run in."""

    name = "coulomb_drift"
    code = "F13"
    title = "Coulomb friction that changes with time"
    equation = r"\tau_f \mathrel{+}= c f_c \left( 1 - e^{-t / T_w} \right) s(v)"
    signature = "torque: square wave locked to the sign of the speed, other from motion to motion"
    way_in = "torque at every physics step, from the time that the machine of a climate has run"
    confusable_with = ("F1", "F7", "F12")
    separating_motions = ("warm_up", "slow_triangles")
    varies_with = ("running",)
    patterns = (("sign-locked function", "time"),)

    share: Array = parameter(
        "c, change in the end as a share of the Coulomb torque",
        unit="1",
        low=-0.3,
        high=0.3,
        minimum=-1.0,
        source="12 % over a warm-up (simulator of FloBaRoID), and as much again for wear; chosen",
    )
    duration: Array = parameter(
        "T_w, time after which 63 % of it has happened",
        unit="s",
        null=None,
        low=300.0,
        high=7200.0,
        minimum=1.0,
        default=1800.0,
        tries=(600.0, 1800.0, 5400.0),
        source="as of viscous_drift",
    )

    def friction(self, state: State) -> Array:
        """See base class."""
        more = -self.share * np.expm1(-state.running / self.duration)
        return more * state.coulomb * state.friction_sign
