"""Residuals that are made up: motions of all kinds, noise of a known size, and whatever is to be found in them."""

from collections.abc import Callable, Mapping

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.residual import Channel, MotionResidual, Residual
from ffgym.effects import State
from ffgym.robot import RobotDescription

DT = 0.008
NOISE = {"torque": 0.01, "servo": 0.01, "tool": 5e-6, "link": 2e-6}
Faults = Mapping[Channel, Callable[[State, Array], Array]]
"""What is added to noise by channel, from states and travel since the motors turned."""


def made_up(robot: RobotDescription, faults: Faults, *, channels: tuple[Channel, ...] = ("torque",), seed: int = 0):
    """Residual of three motions of 12 s: slow and fast sines, and starts from rest."""
    rng = np.random.default_rng(seed)
    motions = tuple(_motion(robot, name, faults, channels, rng) for name in ("slow", "fast", "stops"))
    n = robot.n_joints
    return Residual(
        robot=robot,
        motions=motions,
        floor={c: np.full((3, 3 if c == "tool" else n), NOISE[c]) for c in channels},
        cutoff=1 / (3 * DT),
    )


def _motion(robot, name, faults, channels, rng) -> MotionResidual:
    t = np.arange(0.0, 12.0, DT)
    n = robot.n_joints
    phase = t[:, None] * (1 + 0.1 * np.arange(n))
    speed = {
        "slow": 0.4 * np.cos(2 * np.pi * 0.2 * phase),
        "fast": 25.0 * np.cos(2 * np.pi * 0.4 * phase),
        "stops": 5.0 * np.sin(2 * np.pi * 0.25 * phase).clip(0.0, None),
    }[name]
    angle = np.cumsum(speed, axis=0) * DT
    state = _state(robot, t, angle, speed)
    travel, stood = _travel(angle, speed)
    predicted = {c: _predicted(c, state, robot) for c in channels}
    wrong = {c: faults[c](state, travel) if c in faults else 0.0 for c in channels}
    noise = {c: NOISE[c] * rng.standard_normal(predicted[c].shape) for c in channels}
    valid = np.ones(len(t), dtype=np.bool_)
    valid[:10], valid[-10:] = False, False
    return MotionResidual(
        motion=name,
        t=t,
        valid=valid,
        measured={c: predicted[c] + wrong[c] + noise[c] for c in channels},
        predicted=predicted,
        state=state,
        motor_acceleration=np.gradient(speed, DT, axis=0),
        since_reversal=travel,
        at_rest_for=stood,
    )


def _state(robot: RobotDescription, t: Array, angle: Array, speed: Array) -> State:
    q = robot.drive.joint_angle(angle)
    load = 0.5 * np.cos(q * 20)
    zero = np.zeros_like(angle)
    return State.of(
        robot,
        time=t[:, None],
        motor_angle=angle,
        motor_speed=speed,
        joint_angle=q,
        joint_speed=robot.drive.joint_angle(speed),
        deflection=zero,
        deflection_rate=zero,
        load=robot.drive.gear_ratio * load,
        load_at_motor=load,
        friction_sign=np.tanh(speed / 0.02),
        feedback_torque=zero,
        motor_torque=zero,
        temperature=20.0 + 0.5 * t[:, None] + zero,
    )


def _travel(angle: Array, speed: Array) -> tuple[Array, Array]:
    """Travel since each motor turned, and how long it had stood, (T, N) each."""
    travel, stood = np.zeros_like(angle), np.zeros_like(angle)
    for j in range(angle.shape[1]):
        moving = np.abs(speed[:, j]) > 1e-9
        turned, rest, last = 0, 0, 0.0
        for k in range(1, len(angle)):
            restarts = moving[k] and not moving[k - 1]
            turns = moving[k] and moving[k - 1] and speed[k, j] * speed[k - 1, j] < 0
            if turns or restarts:
                turned, last = k, rest * DT if restarts else 0.0
            rest = rest + 1 if not moving[k] else 0
            travel[k, j], stood[k, j] = abs(angle[k, j] - angle[turned, j]), last
    return travel, stood


def _predicted(channel: Channel, state: State, robot: RobotDescription) -> Array:
    friction = state.coulomb * state.friction_sign + state.viscous * state.motor_speed
    q = state.joint_angle
    circle = np.stack([np.cos(5 * q[:, 0]), np.sin(5 * q[:, 0]), 0 * q[:, 0]], axis=1)
    return {
        "torque": state.load_at_motor + friction,
        "servo": friction,
        "link": q,
        "tool": 0.05 * circle + [1.0, 0.2, 0.8],
    }[channel]
