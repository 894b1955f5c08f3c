"""Residuals of a fitted machine, with the states that they may depend on."""

from collections.abc import Mapping
from dataclasses import fields

import numpy as np

from ffgym.core.types import Array, IntArray
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.measured import counting_rows, measured_rows, valid_rows
from ffgym.diagnosis.moves import since_move
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.residual import Channel, MotionResidual, Residual
from ffgym.effects import State


def residual_of(log: Log, run: Replay, rest: Mapping[Channel, Array], floor: Mapping[Channel, Array]) -> Residual:
    """Residuals of all motions.

    Args:
        log: what was measured.
        run: replay of the machine whose residuals these are.
        rest: measured minus predicted, (R, M, C) by channel, less what calibration errors explain.
        floor: RMS of noise alone, (M, C).
    """
    at, valid, measured = log.sampling.at, valid_rows(log), measured_rows(log)
    counting = counting_rows(log)
    motor = run.robot.drive.motor_angle
    travel, stood = since_move(motor(run.log.q), motor(run.log.slip_dq), log.dt)
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
                judged={
                    channel: np.stack([counting[channel, c][:n, i] for c in range(rest[channel].shape[2])], axis=-1)
                    for channel in rest
                },
            )
        )
    return Residual(
        robot=log.robot,
        motions=tuple(motions),
        floor=dict(floor),
        has_temperature=log.temperature is not None,
        cutoff=log.sampling.cutoff,
    )


def _state_at(state: State, rows: IntArray, i: int, log: Log) -> State:
    """States at some samples of one motion, (R, N) each."""
    shape = log.q.shape
    return State(**{f.name: np.broadcast_to(getattr(state, f.name), shape)[rows, i] for f in fields(State)})
