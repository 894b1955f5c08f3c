"""Joint quantities in MuJoCo's arrays: where they stand, how they are read, and the state that effects are asked at."""

from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco import batch

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.effects import State
from ffgym.robot import RobotDescription
from ffgym.robot.drive import Drive
from ffgym.robot.model.spec import deflection_joint, friction_actuator, motor_joint, servo_actuator
from ffgym.simulation.plant.numbers import Numbers


@dataclass(frozen=True, kw_only=True, eq=False)
class Addresses:
    """Addresses of each joint's quantities; hinges have the same address in `qpos` and in `qvel`."""

    motor_qpos: IntArray
    deflection_qpos: IntArray
    """One per elastic joint."""
    is_elastic: BoolArray
    extra_qpos: IntArray
    """Joints that neither turn with a motor nor are its elasticity: those of effects."""
    extra_joint: IntArray
    """The same as numbers of joints."""
    integral: IntArray
    has_integral: BoolArray
    bristle: IntArray
    has_bristle: BoolArray

    @classmethod
    def of(cls, model: mujoco.MjModel, robot: RobotDescription) -> "Addresses":
        """Look the names up once."""
        names = {model.joint(i).name for i in range(model.njnt)}
        elastic = np.array([deflection_joint(j) in names for j in robot.joints])
        integral = np.array([_activation(model, servo_actuator(j)) for j in robot.joints])
        bristle = np.array([_activation(model, friction_actuator(j)) for j in robot.joints])
        own = {motor_joint(j) for j in robot.joints} | {deflection_joint(j) for j in robot.joints}
        extra = [i for i in range(model.njnt) if model.joint(i).name not in own]
        return cls(
            extra_qpos=model.jnt_qposadr[extra].astype(int),
            extra_joint=np.array(extra, dtype=int),
            motor_qpos=np.array([int(model.joint(motor_joint(j)).qposadr[0]) for j in robot.joints]),
            deflection_qpos=np.array(
                [
                    int(model.joint(deflection_joint(j)).qposadr[0])
                    for j, e in zip(robot.joints, elastic, strict=True)
                    if e
                ],
                dtype=int,
            ),
            is_elastic=elastic,
            integral=integral,
            has_integral=integral >= 0,
            bristle=bristle,
            has_bristle=bristle >= 0,
        )


def _activation(model: mujoco.MjModel, actuator: str) -> int:
    """Address of an actuator's activation, -1 if it has none or does not exist."""
    names = {model.actuator(i).name for i in range(model.nactuator)}
    return int(model.actuator(actuator).actadr[0]) if actuator in names else -1


class EngineState:
    """Reads motors, springs, servos and bristles of simulations from the engine."""

    def __init__(self, engine: batch.Batch, at: Addresses, drive: Drive) -> None:
        self._at, self._drive = at, drive
        self._qpos, self._qvel, self._act = (engine.bind(name) for name in ("qpos", "qvel", "act"))
        self._time, self._controls = engine.bind("time"), engine.bind("ctrl")
        self._outputs = None if at.is_elastic.all() else (engine.bind("qfrc_actuator"), engine.bind("qacc"))

    def motor(self, rows: IntArray | slice) -> tuple[Array, Array]:
        """Motor angles [rad] and speeds [rad/s], motor side, (B, N) each."""
        at, drive = self._at, self._drive
        return (
            drive.motor_angle(self._qpos[rows][:, at.motor_qpos]),
            drive.motor_angle(self._qvel[rows][:, at.motor_qpos]),
        )

    def read(self, rows: IntArray | slice, own: Numbers, motor: Array | None = None) -> State:
        """State of simulations `rows` with the numbers `own`, (B, N) each.

        Args:
            rows: which simulations.
            own: their numbers.
            motor: torque that effects added to the motors in the last step, link side [N m]; None is none.
        """
        return Reading(
            self._at,
            self._drive,
            own,
            qpos=self._qpos[rows].copy(),
            qvel=self._qvel[rows].copy(),
            act=self._act[rows].copy(),
            controls=self._controls[rows].copy(),
            time=self._time[rows].reshape(-1, 1).copy(),
            passed=self._passed(rows, own, motor),
        )

    def _passed(self, rows: IntArray | slice, own: Numbers, motor: Array | None) -> Array | None:
        """What gearboxes of rigid joints passed on in the last step: all but what their rotors took (B, N) [N m]."""
        if self._outputs is None:
            return None
        driven, acceleration = (values[rows][:, self._at.motor_qpos] for values in self._outputs)
        passed: Array = driven - own.reflected_inertia * acceleration
        return passed if motor is None else passed + motor


