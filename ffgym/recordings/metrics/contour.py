"""Deviation of the tool from any path: across it (contour error) and along it (lag)."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy

from ffgym.core.errors import FFGymError, check_class, check_number
from ffgym.core.measures import rms
from ffgym.core.types import Array, IntArray
from ffgym.recordings import Phase, Recording
from ffgym.recordings.metrics.path_error import standstill_offset

WINDOW = 0.05
"""Time before and after the present instant in which the nearest point of the path is looked for [s]. Chosen: eight
times the 6 ms by which the built-in robot lags without compensation, and less than the 63 ms of the fastest turn of the
thesis, so that a path may cross or retrace itself later."""
WHOLE = "whole motion"
"""Label of errors of the whole motion."""
_PIECES = 8
"""Straight pieces between two rows of the reference: on a circle of 1 mm at 100 mm/s, recorded every ms, they leave
the circle by 20 nm."""
_REST = 1e-6
"""Speed of the reference [m/s] below which it has no direction; the slowest test motions run at 1e-2."""
_BLOCK = 8192
"""Rows refined at a time, to bound memory."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Contour:
    """The TCP beside its reference path, at the T rows of a recording in which it was seen.

    The offset between TCP and reference at the start (gravity sag, tracker frame) is removed before.
    """

    rows: IntArray
    """Rows of the recording, shape (T,)."""
    nearest: Array
    """Nearest points of the reference path [m], shape (T, 3)."""
    error: Array
    """TCP - nearest point [m], shape (T, 3); its length is the contour error."""
    lag: Array
    """Lag of the TCP behind its reference along the present direction of motion [m], shape (T,); 0 at rest."""

    @classmethod
    def of(cls, recording: Recording, window: float = WINDOW) -> Self:
        """Compare TCP and reference of a recording.

        The nearest point is looked for up to `window` [s] before and after each instant; a tool that lags by more is
        charged for it. A recording in which the TCP was never seen is an error.
        """
        window = check_number("window", window, unit="s", low=0.0)
        reference = recording.vector("tcp_reference.position")
        tcp = recording.vector("tcp.position") - start_offset(recording)
        rows = np.flatnonzero(~np.isnan(tcp).any(axis=1))
        points = tcp[rows]
        # nearest sample of the reference, then nearest point of the curve about it
        near = _nearest_rows(points, rows, reference, round(window / recording.dt))
        curve = scipy.interpolate.CubicSpline(recording.t, reference)
        nearest = _refine(points, recording.t[near], curve, recording.t)
        # lag: deviation along the direction of the reference
        velocity = curve(recording.t[rows], 1)
        speed = np.linalg.norm(velocity, axis=1)
        direction = np.divide(velocity, speed[:, None], out=np.zeros_like(velocity), where=speed[:, None] > _REST)
        lag = ((reference[rows] - points) * direction).sum(axis=1)
        return cls(rows=rows, nearest=nearest, error=points - nearest, lag=lag)

    @property
    def distance(self) -> Array:
        """Contour error [m], shape (T,), >= 0."""
        return np.asarray(np.linalg.norm(self.error, axis=1))


@dataclass(frozen=True, kw_only=True)
class ContourError:
    """Deviation of the TCP from a stretch of its path, in space [m]."""

    label: str
    """Name of the phase, or WHOLE; several phases may have one name."""
    start: float
    """Start of the stretch, on the clock of the recording [s]."""
    end: float
    """End of the stretch [s]."""
    rms: float
    """Root mean square distance to the nearest point of the path."""
    max: float
    """Largest distance to the nearest point of the path."""
    lag_rms: float
    """Root mean square of the lag along the path."""
    lag_max: float
    """Largest lag, without sign."""


def contour_errors(recording: Recording) -> list[ContourError]:
    """Compute contour error and lag of the whole motion without standstill, then of every phase in motion.

    Phases in which the TCP was never seen are left out. Errors as `Contour.of`; a recording that is all
    standstill is refused.
    """
    check_class("recording", recording, Recording, "read_recording makes one")
    moving = ~recording.mask(kind="standstill")
    contour = Contour.of(recording)
    if not moving[contour.rows].any():
        raise FFGymError(
            f"Recording {recording.header.segment!r} shows no TCP in motion, so it has no path error to score."
        )
    # whole motion first, then each phase in motion
    whole = Phase(label=WHOLE, kind="motion", start=float(recording.t[0]), end=float(recording.t[-1]))
    stretches = [(whole, moving)]
    stretches += [(phase, recording.during(phase)) for phase in recording.header.phases if phase.kind != "standstill"]
    errors = []
    for phase, rows in stretches:
        within = rows[contour.rows]
        if not within.any():
            continue
        # error across the path and lag along it, where the TCP was seen
        distance, lag = contour.distance[within], np.abs(contour.lag[within])
        errors.append(
            ContourError(
                label=phase.label,
                start=phase.start,
                end=phase.end,
                rms=rms(distance),
                max=float(distance.max()),
                lag_rms=rms(lag),
                lag_max=float(lag.max()),
            )
        )
    return errors


def start_offset(recording: Recording) -> Array:
    """Compute the mean of TCP minus reference at the standstill that a motion begins with [m], shape (3,).

    Without such a standstill it is that of the first row in which the TCP was seen.

    Raises:
        FFGymError: if the recording has no TCP there.
    """
    phases = recording.header.phases
    if phases and phases[0].kind == "standstill":
        return standstill_offset(recording)
    away = recording.vector("tcp.position") - recording.vector("tcp_reference.position")
    seen = np.flatnonzero(~np.isnan(away).any(axis=1))
    if seen.size == 0:
        raise FFGymError(f"Recording {recording.header.segment!r} has no TCP position in any row.")
    return np.asarray(away[seen[0]])


def _nearest_rows(points: Array, rows: IntArray, reference: Array, reach: int) -> IntArray:
    """Find the row of the reference within `reach` of each row that is nearest to its point."""
    best = np.full(len(rows), np.inf)
    near: IntArray = rows.copy()
    for shift in range(-reach, reach + 1):
        candidate = np.clip(rows + shift, 0, len(reference) - 1)
        square = ((points - reference[candidate]) ** 2).sum(axis=1)
        closer = square < best
        best, near = np.where(closer, square, best), np.where(closer, candidate, near)
    return near


def _refine(points: Array, near: Array, curve: "scipy.interpolate.CubicSpline", t: Array) -> Array:
    """Refine nearest points (T, 3) on the curve within a sample of the times `near` (T,)."""
    dt = float(np.median(np.diff(t)))
    steps = dt * np.linspace(-1.0, 1.0, 2 * _PIECES + 1)
    nearest = np.empty_like(points)
    for first in range(0, len(points), _BLOCK):
        block = slice(first, first + _BLOCK)
        drawn = curve(np.clip(near[block, None] + steps, t[0], t[-1]))
        nearest[block] = nearest_on_polylines(points[block], drawn)
    return nearest


def nearest_on_polylines(points: Array, corners: Array) -> Array:
    """Find nearest points (T, D) to `points` (T, D), each on a polyline of its own, with corners (T, C, D)."""
    start, along = corners[:, :-1], np.diff(corners, axis=1)
    square = (along**2).sum(axis=2)
    ahead = ((points[:, None] - start) * along).sum(axis=2)
    share = np.divide(ahead, square, out=np.zeros_like(ahead), where=square > 0).clip(0.0, 1.0)
    feet = start + share[:, :, None] * along
    best = ((points[:, None] - feet) ** 2).sum(axis=2).argmin(axis=1)
    nearest: Array = feet[np.arange(len(points)), best]
    return nearest
