"""States of robots, of MuJoCo's arrays, and of a whole plant."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.robot.drive import Drive
from ffgym.simulation.plant.engine_state import Addresses
from ffgym.simulation.plant.forces import Forces
from ffgym.simulation.plant.machine import Machine


@dataclass(frozen=True, kw_only=True, eq=False)
class PlantState:
    """State of B robots at one or T instants; every array ends in (N,)."""

    motor_position: Array
    """[rad], motor side."""
    motor_velocity: Array
    """[rad/s], motor side."""
    link_position: Array
    """[rad], link side."""
    link_velocity: Array
    """[rad/s], link side."""
    bristle: Array
    """LuGre bristle deflection z [rad], motor side; zero in a plant without friction."""
    integral: Array
    """Integral of the position error [rad s], motor side."""

    @classmethod
    def of(cls, at: Addresses, drive: Drive, qpos: Array, qvel: Array, act: Array) -> "PlantState":
        """State of MuJoCo's arrays of any leading shape."""
        motor_q, motor_dq = qpos[..., at.motor_qpos], qvel[..., at.motor_qpos]
        link_q, link_dq = motor_q.copy(), motor_dq.copy()
        link_q[..., at.is_elastic] += qpos[..., at.deflection_qpos]
        link_dq[..., at.is_elastic] += qvel[..., at.deflection_qpos]
        bristle, integral = np.zeros_like(motor_q), np.zeros_like(motor_q)
        bristle[..., at.has_bristle] = act[..., at.bristle[at.has_bristle]]
        integral[..., at.has_integral] = act[..., at.integral[at.has_integral]]
        return cls(
            motor_position=drive.motor_angle(motor_q),
            motor_velocity=drive.motor_angle(motor_dq),
            link_position=link_q,
            link_velocity=link_dq,
            bristle=bristle,
            integral=integral,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class SavedPlant:
    """A plant at one instant, to which it can go back."""

    machines: list[Machine]
    engine: Array
    forces: Forces | None
    remembered: list[Array]
