"""Bodies that give way: the base under the arm, and what the links carry (T7, T8)."""

from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np
import scipy

from ffgym.core.types import Array
from ffgym.effects.effect import ModelEffect, TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques
from ffgym.robot import RobotDescription

RADIUS = 0.3
"""Radius of gyration of the base [m], which descriptions leave out as it stands still; chosen: half of its width. The
arm on top has some hundred times its inertia about the floor."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class BaseFlexibility(ModelEffect):
    """The base tilts and turns on its floor, as a spring with some damping about each axis of the world."""

    name = "base_flexibility"
    code = "T7"
    title = "flexibility of the base"
    equation = r"\phi_i = c_i\, (\tau_i - (t_d / c_i)\, \dot\phi_i), \quad i = x, y, z"
    side = "link"
    signature = "tool: off the axes of the joints, and at a frequency that torque hardly shows"
    way_in = "joints of the base in the MuJoCo model, about those axes whose compliance is not 0"
    confusable_with = ("T1", "T8", "X2")
    separating_motions = ("excitation", "holds")

    compliance: Array = parameter(
        "c, angle over torque about the axes of the base",
        unit="rad/(N m)",
        low=0.0,
        high=3e-7,
        minimum=0.0,
        per="vector",
        source="first mode of 5 to 15 Hz with load, from memory of the literature; here some 1000 kg m^2 on it",
    )
    relaxation: Array = parameter(
        "t_d, damping over stiffness",
        unit="s",
        null=None,
        low=1e-4,
        high=5e-3,
        minimum=0.0,
        default=1e-3,
        per="machine",
        source="chosen: 1 to 20 % of critical damping at 10 Hz",
    )

    def in_model(self, spec: mujoco.MjSpec, robot: RobotDescription) -> None:
        """See base class."""
        base = spec.body("base")
        if np.any(self.compliance):
            base.mass = max(robot.base_mass, 1.0)  # what moves must weigh something
            base.fullinertia = base.mass * RADIUS**2 * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        for axis, name, compliance in zip(np.eye(3), "xyz", self.compliance, strict=True):
            if compliance > 0:
                base.add_joint(
                    name=f"base_{name}",
                    type=mujoco.mjtJoint.mjJNT_HINGE,
                    axis=axis,
                    stiffness=[1 / compliance, 0, 0],
                    damping=[float(self.relaxation) / compliance, 0, 0],
                )


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
    confusable_with = ("G2", "M5", "T1", "T7")
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
        """See base class: place and speed relative to the link, both 0, and the link's speed at the last step."""
        speed = state.link_speed
        return np.stack([np.zeros_like(speed), np.zeros_like(speed), speed], axis=-1)

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class; the last step brought the link from the speed remembered to the present one."""
        omega, speed = 2 * np.pi * self.frequency, state.link_speed
        pulled = (speed - memory[..., 2]) / dt / omega**2  # by how much it lags in the end, at this acceleration
        place, rate = _swung(memory[..., 0] + pulled, memory[..., 1], omega, self.damping, dt)
        place = place - pulled
        torque = self.inertia * (omega**2 * place + 2 * self.damping * omega * rate)
        return Torques(link=torque), np.stack([place, rate, speed], axis=-1)

    def torques_over(self, states: State, dt: float) -> Torques:
        """See base class."""
        speed = np.broadcast_to(states.link_speed, states.motor_angle.shape)
        acceleration = np.diff(speed, axis=0, prepend=speed[:1]) / dt
        torque = np.zeros_like(acceleration)
        for j in np.flatnonzero(self.inertia).tolist():
            numerator, denominator = self._filter(j, dt)
            torque[..., j] = scipy.signal.lfilter(numerator, denominator, acceleration[..., j], axis=0)
        return Torques(link=torque)

    def _filter(self, j: int, dt: float) -> tuple[Array, Array]:
        """Torque of joint j per acceleration of its link, as a discrete filter of second order."""
        omega, damping = 2 * np.pi * self.frequency[j], self.damping[j]
        step = np.stack(_swung(np.array([1.0, 0.0]), np.array([0.0, 1.0]), omega, damping, dt))  # place and rate
        pulled = (step[:, 0] - [1.0, 0.0]) / omega**2
        seen = self.inertia[j] * np.array([omega**2, 2 * damping * omega])
        trace, determinant = np.trace(step), np.linalg.det(step)
        numerator = np.array([seen @ pulled, seen @ step @ pulled - trace * (seen @ pulled)])
        return numerator, np.array([1.0, -trace, determinant])


def _swung(place: Array, rate: Array, omega: Array, damping: Array, dt: float) -> tuple[Array, Array]:
    """Place and rate of a free oscillator `dt` [s] later."""
    decay, swing = damping * omega, omega * np.sqrt(1 - damping**2)
    left, cosine, sine = np.exp(-decay * dt), np.cos(swing * dt), np.sin(swing * dt) / swing
    return (
        left * (cosine * place + sine * (rate + decay * place)),
        left * (cosine * rate - sine * (omega**2 * place + decay * rate)),
    )
