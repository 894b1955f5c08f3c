r"""What pushes change in a replay, to first order: those behind the gearbox bend the springs.

A push p bends them by

.. math:: M \Delta\ddot\delta + d \Delta\dot\delta + K \Delta\delta = p

which changes the load of the motors and the place of the tool.
"""

from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.replay.springs import COARSE
from ffgym.diagnosis.signatures.push import Push


@dataclass(frozen=True, kw_only=True, eq=False)
class Change:
    """What a push changes in what is compared, at R rows."""

    torque: Array
    """Of the motors, motor side [N m], shape (R, M, N)."""
    link: Array
    """Of the links, link side [rad], shape (R, M, N)."""


def changes(run: Replay, pushes: list[Push]) -> list[Change]:
    """What each of several pushes changes; those behind the gearbox are solved for together."""
    behind = [push for push in pushes if push.links is not None or push.spring is not None]
    bent = _bent(run, behind)
    return [_change(run, push, bent.get(id(push))) for push in pushes]


def _bent(run: Replay, pushes: list[Push]) -> dict[int, tuple[Array, Array]]:
    """How pushes bend the springs: rows of the deflection (R, M, N) [rad] and of the torque that the joints then carry.

    Solved at coarser samples than the replay: what is compared has no faster parts.
    """
    if not pushes:
        return {}
    every, none = _coarseness(run), np.zeros_like(run.log.q)
    sampling, springs = run.log.sampling.coarser(every), run.coarse_springs(every)
    load = np.stack(
        [
            _smoothed((none if p.spring is None else p.spring) - (0.0 if p.links is None else p.links), every)
            for p in pushes
        ],
        axis=-1,
    )
    flown = springs.bent_by(load)
    drive, state = run.robot.drive, run.state
    angle = sampling(flown.angle)
    carried = -(state.joint_stiffness[:, None] * angle + state.joint_damping[:, None] * sampling(flown.rate))
    if drive.is_rigid.any():
        asked = sampling(springs.bending_torque(flown))
        carried = np.where(drive.is_rigid[:, None], asked, carried)
    return {id(push): (angle[..., i], carried[..., i]) for i, push in enumerate(pushes)}


def _coarseness(run: Replay) -> int:
    """Samples from one step of the springs to the next: a divisor of the rows' stride, at most COARSE apart."""
    stride, dt = run.log.sampling.stride, run.log.dt
    return max(n for n in range(1, stride + 1) if stride % n == 0 and (n == 1 or n * dt <= COARSE))


def _smoothed(values: Array, every: int) -> Array:
    """Means about every n-th sample."""
    if every == 1:
        return values
    total = np.cumsum(np.pad(values, ((1, 0), (0, 0), (0, 0))), axis=0)
    at = np.arange(0, len(values), every)
    low, high = np.maximum(at - every // 2, 0), np.minimum(at + (every + 1) // 2, len(values))
    means: Array = (total[high] - total[low]) / (high - low)[:, None, None]
    return means


def _change(run: Replay, push: Push, bent: tuple[Array, Array] | None) -> Change:
    sampling, drive = run.log.sampling, run.robot.drive
    rows = (len(sampling.at), *run.log.q.shape[1:])
    torque = np.zeros(rows) if push.motor is None else sampling(push.motor)
    link = np.zeros(rows) if push.joint_q is None else sampling(push.joint_q)
    if bent is not None:
        angle, carried = bent
        if push.spring is not None:
            carried = carried + sampling(push.spring)
        if push.links is not None and drive.is_rigid.any():
            carried = carried + np.where(drive.is_rigid, sampling(push.links), 0.0)
        torque = torque + drive.motor_torque(carried)
        link = link + angle
    return Change(torque=torque, link=link)
