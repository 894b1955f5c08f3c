"""Poles of the servo loop at rest: MuJoCo's linear model of a physics step, with what the plant adds to its drives."""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from ffgym.core.types import Array
from ffgym.robot import ModelOptions, RobotDescription
from ffgym.simulation.plant import Plant

_OPTIONS = ModelOptions(friction=False, looks=False)
"""Options of the model without friction. Friction only damps small motions, so that a loop that is stable without it is
stable with it, unless the step is too long for that damping, which `doubts` checks."""
_NUDGE = 1e-6
"""Step of the finite differences [rad, m]: the cube root of the rounding error, to an order of magnitude."""


def servo_poles(robot: RobotDescription, q: Array) -> NDArray[np.complex128]:
    """Compute the poles of one physics step of the robot at rest at joint positions `q` (N,), link side.

    Delays of torques and periods of resolvers are in it, steps of angles and limits of torques are not.
    """
    plant = Plant(robot, 1, options=_OPTIONS, n_threads=1)
    plant.rest(q[None])
    model, data = plant.model, mujoco.MjData(plant.model)
    data.qpos[:], data.act[:] = plant.batch.qpos[0], plant.batch.act[0]
    plant.split_controls(data.ctrl)[0][:] = robot.drive.motor_angle(q)
    size = 2 * model.nv + model.na
    engine, controls = np.zeros((size, size)), np.zeros((size, model.nu))
    mujoco.mjd_transitionFD(model, data, _NUDGE, True, engine, controls, None, None)
    every = max(1, round(robot.drive.resolver_period / robot.physics_dt))
    if robot.drive.torque_delay is None and every == 1:
        return np.linalg.eigvals(engine).astype(np.complex128)
    loop = _Loop.of(plant, engine, controls)
    # one step with a reading of the resolvers, then those that hold it
    cycle = np.linalg.matrix_power(loop.step(), every - 1) @ loop.step() @ loop.reading(every)
    return np.linalg.eigvals(cycle).astype(np.complex128) ** (1 / every)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Loop:
    """States of the engine, then angles and speeds that servos read, then torques that they commanded, latest first."""

    robot: RobotDescription
    engine: Array
    """Transition of the engine's states in a step, shape (S, S)."""
    controls: tuple[Array, Array, Array]
    """Influence of set-points for position and speed and of torques on them, shape (S, N) each."""
    motor: tuple[Array, Array, Array]
    """Motor angles, speeds and integrals of the engine's states, shape (N, S) each."""

    @classmethod
    def of(cls, plant: Plant, engine: Array, controls: Array) -> "_Loop":
        robot, at, nv = plant.robot, plant.addresses, plant.model.nv
        angle, speed, integral = (np.zeros((robot.n_joints, len(engine))) for _ in range(3))
        angle[:, at.motor_qpos] = speed[:, nv + at.motor_qpos] = robot.drive.matrix
        integral[at.has_integral, 2 * nv + at.integral[at.has_integral]] = 1.0
        parts = plant.split_controls(controls)
        return cls(robot=robot, engine=engine, controls=parts, motor=(angle, speed, integral))

    @property
    def _sizes(self) -> tuple[int, int, int]:
        """Numbers of states of the engine, of motors, and of steps for which commands are remembered."""
        steps = self.robot.drive.delay / self.robot.physics_dt
        return len(self.engine), self.robot.n_joints, int(np.floor(steps.max())) + 1

    def reading(self, every: int) -> Array:
        """Read the resolvers: differences of angles over `every` steps."""
        s, n, remembered = self._sizes
        out = np.eye(s + 2 * n + remembered * n)
        angle, speed = slice(s, s + n), slice(s + n, s + 2 * n)
        out[angle], out[speed] = 0.0, 0.0
        period = every * self.robot.physics_dt
        out[angle, :s], out[speed, :s] = self.motor[0], self.motor[0] / period
        out[speed, angle] = -np.eye(n) / period
        return out

    def step(self) -> Array:
        """Go one physics step on; servos act on what they read last, and their torques after the delay."""
        s, n, remembered = self._sizes
        out = np.zeros((s + 2 * n + remembered * n,) * 2)
        servo, (angle, speed, integral) = self.robot.servo, self.motor
        read = np.eye(2 * n, len(out), s)
        # commanded torques, and those that are due
        state = np.eye(s, len(out))
        command = servo.integral_gain[:, None] * (integral @ state)
        command -= servo.position_gain[:, None] * read[:n] + servo.velocity_gain[:, None] * read[n:]
        past = np.concatenate([command, np.eye(remembered * n, len(out), s + 2 * n)]).reshape(-1, n, len(out))
        whole, part = np.divmod(self.robot.drive.delay / self.robot.physics_dt, 1.0)
        each = np.arange(n)
        due = (1 - part)[:, None] * past[whole.astype(int), each]
        later = np.minimum(whole.astype(int) + 1, remembered)
        due += part[:, None] * past[later, each]
        # set-points are shifted by what readings are off, and torques by what the delay takes
        position, velocity, torque = self.controls
        out[:s] = self.engine @ state + position @ (angle @ state - read[:n]) + velocity @ (speed @ state - read[n:])
        out[:s] += torque @ (due - command)
        out[s : s + 2 * n] = read
        out[s + 2 * n :] = past[:-1].reshape(-1, len(out))
        return out
