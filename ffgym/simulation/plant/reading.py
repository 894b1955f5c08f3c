"""The state that effects are asked at: numbers of the machines, and what the engine has, computed when asked for."""

from collections.abc import Mapping, Sequence

import numpy as np
from mujoco import batch

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.effects import State
from ffgym.robot.drive import Drive
from ffgym.simulation.plant.engine_state import Addresses
from ffgym.simulation.plant.machine import Climate, Machine

_PARTS = {
    "drive": ("joint_stiffness", "joint_damping", "peak_torque"),
    "servo": ("position_gain", "velocity_gain", "integral_gain"),
    "friction": ("coulomb", "static", "viscous", "stribeck_velocity", "bristle_stiffness"),
}
"""Numbers of a description that states are made of."""


def numbers_of(machines: Sequence[Machine], n: int) -> dict[str, Array]:
    """Numbers of B machines of `n` joints side by side, (B, N) each, or (B, 1) for those of the climate."""
    robots, climates = [m.physical for m in machines], [m.climate or Climate() for m in machines]
    numbers = {
        name: np.stack([getattr(getattr(robot, part), name) for robot in robots])
        for part, names in _PARTS.items()
        for name in names
    }
    rigid = np.isinf(numbers["joint_stiffness"])  # a rigid joint has no deflection either
    for name in ("joint_stiffness", "joint_damping"):
        numbers[name] = np.where(rigid, 0.0, numbers[name])
    numbers["reflected_inertia"] = np.stack([r.drive.gear_ratio**2 * r.drive.rotor_inertia for r in robots])
    for name in ("ambient", "time_constant", "running_since"):
        numbers[name] = np.array([[getattr(climate, name)] for climate in climates], dtype=np.float64)
    numbers["rise"] = np.stack([np.broadcast_to(climate.rise, (n,)) for climate in climates])
    return numbers


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
    """What the engine had at one instant, (B, N) each: effects need few fields, at every physics step.

    Args:
        engine: simulations.
        rows: which of them.
        own: their numbers.
        motor: torque that effects added to the motors in the last step, link side [N m].
    """

    __slots__ = ("_act", "_at", "_controls", "_drive", "_own", "_passed", "_qpos", "_qvel")

    def __init__(self, engine: EngineState, rows: IntArray | slice, own: Mapping[str, Array], motor: Array) -> None:
        self._at, self._drive, self._own = engine.at, engine.drive, own
        self._qpos, self._qvel, self._act, self._controls = (values[rows].copy() for values in engine.joints)
        self.time = engine.time[rows].reshape(-1, 1).copy()
        self._passed: Array | None = None
        if engine.outputs is not None:  # gearboxes of rigid joints pass on all but what their rotors take
            driven, acceleration = (values[rows][:, engine.at.motor_qpos] for values in engine.outputs)
            self._passed = driven - own["reflected_inertia"] * acceleration + motor

    def __getattr__(self, name: str) -> Array:
        """A field that nobody has asked for yet; called by Python where a slot is empty."""
        compute = getattr(type(self), f"_{name}_now", None)
        if compute is not None:
            value: Array = compute(self)
        elif name in State.__slots__:
            value = self._own[name]
        else:
            raise AttributeError(f"A state has no {name}.")
        setattr(self, name, value)
        return value

    def _running_now(self) -> Array:
        return self._own["running_since"] + self.time

    def _temperature_now(self) -> Array:
        own = self._own
        warm = -np.expm1(-(own["running_since"] + self.time) / own["time_constant"])
        return own["ambient"] + own["rise"] * warm

    def _joint_angle_now(self) -> Array:
        return self._qpos[:, self._at.motor_qpos]

    def _joint_speed_now(self) -> Array:
        return self._qvel[:, self._at.motor_qpos]

    def _motor_angle_now(self) -> Array:
        return self._drive.motor_angle(self.joint_angle)

    def _motor_speed_now(self) -> Array:
        return self._drive.motor_angle(self.joint_speed)

    def _deflection_now(self) -> Array:
        return _spread(self._qpos, self._at.deflection_qpos, self._at.is_elastic)

    def _deflection_rate_now(self) -> Array:
        return _spread(self._qvel, self._at.deflection_qpos, self._at.is_elastic)

    def _load_now(self) -> Array:
        load: Array = -(self.joint_stiffness * self.deflection + self.joint_damping * self.deflection_rate)
        return load if self._passed is None else np.where(self._at.is_elastic, load, self._passed)

    def _load_at_motor_now(self) -> Array:
        return self._drive.motor_torque(self.load)

    def _friction_sign_now(self) -> Array:
        at = self._at
        bristle = _spread(self._act, at.bristle[at.has_bristle], at.has_bristle)
        peak = (self.static - self.coulomb) * np.exp(-((self.motor_speed / self.stribeck_velocity) ** 2))
        sign: Array = self._own["bristle_stiffness"] * bristle / (self.coulomb + peak)
        return sign

    def _feedback_torque_now(self) -> Array:
        """What MuJoCo's `pid` computes in the coming step, motor side [N m]."""
        own, at, controls = self._own, self._at, self._controls
        integral = _spread(self._act, at.integral[at.has_integral], at.has_integral)
        end = 3 * integral.shape[1]
        feedback: Array = (
            own["position_gain"] * (controls[:, 0:end:3] - self.motor_angle)
            + own["velocity_gain"] * (controls[:, 1:end:3] - self.motor_speed)
            + own["integral_gain"] * integral
        )
        return feedback

    def _motor_torque_now(self) -> Array:
        """The same with the feed-forward, as far as the drive gives it."""
        peak = self.peak_torque
        total = self.feedback_torque + self._controls[:, 2 : 3 * peak.shape[1] : 3]
        return np.minimum(np.maximum(total, -peak), peak)


def _spread(values: Array, places: IntArray, where: BoolArray) -> Array:
    """What stands at `places`, of the joints `where`, 0 for the others, (B, N)."""
    found = values[:, places]
    if found.shape[1] == len(where):
        return found
    spread = np.zeros((len(found), len(where)))
    spread[:, where] = found
    return spread
