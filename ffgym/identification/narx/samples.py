"""What a network is fitted to, and how far its torque is from that."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.errors import FFGymError, check_number, check_shape
from ffgym.identification.narx.model import NarxModel
from ffgym.types import Array, BoolArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Samples:
    """Motor speed and the friction torque that belongs to it, at T even samples of one motion, motor side."""

    dt: float
    """Time between samples [s]."""
    motor_dq: Array
    """Motor speed [rad/s], shape (T, N)."""
    torque: Array
    """Friction torque [N m], shape (T, N)."""
    scored: BoolArray
    """Samples that a fit and its errors count, shape (T,); the others are still simulated and remembered."""
    noise: Array
    """Size of the torque's errors [N m], shape (N,), > 0; a motion with half of it counts four times as much."""

    def __post_init__(self) -> None:
        check_number("dt", self.dt, unit="s", low=0.0, open_low=True)
        shape = check_shape("motor_dq", self.motor_dq, (None, None)).shape
        check_shape("torque", self.torque, shape)
        if np.any(check_shape("noise", self.noise, shape[1:]) <= 0):
            raise FFGymError(f"noise = {self.noise} of samples for a NARX network must be > 0.")
        if self.scored.shape != shape[:1] or not np.any(self.scored):
            raise FFGymError(f"scored marks none of the {shape[0]} samples; a fit needs some.")


@dataclass(frozen=True, kw_only=True, eq=False)
class Misfit:
    """How far a torque is from the true one, motor side, shape (N,) each."""

    rms: Array
    """RMS of the difference [N m]."""
    share: Array
    """The same over the RMS of the torque."""
    fit: Array
    """100 (1 - |y - estimate| / |y - mean y|) [%], the fit of the System Identification Toolbox: 0 is the mean's."""

    @classmethod
    def of(cls, estimate: Array, torque: Array) -> "Misfit":
        """Compare two torques [N m], (T, N) each."""
        rms = _rms(estimate - torque)
        return cls(rms=rms, share=rms / _rms(torque), fit=100 * (1 - rms / torque.std(axis=0)))


@dataclass(frozen=True, kw_only=True, eq=False)
class Errors:
    """How well a network gives the torque of one motion, in its scored samples."""

    prediction: Misfit
    """One step ahead, with measured past torques."""
    simulation: Misfit
    """In free run, with its own past torques."""

    @classmethod
    def of(cls, model: NarxModel, samples: Samples) -> "Errors":
        """Errors of `model`, motor by motor."""
        rows, torque = samples.scored, samples.torque
        return cls(
            prediction=Misfit.of(model.predicted(samples.motor_dq, torque)[rows], torque[rows]),
            simulation=Misfit.of(model.simulated(samples.motor_dq)[rows], torque[rows]),
        )


def check_alike(records: Sequence[Samples]) -> None:
    """Refuse records that cannot be fitted together.

    Raises:
        FFGymError: if there is none, or sample times or numbers of motors differ.
    """
    if not records:
        raise FFGymError("There is no motion to fit a NARX network to.")
    for name, values in {
        "sample times [s]": {each.dt for each in records},
        "numbers of motors": {each.motor_dq.shape[1] for each in records},
    }.items():
        if len(values) > 1:
            raise FFGymError(f"Motions for one NARX network have different {name}: {sorted(values)}. Use one of them.")


def _rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
