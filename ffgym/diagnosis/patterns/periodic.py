"""Periodic forms: sines of a motor's angle or of time, and periodograms of the energy that a sine explains."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, final

import numpy as np
import scipy

from ffgym.core.errors import check_choice
from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.patterns.forms import Periodic, fit_columns
from ffgym.diagnosis.patterns.rows import PatternRows, collect_pattern_rows
from ffgym.diagnosis.residual import Channel, Residual, components
from ffgym.diagnosis.settings import settings

PADDING = 4
"""Transforms are so much longer than the data; a peak between two frequencies then keeps 0.95 of its energy."""

_FINE = 0.001
"""Tolerance of a refined frequency, in widths of its peak."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Spectrum:
    """Share of a residual's energy that a sine explains, by frequency."""

    frequency: Array
    """Cycles per motor turn, or [Hz], rising; shape (F,)."""
    share: Array
    """0 to 1, on the rows that it was fitted to, shape (F,)."""

    @property
    def best(self) -> float:
        """Frequency of the highest peak."""
        return float(self.frequency[np.argmax(self.share)])


def refine_frequency(frequency: float, within: float, columns: Callable[[float], Array], values: Array) -> float:
    """Refine a frequency, at most `within` from a peak, so that its columns (R, P) leave least of values (R,)."""

    def left(trial: float) -> float:
        fitted = columns(trial)
        rest = values - fitted @ fit_columns(fitted, values)
        return float(rest @ rest)

    bounds = (frequency - within, frequency + within)
    best = scipy.optimize.minimize_scalar(left, bounds=bounds, method="bounded", options={"xatol": _FINE * within})
    return float(best.x)


Amplitude = Literal["constant", "torque", "sign", "speed squared"]
"""Factor of the amplitude: one, the motor torque, the sign of the speed, or its square."""

LEAST_CYCLES, MOST_CYCLES = 0.5, 72.0
"""Cycles per motor turn that are looked for: from half a turn of a two-pole-pair resolver's error to slots of a large
motor times two; what rows cannot show is left out."""


