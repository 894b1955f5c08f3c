r"""Safety envelope of a stream: how far and how fast a correction may go, and when it has to leave.

A correction that is sent is

.. math:: c_{sent}(t) = g(t) \, c(t)

where c follows the plan within limits of size, rate and acceleration, and the gate g falls from 1 to 0 and never rises.
It falls within `ramp` when the controller has been silent for `patience`, and within `fade` when the motion ends or
somebody stops it. Thus |c_sent| is at most the largest size, and between two samples it changes by at most

.. math:: rate \, \Delta t_{plan} + size \, \Delta t / ramp

whatever arrives, or does not. Every stream uses this one envelope, and no part of it knows a protocol.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.control.corrections import CorrectionLimits, limit_correction
from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array

LONGEST_SILENCE = 0.020
"""Time after the last valid packet at which every correction is out [s]."""


_LATE = 0.004
"""Time beyond a long cycle that the controller's packets may be late [s]; chosen."""


def usual_silence(cycle: float) -> float:
    """Return the usual patience [s] with a controller whose cycle is `cycle` [s]: that of `Envelope`, or longer."""
    return max(Envelope.patience, cycle + _LATE)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Envelope:
    """Limits of what a stream may add to a program.

    Raises:
        FFGymError: if a limit is infinite, or a correction would be out later than 20 ms after the last valid packet.
    """

    correction: CorrectionLimits
    """Largest correction, rate and acceleration of each joint, link side [rad or m, per s, per s^2], shape (N,)."""
    torque: Array
    """Largest feed-forward torque of each motor [N m], shape (N,), for streams that send torques."""
    patience: float = 0.010
    """Silence of the controller after which the correction begins to leave [s]; the default lets one packet in 4 ms be
    lost, and the next one be 2 ms late."""
    ramp: float = 0.010
    """Time in which it then leaves [s]."""
    fade: float = 0.2
    """Time in which it leaves at the end of a motion, or when it is stopped [s]."""
    start_tolerance: float = 0.002
    """Largest distance of the measured pose from the first pose of the program [rad or m]."""

    def __post_init__(self) -> None:
        n = len(self.correction.size)
        for name in ("size", "rate", "acceleration"):
            check_shape(f"largest {name} of the correction", getattr(self.correction, name), (n,))
        if np.any(check_shape("largest torque of a stream", self.torque, (n,)) < 0):
            raise FFGymError(f"largest torque of a stream = {self.torque.tolist()} N m must be >= 0.")
        for name in ("patience", "ramp", "fade", "start_tolerance"):
            unit = "rad or m" if name == "start_tolerance" else "s"
            check_number(name, getattr(self, name), unit=unit, low=0.0, open_low=True)
        if self.patience + self.ramp > LONGEST_SILENCE + 1e-12:
            raise FFGymError(
                f"patience + ramp = {1e3 * (self.patience + self.ramp):g} ms: a correction must be out "
                f"{1e3 * LONGEST_SILENCE:g} ms after the last valid packet. Shorten one of them."
            )

    def limit(self, corrections: Array, dt: float) -> Array:
        """Bring corrections (T, N), sampled every `dt` [s], within size, rate and acceleration; none within changes."""
        return limit_correction(self.correction, corrections, dt)

    def cut_share(self, corrections: Array, dt: float) -> float:
        """Compute by which share corrections (T, N) exceed the limit they exceed most; 0 is within all."""
        excess = self.correction.find_excess(corrections, dt)
        return float(max(share.max() for share in excess.values()))


@final
class Guard:
    """Envelope at work: the last thing that a correction passes before it is sent.

    Times are of one clock, the sender's own [s].
    """

    def __init__(self, envelope: Envelope, dt: float) -> None:
        """Begin with no correction and the gate closed.

        Args:
            envelope: limits.
            dt: time of a sample of the plan [s].
        """
        self.envelope = envelope
        self._most = envelope.correction.rate * dt
        self._correction = np.zeros_like(envelope.correction.size)
        self._last_valid: float | None = None
        self._ramps: list[tuple[float, float]] = []
        self.lost_at: float | None = None
        """Time at which the controller had been silent too long [s]; None if it has not been."""

    def hear(self, now: float) -> None:
        """Take note of a valid packet; the first one opens the gate."""
        if self._last_valid is None:
            self._last_valid = now
        self._watch(now)
        self._last_valid = max(self._last_valid, now)

    def close(self, now: float) -> None:
        """Let the correction leave within `fade`, as at the end of a motion."""
        self._ramps.append((now, self.envelope.fade))

    def gate(self, now: float) -> float:
        """Compute the share of the correction that may be sent, from 1 down to 0."""
        if self._last_valid is None:
            return 0.0
        self._watch(now)
        return max(0.0, min([1.0, *(1 - (now - start) / duration for start, duration in self._ramps)]))

    def correct(self, wanted: Array, samples: int, now: float) -> Array:
        """Compute the correction to send.

        Args:
            wanted: correction of the plan at this sample, link side [rad or m], shape (N,); no number counts as the
                one before.
            samples: samples of the plan since the last call, >= 0.
            now: time [s].
        """
        limits, before = self.envelope.correction, self._correction
        goal = wanted if np.isfinite(wanted).all() else np.where(np.isfinite(wanted), wanted, before)
        most = self._most * samples
        step = np.minimum(np.maximum(goal - before, -most), most)
        self._correction = np.minimum(np.maximum(before + step, -limits.size), limits.size)
        sent: Array = self.gate(now) * self._correction
        return sent

    def torque(self, wanted: Array, now: float) -> Array:
        """Compute the feed-forward torque to send, motor side [N m], shape (N,); no number counts as 0."""
        most = self.envelope.torque
        goal = wanted if np.isfinite(wanted).all() else np.where(np.isfinite(wanted), wanted, 0.0)
        sent: Array = self.gate(now) * np.minimum(np.maximum(goal, -most), most)
        return sent

    def _watch(self, now: float) -> None:
        """Begin the ramp if the controller has been silent for too long; it is not taken back."""
        assert self._last_valid is not None
        if self.lost_at is None and now - self._last_valid > self.envelope.patience:
            self.lost_at = self._last_valid + self.envelope.patience
            self._ramps.append((self.lost_at, self.envelope.ramp))
