"""State of simulations that effects are asked at: numbers of the machines, and what the engine has."""

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
from mujoco import batch

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.effects import State
from ffgym.effects.state import given, number
from ffgym.robot.drive import Drive, next_torque
from ffgym.simulation.plant.engine_state import Addresses
from ffgym.simulation.plant.machine import Machine


class EngineState:
    """Motors, springs, servos and bristles of simulations, where the engine has them."""

    def __init__(self, engine: batch.Batch, at: Addresses, drive: Drive) -> None:
        self.at, self.drive = at, drive
        self.joints = tuple(engine.bind(name) for name in ("qpos", "qvel", "act", "ctrl"))
        self.time = engine.bind("time")
        self.outputs = None if at.is_elastic.all() else (engine.bind("qfrc_actuator"), engine.bind("qacc"))

    def motor(self, rows: IntArray | slice) -> tuple[Array, Array]:
        """Motor angles [rad] and speeds [rad/s], motor side, (B, N) each."""
        angle, speed = (self.drive.motor_angle(values[rows][:, self.at.motor_qpos]) for values in self.joints[:2])
        return angle, speed


class Reading(State):
    """State that the engine had at one instant, (B, N) each: effects need few variables, at every physics step.

    Args:
        engine: simulations.
        rows: which of them.
        own: their numbers.
        motor: torque that effects added to the motors in the last step, link side [N m].
    """

    reflected_inertia: Array = number("drive.reflected_inertia")
    """Inertia of the rotors behind the gearbox [kg m^2]."""
    position_gain: Array = number("servo.position_gain")
    """Gain of the servo's position error, motor side [N m/rad]."""
    velocity_gain: Array = number("servo.velocity_gain")
    """Gain of its speed error [N m s/rad]."""
    integral_gain: Array = number("servo.integral_gain")
    """Gain of the integral of its position error [N m/(rad s)]."""
    loop_lag: Array = number("drive.loop_lag")
    """Time constant of the torque loop [s]."""
    loop_rate: Array = number("drive.loop_rate")
    """Fastest change of torque [N m/s]."""
    loop_decay: Array = given()
    """Share of its distance to the command that the torque loop leaves after a physics step [1]."""
    loop_most: Array = given()
    """Largest change of its torque in a physics step [N m]."""

    def __init__(self, engine: EngineState, rows: IntArray | slice, own: Mapping[str, Array], motor: Array) -> None:
        self.__dict__.update(own, _given={*own, "time", "rigid_load"}, drive=engine.drive)
        self._at = at = engine.at
        self._qpos, self._qvel, self._act, self._controls = (values[rows].copy() for values in engine.joints)
        self.time = engine.time[rows].reshape(-1, 1).copy()
        if engine.outputs is not None:  # gearboxes of rigid joints pass on all but what rotors and friction take
            driven, acceleration = (values[rows][:, at.motor_qpos] for values in engine.outputs)
            # MuJoCo counts viscous friction of actuators as damping of their joints
            viscous = self.drive.joint_torque(own["viscous"] * at.has_bristle.astype(np.float64) * self.motor_speed)
            self.rigid_load = driven - viscous - own["reflected_inertia"] * acceleration + motor
            self.is_rigid = ~at.is_elastic

    def read_joint_angle(self) -> Array:
        """Read angles of gearbox outputs, link side [rad]."""
        return self._qpos[:, self._at.motor_qpos]

    def read_joint_speed(self) -> Array:
        """Read their speeds, link side [rad/s]."""
        return self._qvel[:, self._at.motor_qpos]

    def read_deflection(self) -> Array:
        """Read deflections of elastic joints, link side [rad]."""
        return _spread(self._qpos, self._at.deflection_of_joint, self._at.is_elastic)

    def read_deflection_rate(self) -> Array:
        """Read their rates, link side [rad/s]."""
        return _spread(self._qvel, self._at.deflection_of_joint, self._at.is_elastic)

    def read_bristle(self) -> Array:
        """Read deflections of bristles, motor side [rad]."""
        return _spread(self._act, self._at.bristle, self._at.has_bristle)

    def read_feedback_torque(self) -> Array:
        """Compute what MuJoCo's `pid` gives in the coming step, motor side [N m]."""
        controls, at = self._controls, self._at
        integral = _spread(self._act, at.integral, at.has_integral)
        end = 3 * integral.shape[1]
        feedback: Array = (
            self.position_gain * (controls[:, 0:end:3] - self.motor_angle)
            + self.velocity_gain * (controls[:, 1:end:3] - self.motor_speed)
            + self.integral_gain * integral
        )
        return feedback

    def read_command(self) -> Array:
        """Add the feed-forward torque of the controls, motor side [N m]."""
        return self.feedback_torque + self._controls[:, 2 : 3 * self.peak_torque.shape[1] : 3]

    @cached_property
    def loop_torque(self) -> Array:
        """Torque that MuJoCo's torque loop gives in the coming step, motor side [N m]."""
        at = self._at
        if not at.has_torque.any():
            return self.motor_torque
        torque = _spread(self._act, at.torque, at.has_torque)
        later = next_torque(torque, self.motor_torque, self.loop_decay, self.loop_most)
        return np.where(at.has_torque, later, self.motor_torque)


def stack_numbers(machines: Sequence[Machine]) -> dict[str, Array]:
    """Numbers of B machines side by side, (B, N) each, or (B, 1) for those of the climate."""
    each = [Reading.numbers(machine.physical, machine.climate) for machine in machines]
    return {name: np.stack([numbers[name] for numbers in each]) for name in each[0]}


def _spread(values: Array, places: IntArray, where: BoolArray) -> Array:
    """Read the values at `places` (N,) for the joints `where`, 0 for the others, (B, N)."""
    if where.all():
        return values[:, places]
    if not where.any():
        return np.zeros((len(values), len(where)))
    return np.where(where, values[:, np.where(where, places, 0)], 0.0)
