r"""Noise that is not white: what torque sensors and drives add slowly.

Above the band in which machines move, a signal shows what its noise is made of: a white part, one of which a share
:math:`\varphi` stays from one sample to the next,

.. math:: S(\omega) = \frac{2 \Delta t\, s^2}{1 - 2 \varphi \cos \omega + \varphi^2},

and nothing else where it is quiet. How large :math:`s` is, is known from there; how much stays, from
the quiet parts of what a model leaves in the band that is compared. So nothing of a residual is taken for noise that
does not go on, falling, above the band of motions. Samples may be so rare that no band is left above it in which
anything could be seen to fall: there, noise goes on into the band as far as its quiet parts show it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ffgym.core.types import Array
from ffgym.diagnosis.sampling import estimate_noise_above_band
from ffgym.diagnosis.settings import settings
from ffgym.logs.preparation import LowPass

_ABOVE, _BELOW = 1.2, 0.48
"""Frequencies that are looked at above the band of motions: from this multiple of the low-pass on, which is not sharp,
up to this share of the sample rate."""

_CORNERS = np.geomspace(0.5, 100.0, 60)
"""Frequencies below which noise falls no more, that are tried [Hz]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NoiseSpectrum:
    """A part of noise that falls with the frequency, beside white noise; of N components."""

    fresh: Array
    """Standard deviation s of what is new in each sample, shape (N,); 0 where noise is white."""
    stays: Array
    """Share phi of a sample that stays to the next, shape (N,)."""
    white: Array
    """Standard deviation of the white part, shape (N,), where there is another."""

    @property
    def is_white(self) -> bool:
        """Tell whether no component has anything but white noise."""
        return not np.any(self.fresh)

    def beside(self, white: Array) -> Array:
        """Standard deviations `white` (M, N) of noise above the band, less the part of it that falls."""
        return np.where(self.fresh > 0, self.white, white)

    def drawn(self, j: int, n: int, rng: np.random.Generator) -> Array:
        """Samples of the falling part of component `j`, (n,)."""
        if self.fresh[j] == 0:
            return np.zeros(n)
        stays, new = float(self.stays[j]), self.fresh[j] * rng.normal(size=n)
        new[0] /= np.sqrt(1 - stays**2)
        samples: Array = scipy.signal.lfilter([1.0], [1.0, -stays], new)
        return samples


def estimate_noise_spectrum(
    signal: Sequence[Array],
    left: Sequence[Array],
    white: Sequence[Array],
    cutoff: float,
    low_pass: LowPass,
    dt: float,
    *,
    level: Array | None = None,
    alike: bool = False,
) -> NoiseSpectrum:
    """Colour of the noise of signals, pooled over motions; (T_i, N) each, at all samples.

    Args:
        signal: what was measured.
        left: what a model leaves of it.
        white: what the model leaves of itself with white noise.
        cutoff: up to which frequency that is compared [Hz].
        low_pass: of the motion.
        dt: sample period [s].
        level: standard deviation (N,) that white noise would have with as much above the band; None is looked for here.
        alike: whether components are axes of one sensor, whose noise has one memory.
    """
    # energies of quiet parts: of the signal above the band, of both residuals inside it
    limits = settings().noise
    n = signal[0].shape[1]
    none = NoiseSpectrum(fresh=np.zeros(n), stays=np.zeros(n), white=np.zeros(n))
    fast = [values - low_pass(values, dt) for values in signal]
    above, inside, known = (_compute_spectra(rows, dt) for rows in (fast, left, white))
    if above is None or inside is None or known is None:
        return none
    # middles of the groups [Hz]
    groups = np.arange(above.shape[1], dtype=np.float64)
    frequency: Array = (limits.lowest_periods + (groups + 0.5) * limits.frequencies_per_group - 0.5) / (
        round(limits.part / dt) * dt
    )
    high = (frequency > _ABOVE * low_pass.cutoff) & (frequency < _BELOW / dt)
    low = frequency < cutoff
    if not high.any() or not low.any():
        return none
    # energy (N, H) of a signal by that of what a low-pass took from it, above its cut-off
    heard = np.asarray(
        _estimate_floor(above[:, high]) / (1 - low_pass.gain(frequency[high], dt)) ** 2, dtype=np.float64
    )
    of_band = frequency[low], _estimate_floor(inside[:, low]), _estimate_floor(known[:, low])
    # too few or too high frequencies above the band: extend noise from there into the band; else fit its fall
    found = np.zeros((3, n))
    if high.sum() < limits.fewest_groups or frequency[high][0] * dt > limits.flat_from:
        if level is not None:  # known better than from so few frequencies
            heard = np.maximum(heard, 2 * dt * level[:, None] ** 2)
        is_steady = heard.mean(axis=1) < limits.steady * _estimate_floor(known[:, high]).mean(axis=1)
        for one in [np.arange(n)] if alike else list(np.arange(n)[:, None]):
            if is_steady[one].all():
                fresh, stays = _extend_into_band(
                    frequency[high], heard[one], of_band[0], of_band[1][one], of_band[2][one], dt
                )
                found[0, one], found[1, one] = fresh, stays
    else:
        # energy in the quietest short stretches: a step or a blow lies between them, noise does not
        shortest = np.mean([estimate_noise_above_band(values, low_pass, dt) ** 2 for values in signal], axis=0)
        for j in np.flatnonzero(heard.mean(axis=1) < limits.steady * 2 * dt * shortest):
            fresh_j, flat = _fit_falling(frequency[high], heard[j], dt)
            found[:, j] = fresh_j, _fit_memory(of_band[0], of_band[1][j], of_band[2][j], fresh_j, flat, dt), flat
    # what is as small as rounding is no noise
    rounding = limits.rounding_share * np.max([values.std(axis=0) for values in signal], axis=0)
    found[:, found[0] < rounding] = 0.0
    return NoiseSpectrum(fresh=found[0], stays=found[1], white=found[2])


