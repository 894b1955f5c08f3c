"""What a network is fitted to, and how far its torque is from that."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.narx.model import NarxModel


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
        for name, wanted in {"motor_dq": shape, "torque": shape, "noise": shape[1:]}.items():
            object.__setattr__(self, name, check_shape(name, getattr(self, name), wanted))
        if np.any(self.noise <= 0):
            raise FFGymError(f"noise = {self.noise} of samples for a NARX network must be > 0.")
        object.__setattr__(self, "scored", _checked_marks(self.scored, shape[0]))


@dataclass(frozen=True, kw_only=True, eq=False)
class Misfit:
    """How far a torque is from the true one, motor side, shape (N,) each."""

    rms: Array
    """RMS of the difference [N m]."""
    share: Array
    """The same over the RMS of the torque; NaN for a motor that has none."""
    fit: Array
    """100 (1 - |y - estimate| / |y - mean y|) [%], the fit of the System Identification Toolbox: 0 is the mean's. NaN
    for a motor whose torque does not change."""

    @classmethod
    def of(cls, estimate: Array, torque: Array) -> "Misfit":
        """Compare two torques [N m], (T, N) each."""
        rms = _rms(estimate - torque)
        return cls(rms=rms, share=_over(rms, _rms(torque)), fit=100 * (1 - _over(rms, torque.std(axis=0))))


@dataclass(frozen=True, kw_only=True, eq=False)
class Errors:
    """How well a network gives the torque of one motion, in its scored samples."""

    prediction: Misfit
    """One step ahead, with measured past torques."""
    simulation: Misfit
    """In free run, with its own past torques."""

    @classmethod
    def of(cls, model: NarxModel, samples: Samples) -> "Errors":
        """Errors of `model`, motor by motor.

        Raises:
            FFGymError: if the samples are of other motors, or further apart or closer than those of the network.
        """
        if not model.is_sampled_at(samples.dt):
            raise FFGymError(
                f"The NARX network was fitted to samples every {model.dt:g} s, these are {samples.dt:g} s apart; its "
                f"lags are counted in samples. Give it samples every {model.dt:g} s."
            )
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


def _checked_marks(scored: Any, n: int) -> BoolArray:
    """Truth values, shape (n,), some of them true; numbers are refused, since as an index they mean rows."""
    marks = np.asarray(scored)
    if marks.dtype != np.bool_ or marks.shape != (n,):
        raise FFGymError(
            f"scored has type {marks.dtype} and shape {marks.shape}, must be bool, one for each of {n} samples."
        )
    if not marks.any():
        raise FFGymError(f"scored marks none of the {n} samples; a fit needs some.")
    return marks


def _over(error: Array, size: Array) -> Array:
    return np.divide(error, size, out=np.full_like(error, np.nan), where=size > 0)


def _rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
