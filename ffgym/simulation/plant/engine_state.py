"""Joint quantities in MuJoCo's arrays: where they stand, and how robots and servos are read from them."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cached_property

import mujoco
import numpy as np
from mujoco import batch

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.effects import Torques
from ffgym.effects.together import add
from ffgym.robot import RobotDescription
from ffgym.robot.drive import Drive
from ffgym.robot.model.names import (
    arm_friction_actuator,
    deflection_joint,
    friction_actuator,
    motor_joint,
    servo_actuator,
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Addresses:
    """Addresses of each joint's quantities; hinges have the same address in `qpos` and in `qvel`."""

    motor_qpos: IntArray
    deflection_qpos: IntArray
    """Addresses, one per elastic joint."""
    is_elastic: BoolArray
    extra_qpos: IntArray
    """Joints that neither turn with a motor nor are its elasticity: those of effects."""
    extra_joint: IntArray
    """Elastic joints as indices of joints."""
    integral: IntArray
    has_integral: BoolArray
    torque: IntArray
    """Torques of torque loops."""
    has_torque: BoolArray
    bristle: IntArray
    has_bristle: BoolArray
    arm_bristle: IntArray
    """Bristles of the friction behind the elasticity."""
    has_arm_bristle: BoolArray

    @cached_property
    def key(self) -> bytes:
        """All addresses, to tell whether two layouts are the same."""
        return b"".join(np.append(value := getattr(self, f.name), len(value)).tobytes() for f in fields(self))

    @cached_property
    def deflection_of_joint(self) -> IntArray:
        """Addresses of deflections, one per joint, shape (N,); -1 for rigid joints."""
        addresses = np.full(len(self.is_elastic), -1)
        addresses[self.is_elastic] = self.deflection_qpos
        return addresses

    @classmethod
    def of(cls, model: mujoco.MjModel, robot: RobotDescription) -> "Addresses":
        """Look the names up once."""
        places = {model.joint(i).name: int(model.jnt_qposadr[i]) for i in range(model.njnt)}
        deflections = [deflection_joint(j) for j in robot.joints]
        integral, torque = np.array([_servo_activations(model, servo_actuator(j)) for j in robot.joints]).T
        bristle = np.array([_activation(model, friction_actuator(j)) for j in robot.joints])
        arm_bristle = np.array([_activation(model, arm_friction_actuator(j)) for j in robot.joints])
        own = {*deflections, *(motor_joint(j) for j in robot.joints)}
        extra = [i for i in range(model.njnt) if model.joint(i).name not in own]
        return cls(
            extra_qpos=model.jnt_qposadr[extra].astype(int),
            extra_joint=np.array(extra, dtype=int),
            motor_qpos=np.array([places[motor_joint(j)] for j in robot.joints]),
            deflection_qpos=np.array([places[name] for name in deflections if name in places], int),
            is_elastic=np.array([name in places for name in deflections]),
            integral=integral,
            has_integral=integral >= 0,
            torque=torque,
            has_torque=torque >= 0,
            bristle=bristle,
            has_bristle=bristle >= 0,
            arm_bristle=arm_bristle,
            has_arm_bristle=arm_bristle >= 0,
        )


def _activation(model: mujoco.MjModel, actuator: str) -> int:
    """Address of an actuator's activation, -1 if it has none or does not exist."""
    addresses = {model.actuator(i).name: int(model.actuator_actadr[i]) for i in range(model.nactuator)}
    return addresses.get(actuator, -1)


def _servo_activations(model: mujoco.MjModel, actuator: str) -> tuple[int, int]:
    """Addresses of a servo's integral and of the torque of its torque loop, the last of both; -1 if it has none."""
    first, servo = _activation(model, actuator), model.actuator(actuator).id
    loop = int(model.actuator_dyntype[servo]) == int(mujoco.mjtDyn.mjDYN_DCMOTOR)
    last = first + int(model.actuator_actnum[servo]) - 1
    return (first if last > first or not loop else -1), (last if loop else -1)


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
    arm_bristle: Array
    """Deflection of the bristles on the link, in motor units [rad]; zero without friction behind the elasticity."""
    integral: Array
    """Integral of the position error [rad s], motor side."""

    @classmethod
    def of(cls, at: Addresses, drive: Drive, qpos: Array, qvel: Array, act: Array) -> "PlantState":
        """State of MuJoCo's arrays of any leading shape."""
        motor_q, motor_dq = qpos[..., at.motor_qpos], qvel[..., at.motor_qpos]
        link_q, link_dq = motor_q.copy(), motor_dq.copy()
        link_q[..., at.is_elastic] += qpos[..., at.deflection_qpos]
        link_dq[..., at.is_elastic] += qvel[..., at.deflection_qpos]
        bristle, arm_bristle, integral = (np.zeros_like(motor_q) for _ in range(3))
        bristle[..., at.has_bristle] = act[..., at.bristle[at.has_bristle]]
        arm_bristle[..., at.has_arm_bristle] = act[..., at.arm_bristle[at.has_arm_bristle]]
        integral[..., at.has_integral] = act[..., at.integral[at.has_integral]]
        return cls(
            motor_position=drive.motor_angle(motor_q),
            motor_velocity=drive.motor_angle(motor_dq),
            link_position=link_q,
            link_velocity=link_dq,
            bristle=bristle,
            arm_bristle=arm_bristle,
            integral=integral,
        )


def servo_reader(engine: batch.Batch, at: Addresses, drive: Drive) -> Callable[[], Array]:
    """Function that reads what servos know, in one go, as it is called at every control step.

    It returns true motor position [rad], speed [rad/s] and integral [rad s], motor side, shape (3, B, N), a copy.
    """
    views = {name: engine.bind(name) for name in ("qpos", "qvel", "act")}
    base = engine.state.ctypes.data
    starts = {name: (view.ctypes.data - base) // view.itemsize for name, view in views.items() if view.size}
    integral = np.where(at.has_integral, starts.get("act", 0) + at.integral, 0)
    columns = np.stack([starts["qpos"] + at.motor_qpos, starts["qvel"] + at.motor_qpos, integral])
    both = drive.gear_ratio if drive.coupling is None else np.ones_like(drive.gear_ratio)
    # places in the state of all simulations, and a factor for each
    n_robots, length = engine.state.shape
    places = columns[:, None] + length * np.arange(n_robots)[:, None]
    scale = np.repeat(np.stack([both, both, at.has_integral])[:, None], n_robots, axis=1)
    everything = engine.state.reshape(-1)

    def read() -> Array:
        state: Array = everything.take(places) * scale
        if drive.coupling is not None:
            state[:2] = drive.motor_angle(state[:2])
        return state

    return read


def hinge_torques(drive: Drive, total: Torques) -> tuple[Array | None, Array | None, Array | None]:
    """Compute generalised forces of effects, link side [N m]: motor hinges turn rotor and link, deflections the link.

    Returns:
        Torques that effects add to motors, then those on motor hinges and on deflection hinges, (B, N) each; None for
        nothing.
    """
    motor = None if total.motor is None else drive.joint_torque(total.motor)
    return motor, add(motor, total.link), add(total.spring, total.link)