class Reading(State):
    """What the engine had at one instant, (B, N) each: effects need few fields, at every physics step."""

    __slots__ = ("_act", "_at", "_controls", "_drive", "_own", "_passed", "_qpos", "_qvel")

    def __init__(
        self,
        at: Addresses,
        drive: Drive,
        own: Numbers,
        *,
        qpos: Array,
        qvel: Array,
        act: Array,
        controls: Array,
        time: Array,
        passed: Array | None = None,
    ) -> None:
        self._at, self._drive, self._own = at, drive, own
        self._qpos, self._qvel, self._act, self._controls = qpos, qvel, act, controls
        self._passed = passed
        self.time = time

    def __getattr__(self, name: str) -> Array:
        """A field that nobody has asked for yet; called by Python where a slot is empty."""
        compute = getattr(type(self), f"_{name}_now", None)
        if compute is not None:
            value: Array = compute(self)
        elif name in State.__slots__:
            value = getattr(self._own, name)
        else:
            raise AttributeError(f"A state has no {name}.")
        setattr(self, name, value)
        return value

    def _running_now(self) -> Array:
        return self._own.running_since + self.time

    def _temperature_now(self) -> Array:
        return self._own.temperature(self.time)

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

    def _joint_stiffness_now(self) -> Array:
        return self._own.stiffness

    def _joint_damping_now(self) -> Array:
        return self._own.damping

    def _load_now(self) -> Array:
        load: Array = -(self._own.stiffness * self.deflection + self._own.damping * self.deflection_rate)
        return load if self._passed is None else np.where(self._at.is_elastic, load, self._passed)

    def _load_at_motor_now(self) -> Array:
        return self._drive.motor_torque(self.load)

    def _friction_sign_now(self) -> Array:
        own, at = self._own, self._at
        bristle = _spread(self._act, at.bristle[at.has_bristle], at.has_bristle)
        level = own.coulomb + (own.static - own.coulomb) * np.exp(-((self.motor_speed / own.stribeck_velocity) ** 2))
        sign: Array = own.bristle_stiffness * bristle / level
        return sign

    def _feedback_torque_now(self) -> Array:
        """What MuJoCo's `pid` computes in the coming step, motor side [N m]."""
        own, at, controls = self._own, self._at, self._controls
        integral = _spread(self._act, at.integral[at.has_integral], at.has_integral)
        end = 3 * integral.shape[1]
        feedback: Array = (
            own.position_gain * (controls[:, 0:end:3] - self.motor_angle)
            + own.velocity_gain * (controls[:, 1:end:3] - self.motor_speed)
            + own.integral_gain * integral
        )
        return feedback

    def _motor_torque_now(self) -> Array:
        """The same with the feed-forward, as far as the drive gives it."""
        peak = self._own.peak_torque
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


@dataclass(frozen=True, kw_only=True, eq=False)
class ServoReading:
    """Where the engine's state has position, speed and integral of each motor, and the factors on them."""

    engine: batch.Batch
    drive: Drive
    columns: IntArray
    """Shape (3 N,)."""
    scale: Array
    """Shape (3 N,)."""

    @classmethod
    def of(cls, engine: batch.Batch, at: Addresses, drive: Drive) -> "ServoReading":
        """Look the columns up once."""
        views = {name: engine.bind(name) for name in ("qpos", "qvel", "act")}
        starts = {
            name: (view.ctypes.data - engine.state.ctypes.data) // view.itemsize
            for name, view in views.items()
            if view.size
        }
        integral = np.where(at.has_integral, starts.get("act", 0) + at.integral, 0)
        columns = np.concatenate([starts["qpos"] + at.motor_qpos, starts["qvel"] + at.motor_qpos, integral])
        both = drive.gear_ratio if drive.coupling is None else np.ones_like(drive.gear_ratio)
        scale = np.concatenate([both, both, at.has_integral])
        return cls(engine=engine, drive=drive, columns=columns, scale=scale)

    def now(self) -> Array:
        """True motor position [rad], speed [rad/s] and integral [rad s], motor side, (B, 3 N), a copy."""
        state: Array = self.engine.state.take(self.columns, axis=1) * self.scale
        n = len(self.drive.gear_ratio)
        if self.drive.coupling is not None:
            for part in (slice(0, n), slice(n, 2 * n)):
                state[:, part] = self.drive.motor_angle(state[:, part])
        return state
