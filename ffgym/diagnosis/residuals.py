"""Residuals of a fitted machine, with the states that they may depend on."""

from collections.abc import Mapping
from dataclasses import fields

import numpy as np

from ffgym.diagnosis.log import Log
from ffgym.diagnosis.measured import measured_rows, valid_rows
from ffgym.diagnosis.replay.replay import Replay
from ffgym.diagnosis.residual import Channel, MotionResidual, Residual
from ffgym.effects import State
from ffgym.types import Array, IntArray

_AT_REST = 0.05
"""Motor speed below which a motor stands [rad/s], motor side; below the Stribeck speed of gearboxes, 0.1 rad/s and
more."""


def residual_of(log: Log, run: Replay, rest: Mapping[Channel, Array], floor: Mapping[Channel, Array]) -> Residual:
    """Residuals of all motions.

    Args:
        log: what was measured.
        run: replay of the machine whose residuals these are.
        rest: measured minus predicted, (R, M, C) by channel, less what calibration errors explain.
        floor: RMS of noise alone, (M, C).
    """
    at, valid, measured = log.sampling.at, valid_rows(log), measured_rows(log)
    travel, stood = _since_reversal(run), _stood(run, log.dt)
    motions = []
    for i, name in enumerate(log.names):
        n = int(np.searchsorted(at, len(log.recordings[i])))
        rows = at[:n]
        motions.append(
            MotionResidual(
                motion=name,
                t=log.t[rows],
                valid=valid[:n, i],
                measured={channel: measured[channel][:n, i] for channel in rest},
                predicted={channel: measured[channel][:n, i] - rest[channel][:n, i] for channel in rest},
                state=_state_at(run.state, rows, i, log),
                motor_acceleration=run.robot.drive.motor_angle(run.log.ddq[rows, i]),
                since_reversal=travel[rows, i],
                at_rest_for=stood[rows, i],
            )
        )
    return Residual(
        robot=log.robot, motions=tuple(motions), floor=dict(floor), has_temperature=log.temperature is not None
    )


def _state_at(state: State, rows: IntArray, i: int, log: Log) -> State:
    """States at some samples of one motion, (R, N) each."""
    shape = log.q.shape
    return State(**{f.name: np.broadcast_to(getattr(state, f.name), shape)[rows, i] for f in fields(State)})


def _since_reversal(run: Replay) -> Array:
    """Travel of each motor since it last turned [rad], (T, M, N)."""
    angle = run.robot.drive.motor_angle(run.log.q)
    moving = run.robot.drive.motor_angle(run.log.slip_dq)
    direction = np.sign(np.where(np.abs(moving) < _AT_REST, 0.0, moving))
    travel, last, began = np.zeros_like(angle), np.zeros_like(angle[0]), angle[0].copy()
    for k in range(len(angle)):
        turned = (direction[k] != 0) & (direction[k] != last)
        began = np.where(turned, angle[k], began)
        last = np.where(direction[k] != 0, direction[k], last)
        travel[k] = np.abs(angle[k] - began)
    return travel


def _stood(run: Replay, dt: float) -> Array:
    """How long each motor had stood when its present move began [s], (T, M, N)."""
    moving = np.abs(run.robot.drive.motor_angle(run.log.slip_dq)) >= _AT_REST
    stood, standing, before = np.zeros(moving.shape), np.zeros(moving.shape[1:]), np.zeros(moving.shape[1:])
    for k in range(len(moving)):
        before = np.where(moving[k] & (standing > 0), standing, before)
        standing = np.where(moving[k], 0.0, standing + dt)
        stood[k] = before
    return stood
