"""Signals of one quantity in several columns: which is not like the others, and what was probably done to it."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import combinations
from typing import Literal

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.logs.quality.check import Seen
from ffgym.logs.quality.log import EXCITED, CheckedLog
from ffgym.logs.quality.signals import compare, correlations

Kind = Literal["units", "side", "sign", "permutation", "scale", "agreement"]

UNIT_FACTORS = {
    "degrees for radians": 180 / np.pi,
    "radians for degrees": np.pi / 180,
    "1/min for rad/s": 30 / np.pi,
    "turns for radians": 1 / (2 * np.pi),
    "thousandths for whole units": 1e3,
    "thousands for whole units": 1e-3,
}
"""Factors by which a column is multiplied when its unit is not the one of the schema."""

CLOSE = 0.05
"""Difference of two slopes that are the same: less than between any two factors that are looked for."""

_ALIKE = 0.9
"""Correlation of two signals of one quantity: a servo's error and the noise of recorded logs leave 0.97 and more."""

_TWINS = 0.98
"""Correlation of a signal with another from which on it may be the same: of another joint, or of a noisy sensor."""

_WHITE = 1.5
"""Variance of the steps of noise over its own from which on there is nothing else in it: 2 if it is white, next to 0
for motion."""

_NEAR = 0.2
"""Difference from a factor that is still that factor, where other reasons change the size as well: the nearest two
factors of one kind are 1.5 apart."""

_SAME_MOTION = 0.8
"""Correlation from which on a signal is of the same motion, whatever its size."""


_WINDOW = 0.01
"""Time [s] over which increments are taken: noise of single rows averages out, no planned motion turns around in it."""

_SLACK = 0.01
"""Difference [rad or m, link side] that servo errors, friction and elasticity may leave between set-points, motors and
links: recorded robots stay below 5 mrad, a joint that sticks in a small motion does too."""

LAG_SPAN = 0.3
"""Largest delay [s] that is looked for: beyond, periodic motions fit themselves again."""


_WHOLE, _PARTS = ("motor.effort", "command.effort"), ("feedforward.effort", "feedback.effort", "compensation.effort")
"""Families of the motor torque, and of the parts of its command."""

_OTHERWISE = "another scale or zero point"
"""Name of a change of a signal whose factor nothing explains."""


@dataclass(frozen=True, eq=False)
class TorqueSignals:
    """Signals of one quantity, by family: of two that disagree the first is believed."""

    joints: tuple[str, ...]
    """Names of the N joints."""
    values: Mapping[str, Array]
    """All on one side of the gearbox and in one unit, (T, N) each."""
    ratio: Array
    """Gear ratios, (N,)."""
    judged: BoolArray
    """Joints with enough motion to judge, (N,)."""
    window: int
    """Rows over which increments are taken: noise of single rows averages out."""
    lags: int
    """Rows up to which delays are looked for."""
    slack: float
    """Largest difference that servo errors and elasticity leave between signals of different channels."""
    noisy: bool
    """True if measured noise may be larger than the increments of a slow motion, so that values must agree instead."""

    @cached_property
    def increments(self) -> dict[str, Array]:
        """Changes over `window` rows, (T - window, N) each."""
        return {family: x[self.window :] - x[: -self.window] for family, x in self.values.items()}

    @property
    def numbers(self) -> list[int]:
        """Joints that are judged, by number."""
        return [int(j) for j in np.flatnonzero(self.judged)]

    @cached_property
    def misfits(self) -> tuple[tuple[Kind, Seen], ...]:
        """Signals of a joint that do not fit the majority, and in which way."""
        found = []
        for j in self.numbers:
            # the largest group of signals of a joint that agree is trusted, and the first of it says what is right
            groups = {family: {family} for family in self.values}
            for one, other in combinations(self.values, 2):
                if self._fits(one, other, j):
                    merged = groups[one] | groups[other]
                    groups |= dict.fromkeys(merged, merged)
            trusted = max(groups.values(), key=len)
            first = next(family for family in self.values if family in trusted)
            found += [self._explain(family, first, j) for family in self.values if family not in trusted]
        return tuple(misfit for misfit in found if misfit is not None)

    def lag(self, family: str, other: str, j: int, alike: float = _SAME_MOTION) -> float | None:
        """Rows by which one signal of joint `j` is later than another; None if they are less than `alike`."""
        if self._within_slack(family, other, j):
            return None
        seen = compare(self.increments[family][:, j], self.increments[other][:, j], self.lags)
        return seen.lag if seen.correlation > alike and abs(seen.slope - 1) < CLOSE else None

    def _within_slack(self, one: str, other: str, j: int) -> bool:
        """Tell whether two signals of different channels differ by no more than they may."""
        if channel_of(one) == channel_of(other):
            return False
        return bool(np.ptp(self.values[one][:, j] - self.values[other][:, j]) < self.slack)

    def _fits(self, one: str, other: str, j: int) -> bool:
        if self._within_slack(one, other, j):
            return True
        seen = compare(self.increments[one][:, j], self.increments[other][:, j])
        if seen.correlation > _ALIKE and abs(seen.slope - 1) < CLOSE:
            return True
        if not self.noisy:
            return False
        # noisy signals agree in their values, or in all but white noise and less than half a mean
        a, b = self.values[one][:, j], self.values[other][:, j]
        whole = compare(a - a.mean(), b - b.mean())
        if whole.correlation > _TWINS and abs(whole.slope - 1) < CLOSE:
            return True
        rest = a - b
        offset = abs(float(rest.mean()))
        white = float(np.var(np.diff(rest))) > _WHITE * float(np.var(rest))
        return white and offset < 0.5 * max(abs(float(a.mean())), abs(float(b.mean())), 2 * float(rest.std()))

    def _explain(self, family: str, other: str, j: int) -> tuple[Kind, Seen] | None:
        """Explain the difference of a signal of joint `j` from another; None if it is late only."""
        a, b = self.increments[family][:, j], self.increments[other]
        seen = compare(a, b[:, j], self.lags)
        if seen.correlation > _SAME_MOTION and abs(seen.slope - 1) < CLOSE:
            return None  # out of step only
        plain = abs(seen.correlation) > _TWINS and explain(seen.slope, float(self.ratio[j]), CLOSE)[0] != "scale"
        twin, value = None if plain else _twin(a, b, j, self.judged, self.ratio), seen.slope
        kind: Kind = "permutation"
        if twin is not None:
            text = "it is the signal of that joint"
        elif abs(seen.correlation) > _SAME_MOTION:
            kind, text = explain(seen.slope, float(self.ratio[j]), _NEAR)
        else:
            kind, value, text = "agreement", seen.correlation, "it is another motion, or another quantity"
        # what some controllers command lacks friction, so that commanded torques count half
        size = 0.5 if kind == "agreement" and family.endswith("effort") else 1.0
        size = abs(float(np.log(abs(value)))) if kind == "scale" else size
        columns = columns_of(family, self.joints[j])
        others = columns_of(other, self.joints[j if twin is None else twin])
        words = {"name": " + ".join(columns), "other": " + ".join(others), "factor": value, "text": text}
        return kind, Seen(size, (*columns, *others), self.joints[j], words)


