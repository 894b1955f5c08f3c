"""What effects depend on, and what they give: motions and torques of all joints at one instant or along a recording."""

from dataclasses import dataclass, field

import numpy as np

from ffgym.core.types import Array


@dataclass(slots=True, kw_only=True, eq=False)
class State:
    """Motion of all joints; every array ends in (..., N), with B robots or T samples before it."""

    time: Array
    """Since the motion began [s], shape (..., 1)."""
    running: Array = field(default_factory=lambda: np.zeros(1))
    """Since the machine was switched on, or its session began [s], shape (..., 1); 0 where nobody knows."""
    motor_angle: Array
    """[rad], motor side."""
    motor_speed: Array
    """[rad/s], motor side."""
    joint_angle: Array
    """Gearbox output, link side [rad]: where the joint would be without elasticity."""
    joint_speed: Array
    """Gearbox output, link side [rad/s]."""
    deflection: Array
    """Link behind gearbox output, link side [rad]; 0 for a rigid joint."""
    deflection_rate: Array
    """[rad/s], link side."""
    load: Array
    """Torque that the gearbox passes on to the link, link side [N m]; of a rigid joint what its links ask for."""
    load_at_motor: Array
    """The same torque as the motor bears it, motor side [N m]."""
    joint_stiffness: Array
    """Of the joint's elasticity, link side [N m/rad]; 0 for a rigid joint."""
    joint_damping: Array
    """Of the joint's elasticity, link side [N m s/rad]; 0 for a rigid joint."""
    friction_sign: Array
    """LuGre-smoothed sign of the motor speed s = sigma_0 z / g(v) [1]: -1 to 1 in sliding, between while bristles
    bend."""
    coulomb: Array
    """Of the description's friction f_c, motor side [N m], as are the next three."""
    static: Array
    """f_s [N m]."""
    viscous: Array
    """f_v [N m s/rad]."""
    stribeck_velocity: Array
    """v_s [rad/s]."""
    feedback_torque: Array
    """What the servo adds by its position, speed and integral errors, motor side [N m]."""
    motor_torque: Array
    """What the servo commands, feed-forward included and limited, motor side [N m]."""
    peak_torque: Array
    """Largest that the drive gives, motor side [N m]."""
    temperature: Array
    """Of gearbox and motor [degC]."""

    @property
    def link_angle(self) -> Array:
        """Where the link is [rad], link side."""
        return self.joint_angle + self.deflection

    @property
    def link_speed(self) -> Array:
        """How fast the link turns [rad/s], link side."""
        return self.joint_speed + self.deflection_rate


@dataclass(slots=True, kw_only=True, eq=False)
class Torques:
    """What effects add, each (..., N) or None for nothing."""

    motor: Array | None = None
    """On the rotor, motor side [N m]; positive accelerates the motor, so that friction is minus a friction law."""
    spring: Array | None = None
    """Between gearbox output and link, link side [N m]; positive accelerates the link and pushes the gearbox back."""
    link: Array | None = None
    """On the link from the link before it, link side [N m]; the gearbox does not carry it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ResolverError:
    """What the resolver reads beyond the true motor angle, motor side, (..., N) each."""

    angle: Array
    """[rad]."""
    speed: Array
    """[rad/s]."""


def no_memory(state: State) -> Array:
    """Memory of an effect that remembers nothing, shape (..., N, 0)."""
    return np.zeros((*state.motor_angle.shape, 0))
