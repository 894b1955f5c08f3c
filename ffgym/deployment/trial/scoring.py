"""Error of a run: of the tool path where a tracker saw the tool, else of the motors; without the sensor's noise."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.deployment.trial.program import find_scored_rows
from ffgym.recordings import Recording
from ffgym.recordings.metrics import Contour, motor_error, rms_without_noise

Measure = Literal["tool", "motors"]


@dataclass(frozen=True)
class Unit:
    """Unit in which errors of a measure are told."""

    name: str
    factor: float
    """Number of them in one of SI."""
    words: str
    """What is measured."""


UNITS: Mapping[Measure, Unit] = MappingProxyType(
    {
        "tool": Unit("um", 1e6, "RMS distance of the tool from its path"),
        "motors": Unit("mrad", 1e3, "RMS length of the motors' position errors, motor side"),
    }
)


@dataclass(frozen=True, kw_only=True)
class RunError:
    """Error of a run."""

    size: float
    """In the unit of its measure."""
    doubt: float
    """Relative standard deviation that noise of the sensor leaves."""


def sees_tool(recording: Recording) -> bool:
    """Tell if a tracker saw the tool in a pass where it counts."""
    if not recording.has("tcp.position"):
        return False
    return bool((find_scored_rows(recording) & _seen(recording)).any())


def score_run(passes: Sequence[Recording], measure: Measure) -> RunError:
    """Compute the error of a run, of all its passes together.

    Args:
        passes: recordings of one pass or more, as `find_passes` makes them.
        measure: the tool's distance from its path (`Contour`, offset at the start removed); or the motors' errors, less
            a lag that all motors have throughout, as it moves no tool off its path and clocks of logs may hold one.

    Raises:
        FFGymError: if too few samples count.
    """
    parts = [_score(recording, measure) for recording in passes]
    size = float(np.sqrt(np.mean([part.size**2 for part in parts])))
    doubt = float(np.sqrt(np.sum([(part.doubt * part.size**2) ** 2 for part in parts])) / len(parts) / size**2)
    return RunError(size=size, doubt=doubt)


def _score(recording: Recording, measure: Measure) -> RunError:
    scored = find_scored_rows(recording)
    if measure == "tool":
        contour = Contour.of(recording)
        errors, counts = contour.error, scored[contour.rows]
    else:
        errors, counts = _without_lag(recording, scored), scored
    quiet = rms_without_noise(errors, counts)
    return RunError(size=UNITS[measure].factor * quiet.rms, doubt=quiet.doubt)


def _without_lag(recording: Recording, counts: BoolArray) -> Array:
    """Compute motor errors less the part that is one lag of all motors [rad], motor side, shape (T, N)."""
    errors = motor_error(recording)
    speed = np.gradient(recording.joint_array("reference.position"), recording.t, axis=0)
    lag = np.sum((speed * errors)[counts]) / np.sum(speed[counts] ** 2)
    return np.asarray(errors - lag * speed)


def _seen(recording: Recording) -> BoolArray:
    tool: Array = recording.vector("tcp.position")
    return np.asarray(np.isfinite(tool).all(axis=1))
