r"""Terms of a servo's equation along recordings of set-points, motor angles and motor torque.

.. math:: \tau = K_p e + K_v \dot e + K_i \int e \, dt + k \, u_{ff} + c, \qquad e = F s - \theta

per axis, motor side, with set-points s behind delay and filter F of the controller (`SetpointResponse`), its rigid
feed-forward u_ff and a constant c of each recording, which has what the integral began with. All terms go through one
low-pass that delays nothing, which leaves the equation as it is. Friction, springs and loads act on the robot: they
move the motor, and are not in this equation.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from ffgym.control import SetpointResponse
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.setpoint_model import MOVES
from ffgym.diagnosis.resampling import Blocks
from ffgym.logs.preparation import LowPass, check_fits, differentiate, read_acting_torque, read_motor_side
from ffgym.logs.quality.signals import is_even
from ffgym.recordings import Recording
from ffgym.robot import RigidArm

TERMS = 4
"""Terms of the equation beside the constant: error, its rate, its integral, rigid feed-forward."""
_HIGHEST = 0.3
"""Largest cut-off frequency of the low-pass, in sample rates (chosen)."""
_BLOCK = 0.25
"""Length of a block of time [s]; chosen: some periods of the servo."""
_AT_PEAK = 0.99
"""Share of the peak torque beyond which a drive counts as at its limit."""


def why_no_torque(recordings: Sequence[Recording]) -> str:
    """Say why the torque of a servo is not known in recordings; '' where it is."""
    for recording in recordings:
        header = recording.header
        if not recording.has("motor.effort"):
            return f"recording {header.segment!r} has no motor torque (motor.effort)"
        for name in ("torque_semantics", "hold"):
            if getattr(header, name) == "unspecified":
                return f"recording {header.segment!r} does not say what its torque is: {name} of its header"
        if not is_even(recording.t):
            return f"recording {header.segment!r} is sampled unevenly"
    return ""


@dataclass(frozen=True, kw_only=True, eq=False)
class ServoLog:
    """Set-points, motor angles and torque of one recording, rows `dt` [s] apart, motor side, (T, N) each."""

    arm: RigidArm
    """Rigid dynamics that the controller knows."""
    dt: float
    sent: Array
    """Set-points as they were sent [rad]."""
    measured: Array
    """Motor angles [rad]."""
    torque: Array
    """Motor torque [N m], less feed-forward that was recorded."""
    feedforward: bool
    """True if the controller computes its rigid feed-forward from set-points, and it was not recorded."""
    counts: BoolArray
    """Rows that count for each joint: not masked, torque within its limits, far from the ends."""
    angle: Array | None = None
    """Motor angles that stand for the measured ones, without their noise [rad]; None for the measured ones."""

    @classmethod
    def of(cls, recording: Recording, arm: RigidArm, *, feedforward: bool) -> "ServoLog":
        """Read a recording.

        Raises:
            FFGymError: if robot and recording do not fit, or its torque is not known.
        """
        check_fits(arm.robot, recording)
        robot, dt = arm.robot, recording.dt
        torque = read_acting_torque(robot, recording)
        within = recording.valid & (np.abs(torque) < _AT_PEAK * robot.drive.peak_torque)
        known = [name for name in ("feedforward.effort", "compensation.effort") if recording.has(name)]
        for name in known:
            torque = torque - read_acting_torque(robot, recording, name)
        low_pass = _low_pass(dt)
        far = scipy.ndimage.minimum_filter1d(within.astype(np.int8), 2 * low_pass.end_rows(dt) + 1, axis=0) > 0
        return cls(
            arm=arm,
            dt=dt,
            sent=read_motor_side(robot, recording, "reference.position"),
            measured=read_motor_side(robot, recording),
            torque=torque,
            feedforward=feedforward and "feedforward.effort" not in known,
            counts=far & low_pass.knows(len(torque), dt)[:, None],
        )

    @property
    def moves(self) -> BoolArray:
        """True for joints whose set-points move, shape (N,)."""
        return np.asarray(np.ptp(self.sent, axis=0) > MOVES)

    @cached_property
    def filtered_torque(self) -> Array:
        """Torque through the low-pass [N m], shape (T, N)."""
        return _low_pass(self.dt)(self.torque, self.dt)

    def terms(self, response: SetpointResponse) -> Array:
        """Compute the terms of the equation for a response of the controller, shape (T, N, 4)."""
        low_pass, dt = _low_pass(self.dt), self.dt
        reference = response.apply(self.sent, dt)
        error = low_pass(reference - (self.measured if self.angle is None else self.angle), dt)
        integral = np.cumsum(error, axis=0) * dt - 0.5 * dt * error  # trapezoids, but for a constant
        rigid = self._rigid_torque(low_pass(reference, dt)) if self.feedforward else np.zeros_like(error)
        return np.stack([error, differentiate(error, dt)[0], integral, rigid], axis=-1)

    def _rigid_torque(self, reference: Array) -> Array:
        """Compute the rigid feed-forward along a reference, motor side [N m], shape (T, N)."""
        drive = self.arm.robot.drive
        speed, change = differentiate(reference, self.dt)
        links = self.arm.inverse_dynamics(*(drive.joint_angle(part) for part in (reference, speed, change)))
        return drive.motor_torque(links) + drive.rotor_inertia * change


def _low_pass(dt: float) -> LowPass:
    """Return the low-pass of all terms for rows `dt` [s] apart."""
    return LowPass(cutoff=min(LowPass().cutoff, _HIGHEST / dt))


@dataclass(frozen=True, kw_only=True, eq=False)
class ServoRows:
    """Rows of the equation of one axis, from all recordings, each less its mean in its recording."""

    terms: Array
    """Terms from measured angles, shape (R, 4)."""
    instruments: Array
    """The same from angles without noise, or those themselves, shape (R, 4)."""
    torque: Array
    """[N m], shape (R,)."""
    blocks: Blocks

    @classmethod
    def of(
        cls, logs: Sequence[ServoLog], terms: Sequence[Array], instruments: Sequence[Array], joint: int
    ) -> "ServoRows":
        """Cut the rows that count out of terms of recordings (T, N, 4)."""
        found: list[tuple[Array, Array, Array]] = []
        for log, own, free in zip(logs, terms, instruments, strict=True):
            rows = log.counts[:, joint]
            torque = log.filtered_torque[rows, joint]
            found.append((_less_mean(own[rows, joint]), _less_mean(free[rows, joint]), _less_mean(torque)))
        cuts = [
            Blocks.cut([np.ones(len(part[2]), dtype=np.bool_)], log.dt, _BLOCK)
            for log, part in zip(logs, found, strict=True)
        ]
        measured, other, torque = (np.concatenate(part) for part in zip(*found, strict=True))
        return cls(terms=measured, instruments=other, torque=torque, blocks=Blocks.joined(cuts))

    @cached_property
    def products(self) -> tuple[Array, Array]:
        """Sums over blocks: instruments times terms (B, 4, 4), and times the torque (B, 4)."""
        matrix = self.blocks.sums(self.instruments[:, :, None] * self.terms[:, None, :])
        return matrix, self.blocks.sums(self.instruments * self.torque[:, None])

    def solve(self, weights: Array, held: Array) -> Array:
        """Solve the equation for its coefficients, shape (4,).

        Args:
            weights: how often each block counts, shape (B,).
            held: coefficients that are known, NaN for those to find, shape (4,).
        """
        free = np.flatnonzero(np.isnan(held))
        matrix, vector = (np.tensordot(weights, part, axes=1) for part in self.products)
        found = np.where(np.isnan(held), 0.0, held)
        found[free] = np.linalg.lstsq(matrix[np.ix_(free, free)], (vector - matrix @ found)[free], rcond=None)[0]
        return found


def _less_mean(rows: Array) -> Array:
    """Take the mean from rows of a recording, as the constant of the equation."""
    return rows - rows.mean(axis=0)


def with_angles(logs: Sequence[ServoLog], angles: Sequence[Array]) -> list[ServoLog]:
    """Return recordings with other motor angles (T, N) each in place of the measured ones [rad]."""
    return [replace(log, angle=angle) for log, angle in zip(logs, angles, strict=True)]
