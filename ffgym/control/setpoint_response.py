r"""Response of a controller between a set-point that is sent and the servo that follows it: a delay and a low-pass.

.. math:: F(s) = \frac{e^{-d s}}{1 + a_1 s + a_2 s^2}

One first-order lag has a_1 as its time constant and a_2 = 0; a filter of second order with natural frequency w and
damping z has a_1 = 2 z / w and a_2 = 1 / w^2.
"""

from dataclasses import dataclass
from typing import Self, final

import numpy as np
import scipy

from ffgym.core.errors import FFGymError, check_number
from ffgym.core.types import Array

_LONGEST = 1.0
"""Largest delay [s] and coefficients of a filter [s, s^2]; chosen: what is larger is a slip of units."""
_FINE = 16
"""Steps of the filter in a control step; of a filter at 20 Hz they leave 1e-6 of the signal (chosen)."""


@final
@dataclass(frozen=True, kw_only=True)
class SetpointResponse:
    """Delay and smoothing filter of a controller; the default is none."""

    delay: float = 0.0
    """Time between sending and the servo [s]."""
    lag: float = 0.0
    """Coefficient a_1 of the filter [s]: its delay at low frequencies."""
    curvature: float = 0.0
    """Coefficient a_2 of the filter [s^2]."""

    def __post_init__(self) -> None:
        for name, unit in (("delay", "s"), ("lag", "s"), ("curvature", "s^2")):
            check_number(f"{name} of set-points", getattr(self, name), unit=unit, low=0.0, high=_LONGEST)
        if self.curvature > 0 and self.lag == 0:
            raise FFGymError(
                f"A filter with curvature {self.curvature} s^2 and lag 0 s rings for ever; its lag must be > 0."
            )

    @classmethod
    def low_pass(cls, cutoff: float, *, delay: float = 0.0, damping: float | None = None) -> Self:
        """Make a response with a filter of a cut-off frequency.

        Args:
            cutoff: frequency [Hz] at which a filter of first order passes 1/sqrt(2), or natural frequency of one of
                second order.
            delay: time beside the filter [s].
            damping: damping ratio of a filter of second order, 0.71 is Butterworth's; None is first order.
        """
        time = 1 / (2 * np.pi * check_number("cutoff", cutoff, unit="Hz", low=0.0, open_low=True))
        if damping is None:
            return cls(delay=delay, lag=time)
        damping = check_number("damping", damping, low=0.0, open_low=True)
        return cls(delay=delay, lag=2 * damping * time, curvature=time**2)

    @property
    def total_delay(self) -> float:
        """Delay at low frequencies [s], that of the filter included."""
        return self.delay + self.lag

    def describe(self) -> str:
        """Describe delay and filter in one phrase."""
        if not self.lag:
            return f"delay {self.delay * 1e3:.2f} ms, no filter"
        if not self.curvature:
            return f"delay {self.delay * 1e3:.2f} ms, first-order filter at {1 / (2 * np.pi * self.lag):.1f} Hz"
        natural = 1 / np.sqrt(self.curvature)
        return (
            f"delay {self.delay * 1e3:.2f} ms, second-order filter at {natural / (2 * np.pi):.1f} Hz with damping "
            f"{self.lag * natural / 2:.2f}"
        )

    def apply(self, sent: Array, dt: float, rows_per_step: int = 1) -> Array:
        """Compute what reaches the servo of set-points or corrections (T, N), at the same samples and between.

        They are at rest before the first sample, and straight between samples `dt` [s] apart.

        Args:
            sent: set-points or corrections.
            dt: time between them [s].
            rows_per_step: rows of the result between two of them, a divisor of 16.
        """
        fine = np.arange(_FINE * (len(sent) - 1) + 1) * (dt / _FINE) - self.delay
        late = scipy.interpolate.make_interp_spline(np.arange(len(sent)) * dt, sent, k=1)(np.maximum(fine, 0.0))
        return self.filter(late - sent[0], dt / _FINE)[:: _FINE // rows_per_step] + sent[0]

    def filter(self, values: Array, dt: float) -> Array:
        """Low-pass values (..., T, N) sampled every `dt` [s] along T, straight between samples, zero before them."""
        if not self.lag:
            return values
        b, a = self.discretise(dt)
        return np.asarray(scipy.signal.lfilter(b, a, values, axis=-2))

    def discretise(self, dt: float, *, speed: bool = False) -> tuple[Array, Array]:
        """Compute numerator and denominator of the filter in steps of `dt` [s], for values straight between them.

        Args:
            dt: time of a step [s].
            speed: True for the derivative of what passes the filter, which must have a lag.
        """
        if not self.lag:
            return np.ones(1), np.ones(1)
        denominator = np.array([self.curvature, self.lag, 1.0] if self.curvature else [self.lag, 1.0])
        numerator = np.array([1.0, 0.0] if speed else [1.0])
        b, a, _ = scipy.signal.cont2discrete((numerator, denominator), dt, method="foh")
        return np.ravel(b), a

    def invert(self, wanted: Array, dt: float) -> Array:
        """Compute what to send so that set-points or corrections (T, N) reach the servo as wanted, at the same samples.

        They are sent early by the delay, with speed and acceleration times the coefficients of the filter added. What
        would have to be sent before the first sample is lost; after the last one they rest.
        """
        t = np.arange(len(wanted)) * dt
        spline, early = scipy.interpolate.make_interp_spline(t, wanted, k=3), t + self.delay
        ended = (early > t[-1])[:, None]
        filtered = spline(early) + self.lag * spline(early, 1) + self.curvature * spline(early, 2)
        return np.where(ended, wanted[-1], filtered)