def _extend_into_band(
    frequency: Array, energy: Array, inside: Array, left: Array, known: Array, dt: float
) -> tuple[Array, float]:
    """Find what is fresh (J,) and the share that stays, where samples are too rare to see how noise falls.

    It is then what goes on from above the band, energies (J, H), into it, (J, L), in the parts of the band that are
    quiet; noise is white if nothing of the kind explains these.
    """
    limits = settings().noise
    fast, white = inside > 0.5 * inside[-1], np.zeros(len(energy))
    if np.median(left / known) < limits.beyond_white:
        return white, 0.0
    # noise of each corner frequency, as loud above the band as measured
    shares = np.exp(-2 * np.pi * _CORNERS * dt)
    fresh = np.array([np.sqrt(np.mean(energy / _shape(share, frequency, dt), axis=1)) for share in shares])
    angles = np.maximum(known - energy.mean(axis=1)[:, None], 0.0)  # what the model leaves of itself beside white noise
    # take the corner whose noise and that of angles come nearest to what is left in the band
    over = np.stack(
        [left / (angles + s[:, None] ** 2 * _shape(share, inside, dt)) for s, share in zip(fresh, shares, strict=True)]
    )
    best = int(np.argmin(np.abs(np.median(np.log(over), axis=(1, 2)))))
    if (
        over[best][:, fast].mean() > limits.beyond_falling
    ):  # more than noise of that kind can be: what is left is a fault
        return white, 0.0
    return fresh[best], float(shares[best])


def _fit_falling(frequency: Array, energy: Array, dt: float) -> tuple[float, float]:
    """Standard deviations of what falls, fresh in each sample, and of the white part beside it; 0 if nothing falls."""
    shapes = np.stack([np.full_like(frequency, 2 * dt), _shape(1.0, frequency, dt)], axis=1)
    largest = shapes.max(axis=0)
    sizes = scipy.optimize.nnls(shapes / largest / energy[:, None], np.ones(len(frequency)))[0] / largest
    if sizes[1] * shapes[0, 1] < settings().noise.coloured_from * sizes[0] * shapes[0, 0]:
        return 0.0, 0.0
    return float(np.sqrt(sizes[1])), float(np.sqrt(sizes[0]))


def _fit_memory(frequency: Array, left: Array, known: Array, fresh: float, flat: float, dt: float) -> float:
    """Share of noise that stays, by what is left in the band beyond what the model leaves of itself."""
    limits = settings().noise
    if fresh == 0:
        return 0.0
    shares = np.exp(-2 * np.pi * _CORNERS * dt)
    beside = np.maximum(known, 2 * dt * flat**2)
    over = np.stack([left / (beside + fresh**2 * _shape(share, frequency, dt)) for share in shares])
    fast = frequency > 0.5 * frequency[-1]
    if (
        np.mean(over[0, fast]) > limits.beyond_falling
    ):  # than all of such noise: what is left is a fault, and says nothing of noise
        return float(np.exp(-2 * np.pi * limits.usual_corner * frequency[-1] * dt))
    return float(shares[int(np.argmin(np.abs(np.log(over.mean(axis=1)))))])


def _shape(stays: float, frequency: Array, dt: float) -> Array:
    """One-sided energy per Hz of noise of which a share stays, per square of what is fresh."""
    shape: Array = 2 * dt / (1 - 2 * stays * np.cos(2 * np.pi * frequency * dt) + stays**2)
    return shape


def _compute_spectra(rows: Sequence[Array], dt: float) -> Array | None:
    """One-sided energy per Hz (B, G, N) of all parts of motions, in groups of frequencies; None of too few parts."""
    limits = settings().noise
    width, spectra = round(limits.part / dt), []
    window = scipy.signal.windows.hann(width, sym=False)[:, None]
    time: Array = np.linspace(-1.0, 1.0, width, dtype=np.float64)[:, None]
    for values in rows if width > 4 * limits.frequencies_per_group else ():
        n = len(values) // width
        for part in values[: n * width].reshape(n, width, values.shape[1]):
            # less mean and slope, which would leak into the lowest frequencies
            about = part - part.mean(axis=0)
            about = about - time * np.sum(about * time, axis=0) / np.sum(time**2)  # its straight line
            spectra.append(2 * dt / float(np.sum(window**2)) * np.abs(np.fft.rfft(about * window, axis=0)) ** 2)
    if len(spectra) < limits.fewest_parts:
        return None
    # means over neighbouring frequencies scatter less than single lines
    energy: Array = np.stack(spectra)[:, limits.lowest_periods :]
    n_groups = energy.shape[1] // limits.frequencies_per_group
    groups: Array = (
        energy[:, : n_groups * limits.frequencies_per_group]
        .reshape(len(energy), n_groups, limits.frequencies_per_group, -1)
        .mean(axis=2)
    )
    return groups


def _estimate_floor(energy: Array) -> Array:
    """Energy of noise (N, F) at each frequency, by that of the quiet parts (B, F, N); chance makes some quiet."""
    limits = settings().noise
    by_chance = float(scipy.stats.chi2.ppf(limits.quiet_share, limits.degrees_of_freedom)) / limits.degrees_of_freedom
    found: Array = np.maximum(np.quantile(energy, limits.quiet_share, axis=0) / by_chance, np.finfo(np.float64).tiny)
    return found.T
