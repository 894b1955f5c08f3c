"""Many copies of one robot, stepped together by MuJoCo; motor quantities go in and come out in motor units."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco import batch

from ffgym.errors import FFGymError, check_shape, check_whole
from ffgym.plant.addresses import Addresses
from ffgym.plant.equilibrium import bent_by_load
from ffgym.plant.sameness import check_same_controller
from ffgym.robot import ModelOptions, RobotDescription, compile_model, model_field, physics_fingerprint
from ffgym.types import Array, BoolArray, IntArray

MAX_THREADS = 1024
"""More threads than any machine has cores; a larger number is a slip."""


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


class Plant:
    """B simulations of one robot with servos, on `n_threads` threads (0: all cores); one robot is the batch of one.

    The batch's results are bit-identical at any number of threads and robots.
    """

    def __init__(
        self, robot: RobotDescription, n_robots: int, *, options: ModelOptions | None = None, n_threads: int = 0
    ) -> None:
        options = options or ModelOptions(looks=False)
        if not options.servo:
            raise FFGymError("A plant needs its servos; leave ModelOptions.servo at True.")
        n_robots = check_whole("n_robots", n_robots, low=1)
        n_threads = check_whole("n_threads", n_threads, low=0, high=MAX_THREADS)
        self.robot = robot
        self.robots = [robot] * n_robots
        """What each simulation is: `robot`, or what it was made to `become`."""
        self._options = options
        self.model = compile_model(robot, options)
        self.batch = batch.Batch(self.model, nsim=n_robots, nthread=n_threads)
        self._qpos, self._qvel, self._act = (self.batch.bind(name) for name in ("qpos", "qvel", "act"))
        self._time, self._warnings = self.batch.bind("time"), self.batch.warning[..., 1]
        self._warned = self._warnings.copy()
        self.physics_dt = float(self.model.opt.timestep)
        self.n_substeps = round(robot.servo.control_dt / self.physics_dt)
        if abs(self.n_substeps * self.physics_dt - robot.servo.control_dt) > 1e-9 or self.n_substeps < 1:
            raise FFGymError(
                f"physics_dt = {self.physics_dt} s must divide control_dt = {robot.servo.control_dt} s exactly."
            )
        self.addresses = Addresses.of(self.model, robot)
        self._has_springs = bool(robot.springs) and options.springs
        self._servo_columns = self._find_servo_columns()

    def _find_servo_columns(self) -> tuple[IntArray, Array]:
        """Where the engine's state has what `servo_state` returns, and the factors on it."""
        at, ratio = self.addresses, self.robot.drive.gear_ratio
        starts = {
            name: (view.ctypes.data - self.batch.state.ctypes.data) // view.itemsize
            for name, view in (("qpos", self._qpos), ("qvel", self._qvel), ("act", self._act))
            if view.size
        }
        integral = np.where(at.has_integral, starts.get("act", 0) + at.integral, 0)
        columns = np.concatenate([starts["qpos"] + at.motor_qpos, starts["qvel"] + at.motor_qpos, integral])
        both = ratio if self.robot.drive.coupling is None else np.ones_like(ratio)
        return columns, np.concatenate([both, both, at.has_integral])

    @property
    def n_robots(self) -> int:
        """Number of simulations B."""
        return int(self.batch.nsim)

    def check_controller(self, robot: RobotDescription) -> None:
        """Check that a controller made for `robot` fits this plant, and this plant's a robot.

        Raises:
            FFGymError: if joints, gear ratios, servo gains, sample times or the make of springs and tool differ.
        """
        check_same_controller(self.robot, robot)

    def fingerprint(self, index: int = 0) -> str:
        """Fingerprint of the physics of one simulation."""
        own = self.robots[index] is self.robot
        return physics_fingerprint(self.model if own else self.batch.get_model(index))

    def become(self, ids: Sequence[int] | IntArray, robots: Sequence[RobotDescription]) -> None:
        """Give simulations `ids` other physics: masses, stiffness, friction, ... of `robots`; then put them to `rest`.

        Raises:
            FFGymError: if a robot differs in what its controller knows: joints, gear ratios, servo, sample times; or in
                which joints are elastic, which bodies springs join, or whether there is a tool.
        """
        for i, robot in zip(ids, robots, strict=True):
            if robot is self.robots[i]:
                continue
            self.check_controller(robot)
            model = compile_model(robot, self._options)
            if (model.nq, model.nu, model.na) != (self.model.nq, self.model.nu, self.model.na):
                raise FFGymError(
                    f"Robot {robot.name!r} has other elastic joints or actuators than {self.robot.name!r} in the same "
                    f"batch; simulate it in a batch of its own."
                )
            for name in batch.MODEL_FIELDS:
                own = model_field(model, name)
                if self.batch.expanded(name) is not None or not np.array_equal(own, model_field(self.model, name)):
                    self.batch.expand(name)[i] = own
            self.robots[i] = robot

    def rest(self, motor_q: Array, motor_dq: Array | None = None, ids: IntArray | None = None) -> None:
        """Put robots into static equilibrium: springs and servo integrals carry gravity, bristles are relaxed.

        Args:
            motor_q: joint position at the gearbox output [rad], shape (B, N).
            motor_dq: joint speed at the gearbox output [rad/s], shape (B, N); None is at rest.
            ids: which robots, shape (B,); None is all.

        Raises:
            FFGymError: if a robot is so soft that it finds no equilibrium under gravity.
        """
        n, at, engine = self.robot.n_joints, self.addresses, self.batch
        rows = np.arange(self.n_robots) if ids is None else np.asarray(ids)
        motor_q = check_shape("motor_q", motor_q, (len(rows), n))
        speed = np.zeros_like(motor_q) if motor_dq is None else check_shape("motor_dq", motor_dq, (len(rows), n))
        engine.reset(rows, stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        self._warned[rows] = self._warnings[rows]
        self._qpos[np.ix_(rows, at.motor_qpos)] = motor_q
        loaded = np.any(self.model.opt.gravity) or self._has_springs
        robots = [self.robots[i] for i in rows]
        load = bent_by_load(engine, at, rows, robots, self._has_springs) if loaded else np.zeros_like(motor_q)
        self._qvel[np.ix_(rows, at.motor_qpos)] = speed
        gain = self.robot.servo.integral_gain
        integral = np.divide(self.robot.drive.motor_torque(load), gain, out=np.zeros_like(load), where=gain > 0)
        self._act[np.ix_(rows, at.integral[at.has_integral])] = integral[:, at.has_integral]

    def state(self) -> PlantState:
        """State of all robots now, arrays of shape (B, N), copies."""
        return self.unpack(self._qpos, self._qvel, self._act)

    def servo_state(self) -> Array:
        """What servos know: motor position [rad], speed [rad/s] and integral [rad s], motor side, (B, 3 N), a copy."""
        columns, scale = self._servo_columns
        state: Array = self.batch.state.take(columns, axis=1) * scale
        drive, n = self.robot.drive, self.robot.n_joints
        if drive.coupling is not None:
            for part in (slice(0, n), slice(n, 2 * n)):
                state[:, part] = drive.motor_angle(state[:, part])
        return state

    def unpack(self, qpos: Array, qvel: Array, act: Array) -> PlantState:
        """State from MuJoCo's arrays of any leading shape, motor quantities in motor units."""
        at, drive = self.addresses, self.robot.drive
        motor_q, motor_dq = qpos[..., at.motor_qpos], qvel[..., at.motor_qpos]
        link_q, link_dq = motor_q.copy(), motor_dq.copy()
        link_q[..., at.is_elastic] += qpos[..., at.deflection_qpos]
        link_dq[..., at.is_elastic] += qvel[..., at.deflection_qpos]
        bristle, integral = np.zeros_like(motor_q), np.zeros_like(motor_q)
        bristle[..., at.has_bristle] = act[..., at.bristle[at.has_bristle]]
        integral[..., at.has_integral] = act[..., at.integral[at.has_integral]]
        return PlantState(
            motor_position=drive.motor_angle(motor_q),
            motor_velocity=drive.motor_angle(motor_dq),
            link_position=link_q,
            link_velocity=link_dq,
            bristle=bristle,
            integral=integral,
        )

    def split_controls(self, controls: Array) -> tuple[Array, Array, Array]:
        """Set-points for position, velocity, torque (..., N) as views of MuJoCo's controls (..., 3 N), motor side."""
        position, velocity, torque = (controls[..., k::3] for k in range(3))
        return position, velocity, torque

    def advance(self, controls: Array, ids: IntArray | None = None) -> tuple[Array, Array, Array]:
        """Run physics steps with one row of `controls` (B, S, 3 N) each; returns qpos, qvel, act after every step.

        Raises:
            FFGymError: if a simulation becomes unstable.
        """
        out = self._roll(controls, ("qpos", "qvel", "act"), ids)
        return out["qpos"], out["qvel"], out["act"]

    def drive(self, controls: Array, ids: IntArray | None = None) -> None:
        """As `advance`, and keep nothing but the state at the end."""
        self._roll(controls, (), ids)

    def _roll(self, controls: Array, record: tuple[str, ...], ids: IntArray | None) -> dict[str, Array]:
        steps = controls.shape[1]
        began = self._time.copy()
        with _unprinted_warnings():
            out: dict[str, Array] = self.batch.rollout(steps, control=controls, record=record, ids=ids)
        if self._warnings.any():
            warned, self._warned = self._warnings > self._warned, self._warnings.copy()
            self._check_stable(warned, began, steps)
        return out

    def _check_stable(self, warned: BoolArray, began: Array, steps: int) -> None:
        failed = np.flatnonzero(warned[:, _BAD].any(axis=1))
        if failed.size:
            start, first = began[failed[0]], int(failed[0])
            raise FFGymError(
                f"Simulation {first} of robot {self.robots[first].name!r} became unstable between t = {start:.3f} s "
                f"and {start + steps * self.physics_dt:.3f} s. Lower servo gains, torques or the physics step of "
                f"{self.physics_dt} s."
            )


@contextmanager
def _unprinted_warnings() -> Iterator[None]:
    """Keep MuJoCo from printing warnings and writing them to a file; an unstable simulation is an error of ours."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


_BAD = [
    int(mujoco.mjtWarning.mjWARN_BADQPOS),
    int(mujoco.mjtWarning.mjWARN_BADQVEL),
    int(mujoco.mjtWarning.mjWARN_BADQACC),
]
