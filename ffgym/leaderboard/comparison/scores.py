"""Scores of a row on a grid of plants and circles, beside the row that adds no torque."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.leaderboard.comparison.samples import Grid, Sample, outcomes_on
from ffgym.leaderboard.comparison.statistics import (
    Interval,
    Resamples,
    difference,
    draw_resamples,
    interquartile_mean,
    interval,
    resample_iqms,
    resample_means,
)
from ffgym.leaderboard.results import Row


@dataclass(frozen=True, kw_only=True)
class SpeedScore:
    """Mean RMS path error over all circles at one speed, seeds and plants."""

    speed_mm_s: float
    rms_um: float
    """Infinite if the robot stopped on any of them."""
    interval_um: Interval | None
    """Interval of the mean; None without randomness."""
    reduction: float
    """Reduction of the mean as a share of the zero action's; negative if the error has grown."""


@dataclass(frozen=True, kw_only=True)
class Score:
    """One row on one grid. Infinite stands for a robot that stopped; an interval is None without randomness."""

    left: float
    """Geometric mean over seeds, plants and circles of error / error with zero action, by which rows are ranked."""
    left_interval: Interval | None
    iqm_um: float
    """Interquartile mean of the RMS path error."""
    iqm_interval_um: Interval | None
    speeds: tuple[SpeedScore, ...]
    """Scores by speed, slowest first."""
    max_um: float
    """Largest deviation of all."""
    iqm_3d_um: float
    """Interquartile mean of the RMS path error in space."""
    motor_mrad: tuple[float, ...]
    """Mean RMS position error of every joint, motor side; empty if the robot stopped everywhere."""
    normalised: float | None
    """Interquartile mean of (zero - e) / (zero - oracle) over circles on which the oracle helps; None without one."""
    worse: float
    """Share of runs with a larger error than zero action on the same plant and circle."""
    stopped: float
    """Share of runs in which the robot stopped."""
    seeds: tuple[int, ...]
    robot_seconds: float
    """Robot time, mean over seeds and plants [s]."""
    env_steps: float
    """Steps of training, mean over seeds and plants."""
    inference_us: float | None
    """Median over seeds and plants of the time of one decision."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ScoredRow:
    """Errors of a row on a grid, and the resampled logarithms of their ratios to the zero action's errors."""

    row: Row
    sample: Sample
    logs: Array
    """ln(e / e_zero), shape (S, P, C)."""
    by: Resamples
    means: Array
    """Mean of `logs` in every resample, shape (R,)."""

    @classmethod
    def of(cls, row: Row, sample: Sample, zero: Sample) -> "ScoredRow":
        """Score a row; `zero` are the errors with zero action on the same grid."""
        logs = np.log(sample.rms) - np.log(zero.rms).mean(axis=0)
        by = draw_resamples(row.name, *logs.shape[:2])
        return cls(row=row, sample=sample, logs=logs, by=by, means=resample_means(logs, by))

    @property
    def mean(self) -> float:
        """Mean of `logs`: the score, smaller is better."""
        return float(self.logs.mean())


@dataclass(frozen=True, kw_only=True)
class Difference:
    """Ratio of the errors of two rows, paired by plant and circle."""

    ratio: float
    """Geometric mean of the ratio of both rows' errors; below 1 the first one is better."""
    interval: Interval | None
    """Interval of the ratio; None without randomness."""

    @property
    def sign(self) -> int:
        """-1 if the first row is better, 1 if it is worse, 0 if the interval includes no difference."""
        if self.interval is not None and self.interval.includes(1.0):
            return 0
        return int(np.sign(self.ratio - 1))


def compare_rows(first: ScoredRow, second: ScoredRow) -> Difference:
    """Compare two rows on the same grid; two that both stopped do not differ."""
    levels = min((each.by.levels for each in (first, second) if each.by.levels > 1), default=1)
    spread = interval(np.exp(difference(first.means, second.means)), levels)
    return Difference(ratio=float(np.exp(difference(np.array(first.mean), np.array(second.mean)))), interval=spread)


def compute_score(scored: ScoredRow, grid: Grid, zero: Sample, oracle: Sample | None) -> Score:
    """Compute all figures of a row on a grid, beside zero action and the oracle there."""
    sample, by = scored.sample, scored.by
    outcomes = outcomes_on(scored.row, grid)
    times = [outcome.inference_us for outcome in outcomes if outcome.inference_us is not None]
    spread = interval(scored.means, by.levels)
    # mean error at each speed, and its reduction
    speeds = []
    for speed in grid.speeds_mm_s:
        values, before = (each.rms[..., grid.at(speed)] * 1e3 for each in (sample, zero))
        mean, ends = float(values.mean()), interval(resample_means(values, by), by.levels)
        gone = 1 - mean / float(before.mean())
        speeds.append(SpeedScore(speed_mm_s=speed, rms_um=mean, interval_um=ends, reduction=gone))
    # means of logarithms are given back as ratios of the error left
    return Score(
        left=float(np.exp(scored.mean)),
        left_interval=None if spread is None else Interval(float(np.exp(spread.low)), float(np.exp(spread.high))),
        iqm_um=interquartile_mean(sample.rms) * 1e3,
        iqm_interval_um=None if by.levels < 2 else interval(resample_iqms(sample.rms * 1e3, by), by.levels),
        speeds=tuple(speeds),
        max_um=float(sample.max.max()) * 1e3,
        iqm_3d_um=interquartile_mean(sample.rms_3d) * 1e3,
        motor_mrad=tuple(float(value) * 1e3 for value in sample.motor.mean(axis=(0, 1, 2))),
        normalised=None if oracle is None else _normalise(sample, zero, oracle),
        worse=float((scored.logs > 0).mean()),
        stopped=float(np.isinf(sample.rms).mean()),
        seeds=sample.seeds,
        robot_seconds=float(np.mean([outcome.robot_seconds for outcome in outcomes])),
        env_steps=float(np.mean([outcome.env_steps for outcome in outcomes])),
        inference_us=float(np.median(times)) if times else None,
    )


def _normalise(sample: Sample, zero: Sample, oracle: Sample) -> float | None:
    """Compute the interquartile mean of the share of the oracle's gain; None if the oracle helps nowhere."""
    nothing, best = zero.rms.mean(axis=0), oracle.rms.mean(axis=0)
    helps = best < nothing
    if not helps.any():
        return None
    shares = (nothing - sample.rms)[:, helps] / (nothing - best)[helps]
    return 0.0 - interquartile_mean(-shares)  # the worst, minus infinity, at the end where a mean looks for it
