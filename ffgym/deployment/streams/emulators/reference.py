r"""Reference of an emulated servo: set-points behind the delay and the filter of a controller.

A set-point that the controller gets at t reaches the servo as

.. math:: \theta_{ref}(t) = F \{ G q_{set} \}(t), \quad F(s) = e^{-d s} / (1 + a_1 s + a_2 s^2)

straight between set-points; the speed reference is its derivative.
"""

from typing import Literal, final

import numpy as np
import scipy

from ffgym.control import SetpointResponse
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array
from ffgym.robot.drive import Drive

Missing = Literal["hold", "extrapolate"]
"""What a controller does in a cycle without a set-point: keep the last one, or go on at its speed."""


@final
class ControllerReference:
    """Reference that a controller makes of set-points, and of a program that it runs by itself, a cycle at a time."""

    def __init__(
        self,
        drive: Drive,
        start: Array,
        *,
        cycle: float,
        step: float,
        response: SetpointResponse,
        missing: Missing = "hold",
        program: Array | None = None,
    ) -> None:
        """Begin at rest.

        Args:
            drive: gears.
            start: joint positions, link side [rad or m], shape (N,).
            cycle: time between set-points [s].
            step: time between the samples that the servo gets [s].
            response: delay and filter; a delay is at least a cycle, since set-points are joined by straight lines.
            missing: what happens in a cycle without a set-point.
            program: joint positions at each cycle of a program, link side, shape (T, N), to which set-points are
                corrections; they alone are delayed and filtered. None takes positions.

        Raises:
            FFGymError: if times do not fit.
        """
        check_choice("behaviour without set-point", missing, ("hold", "extrapolate"))
        self._substeps = round(cycle / step)
        if abs(self._substeps * step - cycle) > 1e-9:
            raise FFGymError(f"The physics step of {step} s must divide the cycle of {cycle} s.")
        if response.delay < cycle - 1e-12:
            raise FFGymError(
                f"delay = {1e3 * response.delay:g} ms must be at least the cycle of {1e3 * cycle:g} ms: the controller "
                f"joins set-points by straight lines."
            )
        self._drive, self._cycle, self._step, self._response = drive, cycle, step, response
        self._missing, self._program = missing, program
        # set-points so far, oldest first, one a cycle; at rest before the start
        rest = start if program is None else np.zeros_like(start)
        self._received = [rest.copy() for _ in range(int(np.ceil(response.delay / cycle)) + 4)]
        self._filters = _StreamingFilter(response, step, rest), _StreamingFilter(response, step, np.zeros_like(start))
        self._rate_filter = _StreamingFilter(response, step, rest, speed=True) if response.lag else None
        self._last_late = rest
        self._run_cycles = 0
        self.position = np.tile(drive.motor_angle(start), (self._substeps + 1, 1))
        """Positions at the steps of this cycle and its end, motor side [rad], shape (S + 1, N)."""
        self.speed = np.zeros_like(self.position)
        """Speeds [rad/s], likewise."""
        self.change = np.zeros_like(start)
        """Acceleration of the filtered set-points at the end of this cycle, link side [rad/s^2], shape (N,)."""
        self.own_change = np.zeros_like(start)
        """Acceleration of the controller's own program at the end of this cycle, likewise."""

    @property
    def has_ended(self) -> bool:
        """True once the controller has come to the end of its program."""
        return self._program is not None and self._run_cycles >= len(self._program) - 1

    def advance(self, setpoint: Array | None, runs: bool) -> None:
        """Go on by a cycle, with the set-point that came at its beginning; the program goes on if it `runs`."""
        self._received = [*self._received[1:], self._fill() if setpoint is None else setpoint]
        received = np.stack(self._received)
        own, own_speed = self._advance_program(runs)
        late = self._late(received)
        reached = self._filters[0].next(late) + own
        if self._rate_filter is None:
            rate = np.diff(late, axis=0, prepend=self._last_late[None]) / self._step
            self._last_late = late[-1]
        else:
            rate = self._rate_filter.next(late)
        changes = self._late(_second_differences(received, self._cycle))
        self.change = self._filters[1].next(changes)[-1]
        self.position = np.vstack([self.position[-1:], self._drive.motor_angle(reached)])
        self.speed = np.vstack([self.speed[-1:], self._drive.motor_angle(rate + own_speed)])

    def _fill(self) -> Array:
        """Return the set-point of a cycle in which none came."""
        last, before = self._received[-1], self._received[-2]
        return last + (last - before) if self._missing == "extrapolate" else last

    def _late(self, samples: Array) -> Array:
        """Sample what came once a cycle at the steps of this one, late by the delay, shape (S, N).

        The last sample came at the beginning of the cycle.
        """
        last = len(samples) - 1
        times = np.arange(1, self._substeps + 1) * self._step - self._response.delay
        places = np.minimum(times / self._cycle + last, last)
        below = np.minimum(places.astype(np.int64), last - 1)
        share = (places - below)[:, None]
        late: Array = (1 - share) * samples[below] + share * samples[below + 1]
        return late

    def _advance_program(self, runs: bool) -> tuple[Array, Array]:
        """Run the controller's own program for a cycle; returns positions at the steps and its speed, link side."""
        if self._program is None:
            return np.zeros_like(self.change), np.zeros_like(self.change)
        last = len(self._program) - 1
        k = min(self._run_cycles, last)
        self._run_cycles = following = min(k + 1, last) if runs else k
        around = self._program[[max(following - 1, 0), following, min(following + 1, last)]]
        self.own_change = np.diff(around, 2, axis=0)[0] / self._cycle**2 if runs else np.zeros_like(self.change)
        share = (np.arange(1, self._substeps + 1) / self._substeps)[:, None]
        own: Array = (1 - share) * self._program[k] + share * self._program[following]
        return own, (self._program[following] - self._program[k]) / self._cycle


def _second_differences(samples: Array, dt: float) -> Array:
    """Compute accelerations of samples (K, N) that are `dt` [s] apart, shape (K, N); the last one is extrapolated."""
    between = np.diff(samples, 2, axis=0) / dt**2
    return np.vstack([between[:1], between, 2 * between[-1:] - between[-2:-1]])


class _StreamingFilter:
    """Filter of a controller, fed piece by piece; as `SetpointResponse.filter` does at once."""

    def __init__(self, response: SetpointResponse, dt: float, start: Array, *, speed: bool = False) -> None:
        """Begin at rest; a filter for `speed` gives that of what passes."""
        self._start, self._rest = start, np.zeros_like(start) if speed else start
        self._coefficients = response.discretise(dt, speed=speed)
        self._memory = np.zeros((max(map(len, self._coefficients)) - 1, len(start)))

    def next(self, values: Array) -> Array:
        """Filter the next values (S, N)."""
        b, a = self._coefficients
        filtered, self._memory = scipy.signal.lfilter(b, a, values - self._start, axis=0, zi=self._memory)
        return np.asarray(filtered) + self._rest
