"""Log: recordings made ready for a diagnosis, motions side by side with what was measured along them."""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.log_columns import pad, read_feedback, read_set_points, read_temperatures, read_tool
from ffgym.diagnosis.sampling import Sampling, estimate_noise_above_band, without_trembling
from ffgym.diagnosis.settings import settings
from ffgym.logs.preparation import (
    LowPass,
    check_fits,
    differentiate,
    read_acting_torque,
    read_joint_position,
    read_joint_side,
)
from ffgym.recordings import Recording
from ffgym.recordings.stretch import read_session_start
from ffgym.robot import RobotDescription


def sort_by_content(recordings: Sequence[Recording]) -> tuple[Recording, ...]:
    """Recordings by the names of their motions, then by their numbers."""

    def digest(recording: Recording) -> bytes:
        found = hashlib.sha256()
        for name in sorted(recording.columns):
            found.update(name.encode() + b"\0" + np.ascontiguousarray(recording[name]).tobytes())
        return found.digest()

    return tuple(sorted(recordings, key=lambda recording: (recording.header.segment, digest(recording))))


@dataclass(frozen=True, kw_only=True, eq=False)
class Log:
    """M motions of one robot, each padded at its end to the T samples of the longest; N joints.

    Angles are behind the gearbox if joints were rigid, link side; torques are motor side.
    """

    robot: RobotDescription
    recordings: tuple[Recording, ...]
    sampling: Sampling
    started: Array
    """When each motion began on the clock of its session [s], shape (M,); 0 if the log does not say."""
    known: BoolArray
    """Samples that are of the record and that the filter knows, shape (T, M)."""
    q: Array
    """[rad], shape (T, M, N)."""
    dq: Array
    """[rad/s]."""
    ddq: Array
    """[rad/s^2]."""
    trembling: Array
    """Half the band in which the reading of a motor that stands moves, shape (N,), link side [rad]."""
    slip_dq: Array
    """Speed that moves the bristles of friction: `dq` where a motor moves, 0 where only its reading does [rad/s]."""
    torque: Array
    """Motor torque that acts about each sample [N m], shape (T, M, N)."""
    tool: Array | None
    """Tracked position [m], shape (T, M, 3); NaN where it is not known."""
    link: Array | None
    """Encoders behind the gearbox, link side [rad], shape (T, M, N)."""
    feedback: Array | None
    """Torque that the servo adds to its feed-forward [N m], shape (T, M, N)."""
    reference: tuple[Array, Array] | None
    """Set-points of the motors [rad], and their rate, shape (T, M, N) each."""
    temperature: Array | None
    """[degC], shape (T, M, N)."""

    @property
    def reading_noise(self) -> Array:
        """White noise of the motors' readings that has such a band, standard deviation (N,), link side [rad]."""
        return self.trembling / (
            settings().sampling.trembling * _pass_white_noise(self.sampling.motion_filter, self.dt)
        )

    @property
    def dt(self) -> float:
        """Sample period [s]."""
        return self.sampling.dt

    @property
    def t(self) -> Array:
        """Time since each motion began [s], shape (T,)."""
        return np.arange(len(self.q), dtype=np.float64) * self.dt

    @property
    def lengths(self) -> tuple[int, ...]:
        """Samples of each motion."""
        return tuple(len(recording) for recording in self.recordings)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the motions."""
        return tuple(recording.header.segment for recording in self.recordings)

    @property
    def shows_servo(self) -> bool:
        """True if the servo's torque can be compared: it and its set-points were recorded."""
        return self.feedback is not None and self.reference is not None

    @property
    def torque_alone(self) -> "Log":
        """The log without the channels that show more than torque."""
        return replace(self, tool=None, link=None, feedback=None, reference=None)

    def motion(self, i: int) -> "Log":
        """The log of one of its motions alone, padded as before."""
        one = slice(i, i + 1)
        columns = ("known", "q", "dq", "ddq", "slip_dq", "torque", "tool", "link", "feedback", "temperature")
        taken: dict[str, Any] = {
            name: None if (values := getattr(self, name)) is None else values[:, one] for name in columns
        }
        if self.reference is not None:
            taken["reference"] = (self.reference[0][:, one], self.reference[1][:, one])
        return replace(self, recordings=self.recordings[one], started=self.started[one], **taken)


