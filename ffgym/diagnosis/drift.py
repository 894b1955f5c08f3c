"""Friction levels recording by recording: what changed from one day to the next, beside a model of all of them.

Causes are of the machine, and act in every recording. Oil that runs in, a winter morning and wear change friction
between days, and no motion of one recording shows it. So the levels of each joint are fitted to each recording alone,
to what the model leaves there. Motions that differ make levels differ where the form of friction is not quite that of
the model; what changes steadily with the days, by more than that, is a change of the machine. Of both levels of a joint
the one counts that explains more.
"""

import re
from collections.abc import Mapping, Sequence
from datetime import date

import numpy as np
import scipy

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.resampling import TimeBlocks
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.residual_rows import find_counting_rows
from ffgym.diagnosis.result import Drift
from ffgym.diagnosis.sensitivity import compute_sensitivities
from ffgym.diagnosis.settings import settings
from ffgym.effects.friction.coulomb import CoulombLevel
from ffgym.effects.friction.viscous import ViscousLevel
from ffgym.recordings import Recording

_DATE = re.compile(r"(?<!\d)(\d{4}|\d{2})[-_.]?(0[1-9]|1[0-2])[-_.]?(0[1-9]|[12]\d|3[01])(?!\d)")
"""A date in the name of a recording: year, month and day in that order."""

_LEVELS = (CoulombLevel, ViscousLevel)


def find_drifts(log: Log, run: Replay, rest: Mapping[Channel, Array], blocks: TimeBlocks) -> tuple[Drift, ...]:
    """Find friction levels that change steadily from day to day.

    Args:
        log: recordings of which each is judged by itself.
        run: replay of the model that they are compared with.
        rest: what it leaves, (R, M, C) by channel.
        blocks: of rows, whose sums are what errors are known from.
    """
    limits = settings().verdict
    days = read_days(log.recordings)
    if len(log.recordings) < limits.drift_recordings or days is None or np.ptp(days) < limits.drift_days:
        return ()
    # levels of both kinds in each recording, by joint
    counting = find_counting_rows(log)
    columns = {(c.effect.name, c.joint): c.parts for c in compute_sensitivities(run, _LEVELS, {})}
    found: list[Drift] = []
    for j, joint in enumerate(log.robot.joints):
        torque, rows = rest["torque"][..., j], counting["torque", j]
        levels = {
            kind.name: _fit_levels(own, torque, rows, blocks)
            for kind in _LEVELS
            if (own := columns[kind.name, joint].get(("torque", j))) is not None
        }
        if not levels:
            continue
        # of both levels the one that leaves less, if it changes steadily, by more than chance and by more than little
        name = min(levels, key=lambda kind: levels[kind][2])
        values, errors, _ = levels[name]
        known = np.isfinite(values) & (errors > 0)
        v, e, day = values[known], errors[known], days[known]
        if len(v) < limits.drift_recordings or len(np.unique(day)) < 2:
            continue
        rate, error, chance = _fit_line(v, e, day)
        if chance > limits.drift_level or abs(rate) * np.ptp(day) < limits.drift_size or not _is_steady(v, e, day):
            continue
        # report it with the recordings whose level is known
        found.append(
            Drift(
                effect=name,
                joint=joint,
                motions=tuple(name for name, there in zip(log.names, known, strict=True) if there),
                days=tuple(day.tolist()),
                changes=tuple(v.tolist()),
                errors=tuple(e.tolist()),
                per_day=rate,
                per_day_error=error,
            )
        )
    return tuple(found)


def read_days(recordings: Sequence[Recording]) -> Array | None:
    """Read days since the first recording from `recorded` in its meta data or its name; None if one has neither."""
    found = []
    for recording in recordings:
        text = str(recording.header.meta.get("recorded", recording.header.segment))
        match = _DATE.search(text)
        if match is None:
            return None
        year, month, day = (int(part) for part in match.groups())
        try:
            found.append(date(year + (2000 if year < 100 else 0), month, day).toordinal())
        except ValueError:
            return None
    return np.array(found, dtype=np.float64) - min(found)


def _fit_levels(column: Array, rest: Array, counting: BoolArray, blocks: TimeBlocks) -> tuple[Array, Array, float]:
    """Fit one level beside a constant in each motion; the other level stays: along one motion both are collinear.

    Rows of a block say the same: errors are those of sums over blocks (White's estimate, clustered).

    Returns:
        Change of the level, relative, shape (M,), NaN where it is not known; standard error of that, shape (M,); and
        energy that is left of the torque [(N m)^2].
    """
    values, errors, left = np.full(rest.shape[1], np.nan), np.full(rest.shape[1], np.nan), 0.0
    for m in range(rest.shape[1]):
        # least squares of the level and a constant in one motion
        rows = counting[:, m] & (blocks.of_row[:, m] >= 0)
        x = np.stack([column[rows, m], np.ones(np.count_nonzero(rows))], axis=1)
        y, block = rest[rows, m], blocks.of_row[rows, m]
        if len(np.unique(block)) < settings().verdict.drift_blocks or np.linalg.matrix_rank(x) < x.shape[1]:
            continue
        inverse = np.linalg.inv(x.T @ x)
        size = inverse @ x.T @ y
        # error from sums over blocks
        scores = np.stack([x[block == b].T @ (y - x @ size)[block == b] for b in np.unique(block)])
        n = len(scores)
        covariance = inverse @ (scores.T @ scores) @ inverse * n / (n - x.shape[1])
        values[m], errors[m] = size[0], np.sqrt(covariance[0, 0])
        left += float(np.sum((y - x @ size) ** 2))
    return values, errors, left


_ROUNDS = 5
"""Times that a line is fitted, and what levels scatter about it beyond their errors (method of moments)."""


def _fit_line(values: Array, errors: Array, day: Array) -> tuple[float, float, float]:
    """Fit a line of levels over days: slope, standard error, and the probability of as steep a slope by chance.

    Levels scatter about a line by more than their errors; how much is found by iteration (method of moments).
    """
    n, scatter = len(values), 0.0
    for _ in range(_ROUNDS):
        sigma = np.hypot(errors, scatter)
        x = np.stack([np.ones(n), day], axis=1) / sigma[:, None]
        inverse = np.linalg.inv(x.T @ x)
        line = inverse @ x.T @ (values / sigma)
        excess = float(np.sum((values / sigma - x @ line) ** 2)) - (n - 2)
        scatter = float(np.sqrt(max(scatter**2 + excess / np.sum(sigma**-2.0), 0.0)))
    rate, error = float(line[1]), float(np.sqrt(inverse[1, 1]))
    return rate, error, float(2 * scipy.stats.t.sf(abs(rate) / error, n - 2))


def _is_steady(values: Array, errors: Array, day: Array) -> bool:
    """Tell whether a change keeps its sign, and stays significant, without any one day; else that day is an outlier."""
    limits = settings().verdict
    rate = _fit_line(values, errors, day)[0]
    for one in np.unique(day):
        rest = day != one
        if len(np.unique(day[rest])) < 2 or rest.sum() < limits.drift_recordings:
            continue
        other, _, chance = _fit_line(values[rest], errors[rest], day[rest])
        if other * rate < 0 or chance > limits.drift_holds:
            return False
    return True
