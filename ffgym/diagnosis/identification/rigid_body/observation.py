"""Recordings as linear equations: filtered columns of all parameters beside filtered motor torque."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import scipy

from ffgym.core.errors import FFGymError, check_number
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.rigid_body.terms import (
    BODIES,
    TERMS,
    Term,
    elastic_motion,
    read_description,
    rigid_motion,
)
from ffgym.diagnosis.resampling import Blocks
from ffgym.logs.preparation import LowPass, read_acting_torque, read_joint_motion
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription

_ROWS_PER_CUTOFF = 2.5
"""Rows kept per period of the cut-off of the parallel filter; Gautier's rule, 0.8 of half the new sample rate."""

_BLOCK = 1.0
"""Length [s] of the blocks that are resampled for intervals; long against what correlates errors."""


@dataclass(frozen=True, kw_only=True)
class Filtering:
    """Filter and selection of rows, from recordings to equations."""

    motion: LowPass = field(default_factory=lambda: LowPass(cutoff=40.0, order=4))
    """Of motor angles, before they are differentiated."""
    parallel: LowPass = field(default_factory=lambda: LowPass(cutoff=5.0, order=4))
    """Of both sides of the equations. Planned motions lie below; what lies above, ripple and the resonances of an
    industrial robot from some 8 Hz on, is not explained by its bodies."""
    moving: float = 0.02
    """Motor speed over gear ratio [rad/s or m/s] below which a row does not count: bristles decide the torque there."""

    def __post_init__(self) -> None:
        check_number("moving", self.moving, unit="rad/s", low=0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Equations:
    """Linear equations for K parameters, R rows for each of N motors."""

    robot: RobotDescription
    terms: tuple[Term, ...]
    columns: Array
    """Shape (R, K, N)."""
    torque: Array
    """What the terms explain: motor torque less that of terms that stay as described, motor side [N m], (R, N)."""
    measured: Array
    """Motor torque, motor side [N m], shape (R, N)."""
    t: Array
    """Time of each row on the clock of its recording [s], shape (R,)."""
    counts: BoolArray
    """Whether a row counts for a motor: it moves, and the filters know what is around, shape (R, N)."""
    blocks: Blocks
    """What is resampled; each recording is a stratum."""

    def residual(self, parameters: Array) -> Array:
        """Measured minus predicted torque [N m], shape (R, N)."""
        return self.torque - np.einsum("rkn,k->rn", self.columns, parameters)


def equations_of(
    robot: RobotDescription,
    recordings: Sequence[Recording],
    terms: Sequence[Term],
    filtering: Filtering | None = None,
    bodies: Array | None = None,
) -> Equations:
    """Equations of all recordings, one below the other; terms that are left out are as described.

    Motor angles are low-passed and differentiated; torque and the columns of all parameters then go through one more
    filter together, which changes no parameter, and every so many rows are kept. Elastic joints bend under `bodies`,
    inertial parameters (10 B,), None is the description's.

    Reference:
        Gautier (1997), IEEE Int. Conf. on Robotics and Automation, 2278-2283 (filtering in parallel).
    """
    if not recordings:
        raise FFGymError("There is nothing to identify from: no recordings.")
    filtering = filtering or Filtering()
    bodies = BODIES.described(robot) if bodies is None else bodies
    parts = [_part(robot, recording, tuple(terms), filtering, bodies) for recording in recordings]
    rows = ("columns", "torque", "measured", "t", "counts")
    joined: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in rows}
    return replace(parts[0], **joined, blocks=Blocks.joined([part.blocks for part in parts]))


def _part(
    robot: RobotDescription, recording: Recording, terms: tuple[Term, ...], filtering: Filtering, bodies: Array
) -> Equations:
    """Equations of one recording."""
    dt, parallel = recording.dt, filtering.parallel
    rigid = rigid_motion(robot, *read_joint_motion(robot, recording, filtering.motion))
    motion = elastic_motion(robot, rigid, bodies, dt)
    stride = max(1, int(1 / (_ROWS_PER_CUTOFF * parallel.cutoff * dt)))
    kept = slice(None, None, stride)
    columns = [_filter(part, parallel, dt)[kept] for term in terms for part in term.columns(robot, motion)]
    measured = torque = read_acting_torque(robot, recording)
    for term in TERMS:
        if term not in terms and np.any(term.described(robot)):
            torque = torque - term.torque(robot, motion, term.described(robot))
    # rows count where motors move and are valid as far as the parallel filter reaches, and ends are far
    reach = 2 * round(1 / (parallel.cutoff * dt)) + 1  # a period of the cut-off, on either side
    good = (np.abs(motion.motor_dq / robot.drive.gear_ratio) > filtering.moving) & recording.valid
    counts = scipy.ndimage.minimum_filter1d(good.astype(np.int8), reach, axis=0) > 0
    for low_pass in (filtering.motion, parallel):
        counts &= low_pass.knows(len(counts), dt)[:, None]
    counts = counts[kept]
    return Equations(
        robot=robot,
        terms=terms,
        columns=np.concatenate(columns, axis=1),
        torque=parallel(torque, dt)[kept],
        measured=parallel(measured, dt)[kept],
        t=recording.t[kept],
        counts=counts,
        blocks=Blocks.cut([np.ones(len(counts), dtype=np.bool_)], dt * stride, _BLOCK),
    )


def _filter(columns: Array, low_pass: LowPass, dt: float) -> Array:
    """Columns (T, K, N) through a filter; those that are 0 throughout stay so at no cost."""
    filtered = np.zeros_like(columns)
    used = np.any(columns, axis=0)
    filtered[:, used] = low_pass(columns[:, used], dt)
    return filtered


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
    described = read_description(equations.robot, equations.terms)
    left = {"described": described, "identified": estimate, "in_file": in_file}
    errors = {name: rms_counting(equations.residual(values), equations.counts) for name, values in left.items()}
    return TorqueErrors(measured=rms_counting(equations.measured, equations.counts), **errors)


def rms_counting(values: Array, counts: BoolArray) -> Array:
    """Root mean square over the rows that count for each motor, (N,); NaN where none does."""
    with np.errstate(invalid="ignore"):
        return np.sqrt((np.where(counts, values, 0.0) ** 2).sum(axis=0) / counts.sum(axis=0))
