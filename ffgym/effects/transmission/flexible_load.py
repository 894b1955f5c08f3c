"""T8: something on the link that swings by itself."""

from dataclasses import dataclass
from typing import final

import numpy as np
import scipy

from ffgym.core.types import Array
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FlexibleLoad(TorqueEffect):
    r"""An inertia that the link carries along through a spring: an arm tube, a hose, a screw, a table on its bed.

    It turns about the axis of the joint, or slides along it, by :math:`x` ahead of the link, and has no weight, which
    the description has already. The step between two states is exact for a link whose speed changes evenly.
    """

    name = "flexible_load"
    code = "T8"
    title = "flexible mode of what the link carries"
    equation = (
        r"\tau_{link} \mathrel{+}= m\, (\omega^2 x + 2 \zeta \omega \dot x), \quad "
        r"\ddot x + 2 \zeta \omega \dot x + \omega^2 x = -\ddot q, \quad \omega = 2 \pi f"
    )
    side = "link"
    signature = "torque: rings at one frequency after each change of acceleration; below it, more inertia"
    way_in = "torque at every physics step on the link, with memory"
    confusable_with = ("G2", "M5", "T1", "T7", "T11")
    separating_motions = ("excitation",)

    inertia: Array = parameter(
        "m, link side",
        unit="kg m^2",
        low=0.0,
        high=2.0,
        minimum=0.0,
        source="chosen: some kg at half a metre; on a slide some kg, unit kg",
    )
    frequency: Array = parameter(
        "f, with the link held",
        unit="Hz",
        null=None,
        low=5.0,
        high=50.0,
        minimum=0.1,
        default=16.0,
        tries=(8.0, 11.3, 16.0, 22.6, 32.0),
        source="structural modes of industrial robots and machine tools; half octaves to try",
    )
    damping: Array = parameter(
        "zeta, share of critical damping",
        unit="1",
        null=None,
        low=0.01,
        high=0.2,
        minimum=1e-3,
        maximum=0.9,
        default=0.05,
        source="joined steel structures, 1 to 10 %; from memory of the literature",
    )

    def initial_memory(self, state: State) -> Array:
        """Return position and speed relative to the link, both 0, and the speed of the link at the last step."""
        speed = state.link_speed
        return np.stack([np.zeros_like(speed), np.zeros_like(speed), speed], axis=-1)

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the pull of the load; the last step brought the link from the remembered speed to the present one."""
        omega, speed = 2 * np.pi * self.frequency, state.link_speed
        # exact step of a driven oscillator: a free one about the place at which it would lag in the end
        pulled = (speed - memory[..., 2]) / dt / omega**2
        place, rate = _swing(memory[..., 0] + pulled, memory[..., 1], omega, self.damping, dt)
        place = place - pulled
        torque = self.inertia * (omega**2 * place + 2 * self.damping * omega * rate)
        return Torques(link=torque), np.stack([place, rate, speed], axis=-1)

    def torques_over(self, states: State, dt: float) -> Torques:
        """Filter accelerations of the links, joint by joint."""
        speed = np.broadcast_to(states.link_speed, states.motor_angle.shape)
        acceleration = np.diff(speed, axis=0, prepend=speed[:1]) / dt
        torque = np.zeros_like(acceleration)
        for j in np.flatnonzero(self.inertia).tolist():
            numerator, denominator = self._filter(j, dt)
            torque[..., j] = scipy.signal.lfilter(numerator, denominator, acceleration[..., j], axis=0)
        return Torques(link=torque)

    def _filter(self, j: int, dt: float) -> tuple[Array, Array]:
        """Return the discrete filter of second order from acceleration of link j to torque of its joint."""
        omega, damping = 2 * np.pi * self.frequency[j], self.damping[j]
        step = np.stack(_swing(np.array([1.0, 0.0]), np.array([0.0, 1.0]), omega, damping, dt))  # place and rate
        pulled = (step[:, 0] - [1.0, 0.0]) / omega**2
        seen = self.inertia[j] * np.array([omega**2, 2 * damping * omega])
        # transfer function of the state-space model, from trace and determinant of its matrix
        trace, determinant = np.trace(step), np.linalg.det(step)
        numerator = np.array([seen @ pulled, seen @ step @ pulled - trace * (seen @ pulled)])
        return numerator, np.array([1.0, -trace, determinant])


def _swing(place: Array, rate: Array, omega: Array, damping: Array, dt: float) -> tuple[Array, Array]:
    """Return place and rate of a free oscillator `dt` [s] later."""
    decay, swing = damping * omega, omega * np.sqrt(1 - damping**2)
    left, cosine, sine = np.exp(-decay * dt), np.cos(swing * dt), np.sin(swing * dt) / swing
    return (
        left * (cosine * place + sine * (rate + decay * place)),
        left * (cosine * rate - sine * (omega**2 * place + decay * rate)),
    )