def find_slow_rows(speed: Array, frequency: float, highest: float) -> BoolArray:
    """Find rows in which `frequency` cycles per turn are slow enough to be seen."""
    slow: BoolArray = frequency * np.abs(speed) / (2 * np.pi) < highest
    return slow


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PerTurn(Periodic):
    """A sine of the angle of a motor."""

    joint: int
    amplitude: Amplitude = "constant"
    own_only: bool = True

    def may_act_on(self, rows: PatternRows, component: int) -> bool:
        """Tell whether a component may depend on it; a gear error moves the tool at constant amplitude."""
        return super().may_act_on(rows, component) and (rows.channel != "tool" or self.amplitude == "constant")

    def spectra(self, rows: PatternRows, values: Array, train: BoolArray) -> list[Spectrum] | None:
        """Periodograms of values (R, C) over the angle, one for each column; None where the motor turns too little.

        Where a motor is so fast that rows do not show a vibration, they do not count for it. So each octave of
        frequencies has rows of its own.

        Reference:
            Zechmeister, Kuerster (2009), Astronomy & Astrophysics 496, 577-584: periodogram of a sine beside a mean.
        """
        limits = settings().patterns
        turns = np.ptp(rows.did["angle"][train, self.joint]) / (2 * np.pi)
        if turns * MOST_CYCLES < 2 * limits.fewest_periods:
            return None
        low, values = max(LEAST_CYCLES, limits.fewest_periods / turns), values[train]
        # periodogram octave by octave
        edges = np.geomspace(low, MOST_CYCLES, max(1, round(np.log2(MOST_CYCLES / low))) + 1).tolist()
        found = [self._octave(rows, values, train, *ends) for ends in pairwise(edges)]
        frequency = np.concatenate([frequency for frequency, _ in found])
        explained = np.concatenate([explained for _, explained in found], axis=1)
        energy = np.sum(values**2, axis=0)[:, None]
        share = np.divide(explained, energy, out=np.zeros_like(explained), where=energy > 0)
        return [Spectrum(frequency=frequency, share=one) for one in np.clip(share, 0.0, 1.0)]

    def _octave(
        self, rows: PatternRows, values: Array, train: BoolArray, low: float, high: float
    ) -> tuple[Array, Array]:
        """Frequencies (F,) from `low` to `high`, and the energy (C, F) of values in `train` that a sine explains."""
        limits = settings().patterns
        angle, motions = rows.did["angle"][train, self.joint], rows.motion[train]
        gain = np.where(
            find_slow_rows(rows.did["speed"][train, self.joint], high, rows.highest), self._gain(rows)[train], 0.0
        )
        # bins of the angle, so that sums over rows are one Fourier transform
        cell = 1.0 / (limits.cells * high)
        number = np.rint((angle - angle.min()) / (2 * np.pi * cell)).astype(np.intp)
        size = scipy.fft.next_fast_len(max(PADDING * (int(number.max()) + 1), round(4 / (cell * low))), real=True)
        frequency = np.arange(size // 2 + 1) / (size * cell)
        chosen = np.flatnonzero((frequency >= low) & (frequency < high))

        def sums(weights: Array, times: int = 1) -> tuple[Array, Array]:
            """Sums of weights (R,) times cosine and sine of so many times the phase, (F,) each."""
            transform = scipy.fft.rfft(np.bincount(number, weights=weights), size)[times * chosen]
            return transform.real, -transform.imag

        double, mixed = sums(gain**2, times=2)
        cosines = 0.5 * (gain @ gain + double) + limits.prior_rows
        sines = 0.5 * (gain @ gain - double) + limits.prior_rows
        both = 0.5 * mixed
        # each motion has a mean of its own
        for motion, count in enumerate(np.bincount(motions)):
            if count:
                c, s = sums(np.where(motions == motion, gain, 0.0))
                cosines, sines, both = cosines - c**2 / count, sines - s**2 / count, both - c * s / count
        # energy of the least-squares sine at each frequency
        explained = []
        for column in values.T:
            c, s = sums(gain * column)
            explained.append((sines * c**2 - 2 * both * c * s + cosines * s**2) / (cosines * sines - both**2))
        return frequency[chosen], np.stack(explained)

    def search(self, rows: PatternRows, values: Array, train: BoolArray) -> list[float] | None:
        """Search the highest peak of each column's spectrum."""
        spectra = self.spectra(rows, values, train)
        return None if spectra is None else [spectrum.best for spectrum in spectra]

    def refine(self, rows: PatternRows, values: Array, frequency: float) -> float:
        """Refine a frequency within half the width of its peak."""
        width = 1 / max(np.ptp(rows.did["angle"][:, self.joint]) / (2 * np.pi), 1.0)
        return refine_frequency(frequency, width / 2, lambda n: rows.centre(self.columns(rows, n)), values)

    def columns(self, rows: PatternRows, frequency: float) -> Array:
        """Compute cosine and sine."""
        j = self.joint
        gain = self._gain(rows) * find_slow_rows(rows.did["speed"][:, j], frequency, rows.highest)
        phase = frequency * rows.did["angle"][:, j]
        return gain[:, None] * np.stack([np.cos(phase), np.sin(phase)], axis=1)

    def complexity(self, rows: PatternRows) -> int:
        """Count numbers that are fitted."""
        return 3

    def _gain(self, rows: PatternRows) -> Array:
        if self.amplitude == "constant":
            return np.ones(len(rows.t))
        is_squared = self.amplitude == "speed squared"
        gain = rows.did["speed" if is_squared else self.amplitude][:, self.joint] ** (2 if is_squared else 1)
        size = rms(gain)
        return gain / size if size > 0 else gain


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SpectralLine(Periodic):
    """A vibration of one frequency in time, with a phase and an amplitude of its own in each motion.

    Of a joint, it turns over with the direction of its motor: friction that comes and goes, as of a brake that drags.
    """

    joint: int | None = None
    own_only: bool = False

    def may_act_on(self, rows: PatternRows, component: int) -> bool:
        """Tell whether a component may depend on it; what drags at a motor takes torque, and moves no tool."""
        return super().may_act_on(rows, component) and (self.joint is None or rows.channel != "tool")

    def search(self, rows: PatternRows, values: Array, train: BoolArray) -> list[float] | None:
        """Search the highest peak of each column's spectrum."""
        limits = settings().patterns
        if rows.highest <= limits.lowest_line:
            return None
        t, ends = rows.t, [*rows.motion_starts, len(values)]
        longest = max(np.ptp(t[a:b]) for a, b in pairwise(ends))
        size = scipy.fft.next_fast_len(max(4, round(PADDING * longest / rows.dt)), real=True)
        frequency = np.arange(size // 2 + 1) / (size * rows.dt)
        chosen, found = (frequency >= limits.lowest_line) & (frequency <= rows.highest), []
        for column in (values * self._sign(rows)[:, None]).T:
            # periodogram, a sum over motions
            total = np.zeros(size // 2 + 1)
            for a, b in pairwise(ends):
                used = train[a:b]
                if used.any():
                    at = np.rint((t[a:b][used] - t[a]) / rows.dt).astype(np.intp)
                    own = np.bincount(at, weights=column[a:b][used])
                    total += 2 * np.abs(scipy.fft.rfft(own, size)) ** 2 / used.sum()
            energy = float(column[train] @ column[train])
            share = total[chosen] / energy if energy > 0 else np.zeros(int(chosen.sum()))
            found.append(float(frequency[chosen][np.argmax(np.minimum(share, 1.0))]))
        return found

    def refine(self, rows: PatternRows, values: Array, frequency: float) -> float:
        """Refine a frequency within half the width of its peak."""
        longest = max(np.ptp(rows.t[rows.motion == m]) for m in range(len(rows.motion_starts)))
        return refine_frequency(frequency, 0.5 / longest, lambda f: rows.centre(self.columns(rows, f)), values)

    def columns(self, rows: PatternRows, frequency: float) -> Array:
        """Compute cosine and sine."""
        phase = 2 * np.pi * frequency * rows.t
        in_motion = rows.motion[:, None] == np.arange(len(rows.motion_starts))
        waves = np.stack([np.cos(phase), np.sin(phase)]) * self._sign(rows)
        return np.concatenate([in_motion * wave[:, None] for wave in waves], axis=1)

    def complexity(self, rows: PatternRows) -> int:
        """Count numbers that are fitted."""
        return 2 * len(rows.motion_starts) + 1

    def _sign(self, rows: PatternRows) -> Array:
        """Compute the sign (R,) that turns the vibration over."""
        return np.ones(len(rows.t)) if self.joint is None else rows.did["sign"][:, self.joint]


def compute_turn_spectrum(
    residual: Residual, channel: Channel, component: str, joint: str, *, amplitude: Amplitude = "constant"
) -> Spectrum | None:
    """Periodogram of one component of a residual over the motor angle of a joint, 0.5 to 72 cycles per turn.

    Frequencies are a quarter of the resolution apart, which is one over the turns that the motor makes in all.

    Args:
        residual: what a model leaves.
        channel: which of its channels.
        component: joint or axis of the channel.
        joint: whose motor turns.
        amplitude: what the amplitude goes with.

    Returns:
        None where there are no rows, or the motor turns too little for any period.

    Raises:
        FFGymError: if there is no such channel, component or joint.
    """
    check_choice("channel", channel, residual.channels)
    names = components(channel, residual.robot)
    check_choice("component", component, names)
    check_choice("joint", joint, residual.robot.joints)
    rows = collect_pattern_rows(residual, channel, np.random.default_rng(0))  # halves are not used
    if rows is None:
        return None
    values = rows.values[:, names.index(component)]
    everything = np.ones(len(values), dtype=np.bool_)
    spectra = PerTurn(joint=rows.joints.index(joint), amplitude=amplitude).spectra(rows, values[:, None], everything)
    return None if spectra is None else spectra[0]
