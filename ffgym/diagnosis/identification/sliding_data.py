"""Records side by side: the speed and friction of one joint, from which bristles are simulated again and again."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ffgym.control import DynamicLuGreExact
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.friction_data import FrictionTorque
from ffgym.diagnosis.identification.resampling import Blocks, runs
from ffgym.diagnosis.identification.signals import LowPass
from ffgym.robot.friction import LuGreParameters

_SAMPLES_PER_CUTOFF = 6.0
"""Samples in a period of the filter's cut-off that are kept: what the filter has left has no more in it."""

AT_REST = 0.05
"""Motor speed below which a joint rests [rad/s]: some times what an encoder of 16 bit shows at rest."""

_REST = 0.1
"""Time from which a joint that does not move rests [s]; reversals are shorter."""

_SAME_DT = 1e-3
"""Relative difference of sample periods that does not count: a thousandth of a row for each row."""

FORGOTTEN = 10.0
"""Way after which bristles have forgotten how they began, in presliding lengths f_s / sigma_0."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SlidingData:
    """Motion and friction of one joint in R records side by side, T rows; short ones go on with their last row."""

    segments: tuple[str, ...]
    """Names of the records, shape (R,)."""
    dt: float
    """Sample period [s]."""
    speed: Array
    """Motor speed [rad/s], shape (T, R)."""
    friction: Array
    """Friction torque, motor side [N m], shape (T, R)."""
    inertia: Array
    """Torque of rotors and links, motor side [N m], shape (T, R)."""
    scored: BoolArray
    """Rows that count: the filter knows them, and bristles have forgotten how they began, shape (T, R)."""
    low_pass: LowPass
    """What speed and friction went through, and a model's friction goes through too."""

    def model_friction(self, friction: Sequence[LuGreParameters]) -> Array:
        """Friction of P LuGre models along the speeds, filtered as the measured one, shape (P, T, R), thesis (6.16)."""
        n_models, (n_rows, n_records) = len(friction), self.speed.shape
        law = DynamicLuGreExact(_repeated(friction, n_records), n_substeps=1)
        torque = law.along(np.tile(self.speed, (1, n_models)), self.dt)
        filtered = self.low_pass(torque, self.dt).reshape(n_rows, n_models, n_records)
        return filtered.transpose(1, 0, 2)

    def blocks(self, duration: float) -> Blocks:
        """Blocks of the scored rows of `flat`, drawn within their record."""
        parts = [Blocks.cut([rows], self.dt, duration) for rows in self.scored.T if rows.any()]
        joined = Blocks.joined(parts)
        return Blocks(of_row=joined.of_row[joined.of_row >= 0], stratum=joined.stratum)

    def flat(self, values: Array) -> Array:
        """Scored rows of `values` (..., T, R), one record after the other, shape (..., S)."""
        return np.concatenate([values[..., rows, r] for r, rows in enumerate(self.scored.T)], axis=-1)


def sliding_data(torques: Sequence[FrictionTorque], joint: int, presliding: float) -> SlidingData:
    """Put records side by side for one joint.

    Args:
        torques: friction along recordings; sample periods may differ by whole factors.
        joint: which joint, 0 is the first.
        presliding: how far bristles bend, f_s / sigma_0 [rad], motor side.
    """
    if not torques:
        raise FFGymError(f"There is no record in which joint {joint + 1} reverses; its bristles cannot be identified.")
    low_pass, dt = torques[0].signals.low_pass, max(torque.signals.dt for torque in torques)
    dt *= max(1, int(1 / (_SAMPLES_PER_CUTOFF * low_pass.cutoff * dt)))
    every = [_thinning(torque, dt, low_pass) for torque in torques]
    length = max(-(-len(torque.signals.t) // step) for torque, step in zip(torques, every, strict=True))

    def side_by_side(columns: list[Array]) -> Array:
        thinned = [column[::step] for column, step in zip(columns, every, strict=True)]
        return np.stack([np.pad(x, (0, length - len(x)), mode="edge") for x in thinned], axis=1)

    speed = side_by_side([torque.signals.motor_dq[:, joint] for torque in torques])
    scored = np.zeros(speed.shape, dtype=np.bool_)
    for r, (torque, step) in enumerate(zip(torques, every, strict=True)):
        rows = torque.counts(joint)[::step]
        scored[: len(rows), r] = rows
    for r in range(len(torques)):
        scored[:, r] &= _known(speed[:, r], dt, FORGOTTEN * presliding)
    return SlidingData(
        segments=tuple(torque.signals.segment for torque in torques),
        dt=dt,
        speed=speed,
        friction=side_by_side([torque.friction[:, joint] for torque in torques]),
        inertia=side_by_side([torque.inertia[:, joint] for torque in torques]),
        scored=scored,
        low_pass=low_pass,
    )


def _known(speed: Array, dt: float, way: float) -> BoolArray:
    """Rows in which a joint moves and has gone `way` [rad] since it rested, shape (T,).

    At rest the noise of the speed alone makes the bristles of a model creep, so that they are not known there, nor
    until they have slipped.
    """
    around = scipy.ndimage.maximum_filter1d(np.abs(speed), max(1, round(_REST / dt)))
    known = np.zeros(len(speed), dtype=np.bool_)
    for start, stop in runs(around > AT_REST):
        known[start:stop] = np.cumsum(np.abs(speed[start:stop])) * dt > way
    return known


def _thinning(torque: FrictionTorque, dt: float, low_pass: LowPass) -> int:
    """Which rows of a record are `dt` [s] apart."""
    step = round(dt / torque.signals.dt)
    if abs(step * torque.signals.dt - dt) > _SAME_DT * dt or torque.signals.low_pass != low_pass:
        raise FFGymError(
            f"Recording {torque.signals.segment!r} is sampled every {torque.signals.dt:g} s, which does not divide the "
            f"{dt:g} s of others, or is filtered otherwise; records that are used together must fit one another."
        )
    return step


def _repeated(friction: Sequence[LuGreParameters], n_records: int) -> LuGreParameters:
    """Models one after the other, each as often as there are records."""
    names = ("coulomb", "static", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping")
    return LuGreParameters(
        **{name: np.repeat([float(getattr(model, name)[0]) for model in friction], n_records) for name in names}
    )