def assemble_log(
    robot: RobotDescription, recordings: Sequence[Recording], like: Log | None = None, cutoff: float | None = None
) -> Log:
    """Assemble recordings of a robot to a log; with the rows and channels of another log of the same motions, if given.

    Args:
        robot: that was recorded.
        recordings: of motions with different names.
        like: another log of the same motions.
        cutoff: of what is compared [Hz]; None is the usual one, or that of `like`.

    Raises:
        FFGymError: if there are none, two motions share a name, they are sampled at different rates or unevenly, one of
            them does not fit the robot or does not say what its torque is and when it acts.
    """
    _check(robot, recordings)
    sampling = Sampling.of(recordings[0].dt, [len(recording) for recording in recordings], cutoff)
    if like is not None:
        recordings, sampling = [r.slice(end=float(r.t[0]) + like.sampling.span) for r in recordings], like.sampling
    low_pass, ends = sampling.motion_filter, sampling.motion_filter.end_rows(sampling.dt)
    # samples of each record that the filter of the motion knows and that count for any joint
    known = np.zeros((sampling.n_samples, len(recordings)), dtype=np.bool_)
    for i, recording in enumerate(recordings):
        known[ends : max(ends, len(recording) - ends), i] = True
        known[: len(recording), i] &= recording.valid.any(axis=1)
    # positions and rates of one low-pass, so that all that is compared has one band
    positions = [read_joint_position(robot, recording, low_pass) for recording in recordings]
    rates = [differentiate(q, recording.dt) for q, recording in zip(positions, recordings, strict=True)]

    def beside(of: Sequence[Array], hold: bool = True) -> Array:
        return pad(of, sampling.n_samples, hold)

    def where_all(family: str, read: Callable[[Recording], Array]) -> Array | None:
        return beside([read(r) for r in recordings]) if all(r.has(family) for r in recordings) else None

    q = beside(positions)
    # that of another log, if given, so that what the band does to reversals is the same in both
    trembling = _trembling(robot, recordings, low_pass) if like is None else like.trembling
    found = Log(
        robot=robot,
        recordings=tuple(recordings),
        sampling=sampling,
        started=np.array([read_session_start(recording.header) for recording in recordings]),
        known=known,
        q=q,
        dq=beside([dq for dq, _ in rates], hold=False),
        ddq=beside([ddq for _, ddq in rates], hold=False),
        trembling=trembling,
        slip_dq=np.gradient(without_trembling(q, trembling), sampling.dt, axis=0),
        torque=beside([read_acting_torque(robot, recording) for recording in recordings]),
        tool=where_all("tcp.position", read_tool) if robot.tool is not None else None,
        link=where_all("link.position", lambda r: r.joint_array("link.position")),
        feedback=read_feedback(robot, recordings, sampling.n_samples),
        reference=read_set_points(robot, recordings, sampling.n_samples),
        temperature=where_all("temperature", read_temperatures),
    )
    # leave out channels that the other log lacks
    if like is None:
        return found
    missing: dict[str, Any] = {
        name: None for name in ("tool", "link", "feedback", "reference") if getattr(like, name) is None
    }
    return replace(found, temperature=like.temperature, started=like.started, **missing)


def _trembling(robot: RobotDescription, recordings: Sequence[Recording], low_pass: LowPass) -> Array:
    """Half the band (N,) in which the filtered reading of a motor that stands moves, behind the gearbox [rad].

    A resolver has one noise: that in the middle of all motions, of which some shake in the band of the noise.
    """
    limits = settings().sampling
    noise = []
    for recording in recordings:
        angle = read_joint_side(robot, recording)
        noise.append(
            _pass_white_noise(low_pass, recording.dt) * estimate_noise_above_band(angle, low_pass, recording.dt)
        )
    width = limits.trembling * np.median(noise, axis=0)
    steps = np.round(limits.trembling_per_octave * np.log2(np.maximum(width, np.finfo(np.float64).tiny)))
    rounded: Array = np.where(width > 0, 2.0 ** (steps / limits.trembling_per_octave), 0.0)
    return rounded


def _pass_white_noise(low_pass: LowPass, dt: float) -> float:
    """Share of white noise that a low-pass lets through."""
    return float(np.sqrt(min(1.0, 2 * low_pass.cutoff * dt)))


def _check(robot: RobotDescription, recordings: Sequence[Recording]) -> None:
    if not recordings:
        raise FFGymError("There is nothing to diagnose: name recordings, or a folder of them.")
    for recording in recordings:
        check_fits(robot, recording)
    names = [recording.header.segment for recording in recordings]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise FFGymError(f"Several recordings are of a motion named {twice[0]!r}; names of motions must differ.")
    periods = [recording.dt for recording in recordings]
    if np.ptp(periods) > settings().sampling.same_period * max(periods):
        raise FFGymError(
            f"Recordings are sampled every {min(periods):g} to {max(periods):g} s; diagnose those of one sample period."
        )
