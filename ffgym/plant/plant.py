"""Many copies of one robot, stepped together by MuJoCo; motor quantities go in and come out in motor units."""

from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco import batch

from ffgym.errors import FFGymError, check_shape, check_whole
from ffgym.robot import ModelOptions, RigidArm, RobotDescription, compile_model, static_deflection
from ffgym.robot.spec import deflection_joint, friction_actuator, motor_joint, servo_actuator
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
        self.model = compile_model(robot, options)
        self.batch = batch.Batch(self.model, nsim=n_robots, nthread=n_threads)
        self.physics_dt = float(self.model.opt.timestep)
        self.n_substeps = round(robot.servo.control_dt / self.physics_dt)
        if abs(self.n_substeps * self.physics_dt - robot.servo.control_dt) > 1e-9 or self.n_substeps < 1:
            raise FFGymError(
                f"physics_dt = {self.physics_dt} s must divide control_dt = {robot.servo.control_dt} s exactly."
            )
        self.addresses = _Addresses.of(self.model, robot)

    @property
    def n_robots(self) -> int:
        """Number of simulations B."""
        return int(self.batch.nsim)

    def rest(self, arm: RigidArm, motor_q: Array, motor_dq: Array | None = None, ids: IntArray | None = None) -> None:
        """Put robots into static equilibrium: springs and servo integrals carry gravity, bristles are relaxed.

        Args:
            arm: the same robot's rigid dynamics.
            motor_q: motor angle / gear ratio [rad], shape (B, N).
            motor_dq: motor speed / gear ratio [rad/s], shape (B, N); None is at rest.
            ids: which robots, shape (B,); None is all.
        """
        n, at = self.robot.n_joints, self.addresses
        rows = np.arange(self.n_robots) if ids is None else np.asarray(ids)
        motor_q = check_shape("motor_q", motor_q, (len(rows), n))
        speed = np.zeros_like(motor_q) if motor_dq is None else check_shape("motor_dq", motor_dq, (len(rows), n))
        has_gravity = bool(np.any(self.model.opt.gravity))
        deflection = static_deflection(arm, motor_q) if has_gravity else np.zeros_like(motor_q)
        deflection[:, ~at.is_elastic] = 0.0
        torque = arm.gravity_torque(motor_q + deflection) if has_gravity else np.zeros_like(motor_q)
        gain = self.robot.servo.integral_gain * self.robot.drive.gear_ratio
        self.batch.reset(rows, stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        engine = self.batch
        engine.qpos[np.ix_(rows, at.motor_qpos)] = motor_q
        engine.qpos[np.ix_(rows, at.deflection_qpos)] = deflection[:, at.is_elastic]
        engine.qvel[np.ix_(rows, at.motor_qpos)] = speed
        integral = np.divide(torque, gain, out=np.zeros_like(torque), where=gain > 0)
        engine.act[np.ix_(rows, at.integral[at.has_integral])] = integral[:, at.has_integral]

    def state(self) -> PlantState:
        """State of all robots now, arrays of shape (B, N), copies."""
        return self.unpack(self.batch.qpos, self.batch.qvel, self.batch.act)

    def unpack(self, qpos: Array, qvel: Array, act: Array) -> PlantState:
        """State from MuJoCo's arrays of any leading shape, motor quantities in motor units."""
        at, ratio = self.addresses, self.robot.drive.gear_ratio
        motor_q, motor_dq = qpos[..., at.motor_qpos], qvel[..., at.motor_qpos]
        link_q, link_dq = motor_q.copy(), motor_dq.copy()
        link_q[..., at.is_elastic] += qpos[..., at.deflection_qpos]
        link_dq[..., at.is_elastic] += qvel[..., at.deflection_qpos]
        bristle, integral = np.zeros_like(motor_q), np.zeros_like(motor_q)
        bristle[..., at.has_bristle] = act[..., at.bristle[at.has_bristle]]
        integral[..., at.has_integral] = act[..., at.integral[at.has_integral]]
        return PlantState(
            motor_position=motor_q * ratio,
            motor_velocity=motor_dq * ratio,
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
        steps = controls.shape[1]
        fields = ("qpos", "qvel", "act")
        before, began = self.batch.warning[:, _BAD, 1].sum(axis=1), self.batch.time.copy()
        out = self.batch.rollout(steps, control=controls, record=fields, ids=ids)
        failed = np.flatnonzero(self.batch.warning[:, _BAD, 1].sum(axis=1) > before)
        if failed.size:
            start, first = began[failed[0]], int(failed[0])
            raise FFGymError(
                f"Simulation {first} of robot {self.robot.name!r} became unstable between t = {start:.3f} s and "
                f"{start + steps * self.physics_dt:.3f} s. Lower servo gains, torques or the physics step of "
                f"{self.physics_dt} s."
            )
        return out["qpos"], out["qvel"], out["act"]


_BAD = [
    int(mujoco.mjtWarning.mjWARN_BADQPOS),
    int(mujoco.mjtWarning.mjWARN_BADQVEL),
    int(mujoco.mjtWarning.mjWARN_BADQACC),
]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Addresses:
    """Where each joint's quantities stand in MuJoCo's arrays."""

    motor_qpos: IntArray
    deflection_qpos: IntArray
    """One per elastic joint."""
    is_elastic: BoolArray
    integral: IntArray
    has_integral: BoolArray
    bristle: IntArray
    has_bristle: BoolArray

    @staticmethod
    def of(model: mujoco.MjModel, robot: RobotDescription) -> "_Addresses":
        names = {model.joint(i).name for i in range(model.njnt)}
        elastic = np.array([deflection_joint(j) in names for j in robot.joints])
        integral = np.array([_activation(model, servo_actuator(j)) for j in robot.joints])
        bristle = np.array([_activation(model, friction_actuator(j)) for j in robot.joints])
        return _Addresses(
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
