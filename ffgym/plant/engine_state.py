"""States of effects, as the engine has them now."""

import numpy as np
from mujoco import batch

from ffgym.effects import State
from ffgym.plant.addresses import Addresses
from ffgym.plant.numbers import Numbers
from ffgym.robot.drive import Drive
from ffgym.types import Array, BoolArray, IntArray


class EngineState:
    """Reads motors, springs, servos and bristles of simulations from the engine."""

    def __init__(self, engine: batch.Batch, at: Addresses, drive: Drive) -> None:
        self._at, self._drive = at, drive
        self._qpos, self._qvel, self._act = (engine.bind(name) for name in ("qpos", "qvel", "act"))
        self._time, self._controls = engine.bind("time"), engine.bind("ctrl")

    def motor(self, rows: IntArray | slice) -> tuple[Array, Array]:
        """Motor angles [rad] and speeds [rad/s], motor side, (B, N) each."""
        at, drive = self._at, self._drive
        return (
            drive.motor_angle(self._qpos[rows][:, at.motor_qpos]),
            drive.motor_angle(self._qvel[rows][:, at.motor_qpos]),
        )

    def read(self, rows: IntArray | slice, own: Numbers) -> State:
        """State of simulations `rows` with the numbers `own`, (B, N) each."""
        at, drive = self._at, self._drive
        qpos, qvel, act = self._qpos[rows], self._qvel[rows], self._act[rows]
        joint_q, joint_dq = qpos[:, at.motor_qpos], qvel[:, at.motor_qpos]
        motor_q, motor_dq = drive.motor_angle(joint_q), drive.motor_angle(joint_dq)
        deflection = _spread(qpos[:, at.deflection_qpos], at.is_elastic)
        rate = _spread(qvel[:, at.deflection_qpos], at.is_elastic)
        integral = _spread(act[:, at.integral[at.has_integral]], at.has_integral)
        bristle = _spread(act[:, at.bristle[at.has_bristle]], at.has_bristle)
        feedback, command = self._servo(rows, motor_q, motor_dq, integral, own)
        time = self._time[rows].reshape(-1, 1)
        load = -(own.stiffness * deflection + own.damping * rate)
        level = own.coulomb + (own.static - own.coulomb) * np.exp(-((motor_dq / own.stribeck_velocity) ** 2))
        return State(
            time=time,
            running=own.running_since + time,
            motor_angle=motor_q,
            motor_speed=motor_dq,
            joint_angle=joint_q,
            joint_speed=joint_dq,
            deflection=deflection,
            deflection_rate=rate,
            load=load,
            load_at_motor=drive.motor_torque(load),
            joint_stiffness=own.stiffness,
            joint_damping=own.damping,
            friction_sign=own.bristle_stiffness * bristle / level,
            coulomb=own.coulomb,
            static=own.static,
            viscous=own.viscous,
            stribeck_velocity=own.stribeck_velocity,
            feedback_torque=feedback,
            motor_torque=command,
            peak_torque=own.peak_torque,
            temperature=own.temperature(time),
        )

    def _servo(
        self, rows: IntArray | slice, angle: Array, speed: Array, integral: Array, own: Numbers
    ) -> tuple[Array, Array]:
        """What MuJoCo's `pid` computes in the coming step: feedback and limited total, motor side [N m]."""
        controls, end = self._controls[rows], 3 * angle.shape[1]
        feedback = (
            own.position_gain * (controls[:, 0:end:3] - angle)
            + own.velocity_gain * (controls[:, 1:end:3] - speed)
            + own.integral_gain * integral
        )
        total = feedback + controls[:, 2:end:3]
        return feedback, np.minimum(np.maximum(total, -own.peak_torque), own.peak_torque)


def _spread(values: Array, where: BoolArray) -> Array:
    """Values of the joints `where`, 0 for the others, (B, N)."""
    if values.shape[1] == len(where):
        return values
    spread = np.zeros((len(values), len(where)))
    spread[:, where] = values
    return spread
