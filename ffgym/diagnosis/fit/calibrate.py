"""Numbers of a machine within their calibration that explain a log, where slopes about the described ones do not.

Columns of a calibration are slopes. A spring that is a per cent stiffer than described swings at another frequency, and
after ten swings its phase is another one; masses that are known to five per cent are off by products of such shares.
Numbers are fitted by Gauss-Newton steps in a trust region, each with slopes about where the last one led: slopes that
stay do not lead to the numbers of an arm that swings, and long steps leave the valley in which those lie.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ffgym.diagnosis.calibration import Calibration, Doubt, doubts_of
from ffgym.diagnosis.evidence.solve import bounded
from ffgym.diagnosis.evidence.stack import Evidence, Stack, stack_of
from ffgym.diagnosis.fit.fit import Trial, trial_of
from ffgym.diagnosis.fit.numbers import possible_numbers
from ffgym.diagnosis.fit.setting import HELD, Setting, values_of
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.signatures.parts import Parts
from ffgym.effects import NativeEffect
from ffgym.plant import Machine
from ffgym.types import Array, BoolArray

_STEPS = 25
"""Steps at most; chosen: a six-axis arm whose numbers are off by 5 % takes about ten."""

_REACH = 0.5
"""Standard deviations by which a number moves in one step at most; chosen: at 1.5 an arm of six axes that swings came
to rest beside its numbers."""

_LEAST_REACH = 0.05
"""Reach below which a search has come to rest [standard deviations]."""

_STAYS = 0.005
"""Relative gain of a step below which further ones bring nothing, unless they go as far as they may."""

_BENT = 0.1
"""Energy in units of the noise's, of the component that has most, by which the first replay of fitted numbers differs
from what slopes say of it, from which on slopes do not do; chosen: chance comes to half."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Calibrated:
    """A nominal machine with other numbers."""

    machine: Machine
    sizes: Array
    """By which they differ, in standard deviations of the doubts; 0 for those that are no numbers of the robot."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Place:
    """A machine with numbers of its own, and what they leave."""

    sizes: Array
    trial: Trial
    machine: Machine
    evidence: Evidence
    cost: float
    """Energy that is left beside errors that are no numbers of the robot, and the squares of all errors."""


def calibrate(setting: Setting, calibration: Calibration) -> Calibrated | None:
    """Find numbers within their calibration that explain a log better than slopes tell; None if there are none."""
    described = trial_of(setting, ())
    if not setting.doubts or described is None:
        return None
    of_robot = np.array([issubclass(doubt.column.effect, NativeEffect) for doubt in setting.doubts])
    now = _at(setting, np.zeros(len(of_robot)), described, setting.nominal, setting.stack, of_robot)
    if now is None or not _is_bent(setting, now, of_robot):
        return None
    reach = _REACH
    for _ in range(_STEPS):
        step = _step(setting, now, of_robot, reach)
        there = _moved(setting, now, step, of_robot)
        if there is None or there.cost >= now.cost:
            reach = min(reach, float(np.max(np.abs(step)))) / 3
            if reach < _LEAST_REACH:
                break
            continue
        is_short = float(np.max(np.abs(step))) < 0.99 * reach
        is_last = there.cost > (1 - _STAYS) * now.cost and is_short
        slopes = None if is_last else _slopes(setting, there.trial, calibration)
        stays = slopes is None
        now = there if slopes is None else _about(setting, there, slopes, of_robot)
        reach = min(2 * reach, _REACH)
        if stays:
            break
    if not now.sizes.any():
        return None
    return Calibrated(machine=now.machine, sizes=now.sizes)


def _slopes(setting: Setting, trial: Trial, calibration: Calibration) -> Stack | None:
    """Columns of all errors about a machine; None if it has others than the described one."""
    doubts = doubts_of(trial.run, calibration)
    if len(doubts) != len(setting.doubts):
        return None
    return stack_of(setting.blocks, [_scaled(doubt) for doubt in doubts], setting.weights)


def _scaled(doubt: Doubt) -> Parts:
    return {key: rows * doubt.sigma for key, rows in doubt.column.parts.items()}


def _limits(setting: Setting) -> tuple[Array, Array, Array]:
    """Lowest and highest sizes, and where the nominal machine stands, in standard deviations, shape (K,) each."""
    low, high, at = (np.array([getattr(doubt, name) for doubt in setting.doubts]) for name in ("low", "high", "at"))
    return np.minimum(low, -HELD), np.maximum(high, HELD), at


def _at(
    setting: Setting, sizes: Array, trial: Trial, machine: Machine, slopes: Stack, of_robot: BoolArray
) -> _Place | None:
    """A place whose errors that are no numbers of the robot are fitted by slopes."""
    evidence = slopes.evidence(values_of(trial.residual))
    low, high, at = _limits(setting)
    rest = np.flatnonzero(~of_robot)
    gram, pull = evidence.gram.sum(axis=0)[np.ix_(rest, rest)], evidence.moment.sum(axis=0)[rest, 0]
    x = bounded(gram, pull - at[rest], np.ones(len(rest)), low[rest], high[rest])
    left = float(evidence.energy.sum() - 2 * x @ pull + x @ gram @ x)
    errors = at + sizes
    errors[rest] += x
    cost = left + float(errors @ errors)
    if not np.isfinite(cost):
        return None
    return _Place(sizes=sizes, trial=trial, machine=machine, evidence=evidence, cost=cost)


def _about(setting: Setting, place: _Place, slopes: Stack, of_robot: BoolArray) -> _Place:
    """The same place with slopes of its own."""
    return _at(setting, place.sizes, place.trial, place.machine, slopes, of_robot) or place


def _step(setting: Setting, now: _Place, of_robot: BoolArray, reach: float) -> Array:
    """Step of the numbers of the robot, beside all other errors, to a reach of each; shape (K,)."""
    low, high, at = _limits(setting)
    there = at + now.sizes
    low, high = low - now.sizes, high - now.sizes
    low = np.where(of_robot, np.maximum(low, -reach), low)
    high = np.where(of_robot, np.minimum(high, reach), high)
    gram, pull = now.evidence.gram.sum(axis=0), now.evidence.moment.sum(axis=0)[:, 0]
    ends = np.minimum(low, -HELD), np.maximum(high, HELD)
    step: Array = bounded(gram, pull - there, np.ones(len(there)), *ends) * of_robot
    return step


def _moved(setting: Setting, now: _Place, step: Array, of_robot: BoolArray) -> _Place | None:
    """The place after a step, with the slopes of the place before; None if no machine can be so."""
    sizes = now.sizes + step
    machine = possible_numbers(setting, sizes)
    trial = None if machine is None else trial_of(setting, (), machine)
    if machine is None or trial is None:
        return None
    return _at(setting, sizes, trial, machine, now.evidence.stack, of_robot)


def _is_bent(setting: Setting, now: _Place, of_robot: BoolArray) -> bool:
    """Tell whether a replay with the numbers that slopes give differs from what slopes say of it."""
    step = _step(setting, now, of_robot, np.inf)
    there = _moved(setting, now, step, of_robot)
    if there is None:
        return True
    beyond = _beyond(setting, step, now.trial.residual, there.trial.residual)
    weights, blocks = setting.weights, setting.blocks
    shares = []
    for (channel, c), weight in weights.items():
        if channel in beyond:
            rows = beyond[channel][:, :, c]
            counts = np.broadcast_to(weight, rows.shape) * (blocks.of_row >= 0)
            shares.append(float(np.sum((rows * counts) ** 2)) / max(int(np.count_nonzero(counts)), 1))
    return max(shares, default=0.0) > _BENT


def _beyond(
    setting: Setting, sizes: Array, plain: Mapping[Channel, Array], moved: Mapping[Channel, Array]
) -> dict[Channel, Array]:
    """Change by other numbers beyond what their slopes say, by what both machines leave, (R, M, C)."""
    found = {channel: plain[channel] - rows for channel, rows in moved.items()}
    for column, size in zip(setting.calibration, sizes.tolist(), strict=True):
        for (channel, c), rows in column.items():
            if channel in found:
                found[channel][:, :, c] -= size * rows
    return found
