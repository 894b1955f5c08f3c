"""Figures of every circle in a recording of the circle test."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.recordings import Recording
from ffgym.recordings.metrics import motor_error_rms, path_errors


@dataclass(frozen=True, kw_only=True)
class CircleScore:
    """One circle: path error [mm] and motor error [rad]."""

    radius_mm: float
    rms_mm: float
    """In the plane of the circle, as the thesis."""
    max_mm: float
    rms_3d_mm: float
    """In space."""
    max_3d_mm: float
    motor_rms_rad: list[float]
    """Per joint, motor side, over lead-in, circle and lead-out."""


def circle_scores(recording: Recording, radii: Sequence[float]) -> list[CircleScore]:
    """Figures of the circles of these radii [m], in the order in which they were run.

    Raises:
        FFGymError: if the recording lacks a column.
    """
    leads = zip(recording.phases_of("lead_in"), recording.phases_of("lead_out"), strict=True)
    scores = []
    for error, radius, (lead_in, lead_out) in zip(path_errors(recording), radii, leads, strict=True):
        stretch = recording.slice(lead_in.start, lead_out.end)
        scores.append(
            CircleScore(
                radius_mm=in_mm(radius),
                rms_mm=error.rms * 1e3,
                max_mm=error.max * 1e3,
                rms_3d_mm=error.rms_3d * 1e3,
                max_3d_mm=error.max_3d * 1e3,
                motor_rms_rad=[float(x) for x in np.asarray(motor_error_rms(stretch))],
            )
        )
    return scores


def in_mm(length: float) -> float:
    """Millimetres as cells carry them, without the rounding of binary fractions."""
    return round(float(length) * 1e3, 6)
