"""Predictions of a replay in the channels of a log, some of which are written late."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ffgym.control import servo_torque
from ffgym.core.types import Array
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.replay.rows import Replay
from ffgym.diagnosis.residual import Channel
from ffgym.effects import ClockEffect, TrackerEffect
from ffgym.effects.effect import Effect
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Machine

FAMILY = {"torque": "motor.effort", "link": "link.position"}
"""Family of columns that each channel is read from."""


def delay(values: Array, channel: str, effects: Sequence[Effect], log: Log) -> Array:
    """Values (T, M, N) of a channel as `effects` let them be written; the same array if none concerns it."""
    for effect in effects:
        if isinstance(effect, ClockEffect) and FAMILY.get(channel) in effect.families:
            values = values.copy()
            for i, n in enumerate(log.lengths):  # padding stays
                values[:n, i] = effect.delay(values[:n, i], log.dt)
    return values


def undo_delay(values: Array, channel: str, effects: Sequence[Effect], dt: float) -> Array:
    """Measured values (T, ...) of a channel as they were sampled, beside positions of the same instants."""
    for effect in effects:
        if isinstance(effect, ClockEffect) and FAMILY.get(channel) in effect.families:
            values = effect.undo_delay(values, dt)
    return values


def predict(run: Replay) -> dict[Channel, Array]:
    """Predict the log's channels, R rows each, through the log's low-pass."""
    log, sampling = run.log, run.log.sampling
    effects = run.machine.effects
    found: dict[Channel, Array] = {"torque": sampling(delay(run.torque, "torque", effects, log))}
    if log.tool is not None:
        found["tool"] = sampling(predict_tracker(run))
    if log.link is not None:
        found["link"] = sampling(delay(run.link_q, "link", effects, log))
    if log.shows_servo:
        found["servo"] = sampling(predict_feedback(run.read, run.robot))
    return found


def predict_tracker(run: Replay, machine: Machine | None = None, every: int = 1) -> Array:
    """Tool positions as the tracker of the machine, or of another one, would see them [m], (T, M, 3).

    At every n-th sample.
    """
    q, position = run.link_q[::every], run.tool_position[::every].copy()
    position = position if run.sway is None else run.sway.move(position, every)
    effects = [effect for effect in (machine or run.machine).effects if isinstance(effect, TrackerEffect)]
    for i, recording in enumerate(run.log.recordings) if effects else ():
        n = -(-len(recording) // every)
        columns = {"timestamp": recording.t[::every]}
        columns |= {f"tcp.position.{axis}": position[:n, i, k] for k, axis in enumerate("xyz")}
        columns |= {f"link.position.{joint}": q[:n, i, j] for j, joint in enumerate(run.robot.joints)}
        exact = Recording(columns=columns, header=replace(recording.header, phases=()))
        for effect in effects:
            exact = effect.measure(exact, run.robot)
        position[:n, i] = exact.vector("tcp.position")
    return position


def predict_feedback(log: Log, robot: RobotDescription) -> Array:
    """Feedback torque of the documented servo on the measured error [N m], motor side, (T, M, N)."""
    return servo_torque(robot.servo, *servo_errors(log, robot)).u_fb


def servo_errors(log: Log, robot: RobotDescription) -> tuple[Array, Array, Array]:
    """Measured error of the motors [rad], its rate and its integral, which a servo acts on, (T, M, N) each.

    The integral is that since the motion began; what it held before is a constant that was not recorded.
    """
    if log.reference is None:
        raise ValueError("the log has no set-points")
    position, rate = log.reference
    error = position - robot.drive.motor_angle(log.q)
    error_rate = rate - robot.drive.motor_angle(log.dq)
    steps = 0.5 * log.dt * (error[1:] + error[:-1])
    return error, error_rate, np.concatenate([np.zeros_like(error[:1]), np.cumsum(steps, axis=0)])
