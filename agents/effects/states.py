"""States that effects are asked at, where a law puts motors and links."""

from dataclasses import dataclass, fields

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State
from ffgym.simulation.plant import Climate, Machine

AMBIENT = Climate()
"""What effects see of a machine whose climate nobody knows."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Place:
    """Where motors and links are at a sample, and what moves them there; (..., N) each."""

    time: Array
    """Since the motion began [s]."""
    joint_angle: Array
    """Gearbox output, link side [rad]."""
    joint_speed: Array
    """[rad/s], link side."""
    deflection: Array
    """Link behind gearbox output [rad], link side."""
    deflection_rate: Array
    """[rad/s], link side."""
    load: Array
    """Torque that the gearbox passes on to the link [N m], link side."""
    needed: Array
    """Torque that the motor must give, but for friction and effects, gravity included [N m], motor side."""

    def towards(self, other: "Place", shares: Array) -> "Place":
        """Places at `shares` (S,) of the straight way to another one, (S, ..., N) each."""
        across = shares.reshape(-1, *[1] * self.load.ndim)

        def between(name: str) -> Array:
            start: Array = getattr(self, name)
            end: Array = getattr(other, name)
            return start + (end - start) * across

        return Place(**{f.name: between(f.name) for f in fields(self)})


@dataclass(frozen=True, kw_only=True, eq=False)
class States:
    """States of one machine."""

    machine: Machine

    def at(self, place: Place, *, bristle: Array, command: Array) -> State:
        """State of effects.

        Args:
            place: where motors and links are, (..., N).
            bristle: deflection of the LuGre bristles [rad], (..., N).
            command: torque that the servo commands [N m], motor side, (..., N).
        """
        robot = self.machine.physical
        drive, friction = robot.drive, robot.friction
        rigid, speed = drive.is_rigid, drive.motor_angle(place.joint_speed)
        return State(
            time=place.time,
            running=(self.machine.climate or AMBIENT).running_since + place.time,
            motor_angle=drive.motor_angle(place.joint_angle),
            motor_speed=speed,
            joint_angle=place.joint_angle,
            joint_speed=place.joint_speed,
            deflection=place.deflection,
            deflection_rate=place.deflection_rate,
            load=place.load,
            load_at_motor=drive.motor_torque(place.load),
            joint_stiffness=np.where(rigid, 0.0, drive.joint_stiffness),
            joint_damping=np.where(rigid, 0.0, drive.joint_damping),
            friction_sign=friction.bristle_stiffness * bristle / friction.stribeck_level(speed),
            coulomb=friction.coulomb,
            static=friction.static,
            viscous=friction.viscous,
            stribeck_velocity=friction.stribeck_velocity,
            feedback_torque=np.zeros_like(command),
            motor_torque=self.limited(command),
            peak_torque=drive.peak_torque,
            temperature=self._temperature(place.time),
        )

    def limited(self, command: Array) -> Array:
        """What drives give of a command [N m], motor side."""
        peak = self.machine.physical.drive.peak_torque
        return np.minimum(np.maximum(command, -peak), peak)

    def _temperature(self, time: Array) -> Array:
        """[degC] at times that are the same for all joints, (..., N)."""
        climate, n = self.machine.climate or AMBIENT, self.machine.robot.n_joints
        return climate.temperature(time[..., 0].reshape(-1), n).reshape(time.shape)