def channel_of(family: str) -> str:
    """`motor` of `motor.position`."""
    return family.partition(".")[0]


def columns_of(family: str, joint: str) -> tuple[str, ...]:
    """Columns behind a signal: one, or those that are added up."""
    return tuple(f"{part}.{joint}" for part in family.split("+"))


def _twin(values: Array, others: Array, j: int, judged: BoolArray, ratio: Array) -> int | None:
    """Another joint whose signal this is, in the joint's own size or as its own gear makes it."""
    slope, correlation = correlations(values[:, None], others)
    through_gear = slope[0] * ratio[j] / ratio
    same_size = np.minimum(np.abs(slope[0] - 1), np.abs(through_gear - 1)) < CLOSE
    good = (correlation[0] > _TWINS) & same_size & judged
    good[j] = False
    return int(np.argmax(np.where(good, correlation[0], 0.0))) if good.any() else None


def explain(slope: float, ratio: float, tolerance: float) -> tuple[Kind, str]:
    """Explain a signal that is `slope` times as large as it should be, within a share `tolerance` of the factor."""
    factors: dict[str, tuple[Kind, float]] = {text: ("units", factor) for text, factor in UNIT_FACTORS.items()}
    if abs(abs(ratio) - 1) > 1:
        factors["motor side for link side"] = ("side", ratio)
        factors["link side for motor side"] = ("side", 1 / ratio)
    factors["the opposite sign"] = ("sign", -1.0)
    shares = {text: slope / factor for text, (_, factor) in factors.items()}
    distances = {text: abs(np.log(share)) if share > 0 else np.inf for text, share in shares.items()}
    text = min(distances, key=distances.__getitem__)
    return (factors[text][0], text) if distances[text] < np.log1p(tolerance) else ("scale", _OTHERWISE)


@lru_cache(maxsize=4)
def motion_signals(log: CheckedLog) -> TorqueSignals:
    """All that says how the joints move, as link-side positions."""
    moved = [np.ptp(x, axis=0) > EXCITED for x in log.motions.values()]
    judged = np.any(moved, axis=0) if moved else np.zeros(len(log.joints), dtype=np.bool_)
    return _signals(log, log.motions, _SLACK, judged, noisy=False)


@lru_cache(maxsize=4)
def torque_signals(log: CheckedLog) -> TorqueSignals:
    """Collect the signals of the motor torque: measured, commanded, sum of the parts of the command."""
    there = {f: log.recording.joint_array(f) for f in (*_WHOLE, *_PARTS) if log.recording.has(f)}
    values = {family: x for family, x in there.items() if family in _WHOLE}
    parts = {family: x for family, x in there.items() if family in _PARTS}
    if {"feedforward.effort", "feedback.effort"} <= set(parts):
        values["+".join(parts)] = np.sum([*parts.values()], axis=0)
    moves = np.any([np.ptp(x, axis=0) > 0 for x in values.values()] or [np.zeros(len(log.joints))], axis=0)
    return _signals(log, values, 0.0, moves & log.excited, noisy=True)


def _signals(
    log: CheckedLog, values: Mapping[str, Array], slack: float, judged: BoolArray, *, noisy: bool
) -> TorqueSignals:
    window = min(log.rows(_WINDOW), len(log.t) - 1)
    lags = min(max(3, round(LAG_SPAN / log.dt)), len(log.t) // 4)
    ratio = np.asarray(log.recording.header.gear_ratio)
    return TorqueSignals(log.joints, values, ratio, judged, window=window, lags=lags, slack=slack, noisy=noisy)
