"""What predictions leave of the torque of each motor."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.rigid_body.observation import Equations


@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueErrors:
    """RMS motor torque and what predictions leave of it, motor side [N m], shape (N,) each, over rows that move."""

    measured: Array
    described: Array
    """The description, its friction at steady speed."""
    identified: Array
    """All terms that were fitted."""
    in_file: Array
    """What a parameter file holds: fitted again without offsets, asymmetry and springs."""


def torque_errors(equations: Equations, estimate: Array, in_file: Array) -> TorqueErrors:
    """Errors of the equations with all that was found, and with what a parameter file holds of it, (K,) each."""
    counts, robot = equations.counts, equations.robot
    described = np.concatenate([term.described(robot) for term in equations.terms])
    return TorqueErrors(
        measured=_rms(equations.measured, counts),
        described=_rms(equations.residual(described), counts),
        identified=_rms(equations.residual(estimate), counts),
        in_file=_rms(equations.residual(in_file), counts),
    )


def _rms(values: Array, counts: BoolArray) -> Array:
    """Root mean square over the rows that count for each motor, (N,); NaN where none does."""
    with np.errstate(invalid="ignore"):
        return np.sqrt((np.where(counts, values, 0.0) ** 2).sum(axis=0) / counts.sum(axis=0))
