"""Noise floor of residuals without any fault: the nominal model, replayed over its own simulation with the log's noise.

Nothing of the residual that is diagnosed enters: noise is what the sensors show above the band in which machines move,
and what replay and simulation differ by is seen where both are of the same model.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.colour import Colour, colour_of
from ffgym.diagnosis.log import Log, log_of
from ffgym.diagnosis.measured import measured_rows, residual_rows, valid_rows
from ffgym.diagnosis.replay import Replay, predicted, replay, servo_feedback, tracked
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.sampling import white_noise
from ffgym.recordings import Recording

_ROUNDING = 1e-12
"""Relative differences of angles that are those of floating point."""

_MULTIPLE, _MOST = 0.02, 0.99
"""How near a change must be to a multiple of the smallest one, and how many must, for that to be the encoder's step."""

_QUIETEST, _QUIETEST_SERVO = 0.3, 1.0
"""Share of its RMS in all motions that the noise of a component has in each of them at least. An encoder that stands
shows none, until it stands at the edge of a step; and the servo, which acts on what it reads, is wrong by as much all
the time."""

_FORETOLD = 2e-3
"""What is added to the noise of torques, as a share of the RMS of their changes: no model foretells torque better than
to some per mille, however quiet the sensors; chosen."""

_TORQUES: tuple[Channel, ...] = ("torque", "servo")

DRAWS = 2
"""Draws of the noise; an RMS over thousands of rows is known to some per cent from two."""


_LEAST_TORQUE = 1e-3
"""Least noise of a torque as a share of its RMS: no model foretells torque better than to a per mille; chosen."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Noise:
    """White noise of each signal, standard deviations, shape (M, N), or (M, 3) for the tool; torques may have more."""

    angle: Array
    """Of `motor.position`, motor side [rad]."""
    step: Array
    """Of the encoder, motor side [rad]; 0 if it has none."""
    torque: Array
    """Of the acting motor torque, motor side [N m]."""
    tool: Array | None
    link: Array | None
    feedback: Array | None
    colours: Mapping[str, Colour] = field(default_factory=dict)
    """By family of columns; the noise of others is white."""


def noise_of(run: Replay) -> Noise:
    """White noise of a log's signals, from what is above the band of motions.

    Of samples some milliseconds apart, reversals and stops are in that band, too. They are in the signal and not in
    what a model leaves of it, which has them only where the model is wrong; noise is no louder than either.
    """
    log, left = run.read, _left(run)
    low_pass = log.sampling.motion_filter
    raw = [_angles(log, recording) for recording in log.recordings]

    def each(values: Array) -> Array:
        return np.stack([white_noise(values[:n, i], low_pass, log.dt) for i, n in enumerate(log.lengths)])

    def least(values: Array, family: str) -> Array:
        return np.minimum(each(values), each(left[family])) if family in left else each(values)

    return Noise(
        angle=np.stack([white_noise(angle, low_pass, log.dt) for angle in raw]),
        step=encoder_steps(log),
        torque=least(log.torque, "motor.effort"),
        tool=None if log.tool is None else least(log.tool, "tcp.position"),
        link=None if log.link is None else each(log.link),
        feedback=None if log.feedback is None else least(log.feedback, "feedback.effort"),
    )


def _with_colours(noise: Noise, log: Log, like: Replay, own: Replay) -> Noise:
    """Noise with what torques and trackers have beside white noise."""
    left, white = _left(like), _left(own)
    measured = {"motor.effort": log.torque, "feedback.effort": log.feedback, "tcp.position": log.tool}
    cutoff, low_pass, n = log.sampling.cutoff, log.sampling.motion_filter, range(len(log.recordings))

    def of(values: Array | None) -> list[Array]:
        return [] if values is None else [values[log.known[:, i], i] for i in n]

    names = {"motor.effort": "torque", "feedback.effort": "feedback", "tcp.position": "tool"}
    above = {family: getattr(noise, name) for family, name in names.items()}  # white, if it were
    colours = {}
    for family, rest in left.items():
        rows = of(measured[family]), of(rest), of(white[family])
        if all(np.isfinite(values).all() for values in rows[0]):
            level = np.median(above[family], axis=0)
            colours[family] = colour_of(*rows, cutoff, low_pass, log.dt, level=level, alike=family == "tcp.position")
    colours = {family: colour for family, colour in colours.items() if not colour.is_white}
    less: dict[str, Any] = {names[family]: colour.beside(above[family]) for family, colour in colours.items()}
    return replace(noise, colours=colours, **less)


def _left(run: Replay) -> dict[str, Array]:
    """Residual of torques and of the tracker's positions at all samples, by family of columns."""
    read = run.read
    left = {"motor.effort": read.torque - run.torque}
    if read.feedback is not None and read.shows_servo:
        left["feedback.effort"] = read.feedback - servo_feedback(read, run.robot)
    if read.tool is not None:
        left["tcp.position"] = read.tool - tracked(run)
    return left


def encoder_steps(log: Log) -> Array:
    """Steps of the encoders in each motion, shape (M, N), motor side [rad]; 0 where there are none."""
    return np.stack([_steps(_angles(log, recording), recording) for recording in log.recordings])


def _angles(log: Log, recording: Recording) -> Array:
    angle = recording.joint_array("motor.position")
    return log.robot.drive.motor_angle(angle) if recording.header.position_side == "link" else angle


def _steps(angle: Array, recording: Recording) -> Array:
    """Steps of the encoders: as the header says, else the smallest change if all changes are multiples of it."""
    if recording.header.encoder_bits is not None:
        return np.full(angle.shape[1], 2 * np.pi / 2**recording.header.encoder_bits)
    return np.array([_step(angle[:, j]) for j in range(angle.shape[1])])


def _step(angle: Array) -> float:
    changes = np.abs(np.diff(angle))
    changes = changes[changes > _ROUNDING * max(1.0, float(np.abs(angle).max()))]
    if not len(changes):
        return 0.0
    step = float(changes.min())
    multiples = changes / step
    return step if np.mean(np.abs(multiples - np.round(multiples)) < _MULTIPLE) > _MOST else 0.0


def noisy(exact: Recording, noise: Noise, i: int, rng: np.random.Generator) -> Recording:
    """An exact recording as the sensors of the i-th motion of a log would have it.

    Angles are rounded to the steps of the encoder, which is no white noise where a motor stands.
    """
    header, joints = exact.header, exact.header.joints
    columns = {}
    for j, joint in enumerate(joints):
        name = f"motor.position.{joint}"
        columns[name] = _read(exact[name], float(noise.angle[i, j]), float(noise.step[i, j]), rng)
        for family, size in (("motor.effort", noise.torque), ("feedback.effort", noise.feedback)):
            if size is not None and exact.has(family):
                drawn = rng.normal(scale=size[i, j], size=len(exact))
                if family in noise.colours:
                    drawn = drawn + noise.colours[family].drawn(j, len(exact), rng)
                columns[f"{family}.{joint}"] = exact[f"{family}.{joint}"] + drawn
        if noise.link is not None:
            name = f"link.position.{joint}"
            columns[name] = exact[name] + rng.normal(scale=noise.link[i, j], size=len(exact))
    if noise.tool is not None:
        for k, axis in enumerate("xyz"):
            name = f"tcp.position.{axis}"
            columns[name] = exact[name] + rng.normal(scale=noise.tool[i, k], size=len(exact))
            if "tcp.position" in noise.colours:
                columns[name] = columns[name] + noise.colours["tcp.position"].drawn(k, len(exact), rng)
    return Recording(columns=dict(exact.columns) | columns, header=header)


def _read(angle: Array, white: float, step: float, rng: np.random.Generator) -> Array:
    """An angle as an encoder with steps reads it; white noise that is more than that of rounding comes before."""
    more = np.sqrt(max(white**2 - step**2 / 12, 0.0))
    seen = angle + rng.normal(scale=more, size=len(angle)) if more > 0 else angle
    return np.round(seen / step) * step if step > 0 else seen


@dataclass(frozen=True, kw_only=True, eq=False)
class Faultless:
    """Residuals of a model without fault, with this log's noise."""

    draws: Mapping[Channel, Array]
    """(R, M, C, D) for D draws."""
    least: Mapping[Channel, Array] = field(default_factory=dict)
    """RMS that any model leaves beside noise, (C,) each; what is not there is 0."""

    def floor(self, log: Log) -> dict[Channel, Array]:
        """RMS by channel, shape (M, C); in no motion much less than in all."""
        valid = valid_rows(log)
        found = {}
        for channel, draws in self.draws.items():
            count = np.maximum(valid.sum(axis=0), 1)[:, None]
            energy = np.einsum("rmcd,rm->mc", draws**2, valid.astype(np.float64)) / (count * draws.shape[3])
            overall = np.sqrt(np.average(energy, axis=0, weights=count[:, 0]))
            least = _QUIETEST_SERVO if channel == "servo" else _QUIETEST
            found[channel] = np.hypot(np.maximum(np.sqrt(energy), least * overall), self.least.get(channel, 0.0))
        return found

    def sensor_share(self, component: tuple[Channel, int], floor: Mapping[Channel, Array]) -> float:
        """Return the share of a floor's energy (M, C) that sensors leave; the rest allows for inexact models."""
        channel, c = component
        if channel not in self.least:
            return 1.0
        return float(1 - self.least[channel][c] ** 2 / np.mean(np.square(floor[channel][:, c])))


def faultless_residuals(
    log: Log, own: Replay, bias: Mapping[Channel, Array], like: Replay, rng: np.random.Generator
) -> Faultless:
    """Residuals of the nominal model over its own recordings, with the noise of a log; `bias` is taken off."""
    noise = noise_of(like)

    def drawn() -> Replay:
        seen = [noisy(recording, noise, i, rng) for i, recording in enumerate(own.read.recordings)]
        return replay(log_of(log.robot, seen, like=log), like.machine, nearby=own)

    runs = [drawn()]
    noise = _with_colours(noise, log, like, runs[0])
    if noise.colours:
        runs.clear()
    runs += [drawn() for _ in range(DRAWS - len(runs))]
    draws: dict[Channel, list[Array]] = {}
    for run in runs:
        for channel, rows in residual_rows(run.read, predicted(run)).items():
            draws.setdefault(channel, []).append(rows - bias[channel])
    return Faultless(
        draws={channel: np.stack(each, axis=-1) for channel, each in draws.items()},
        least={
            channel: _FORETOLD * _rms(measured_rows(log)[channel], valid_rows(log))
            for channel in draws
            if channel in _TORQUES
        },
    )


def _rms(rows: Array, valid: BoolArray) -> Array:
    """RMS of each component (C,) of rows (R, M, C) that are valid (R, M), about its mean in a motion: weights stay."""
    weight = valid.astype(np.float64)
    about = rows - np.einsum("rmc,rm->mc", rows, weight) / np.maximum(weight.sum(axis=0), 1.0)[:, None]
    rms: Array = np.sqrt(np.einsum("rmc,rm->c", about**2, weight) / max(weight.sum(), 1.0))
    return rms


def torque_noise(run: Replay) -> Array:
    r"""RMS that white noise of torque and angle gives the residual, shape (M, N), motor side [N m].

    Through a low-pass of cut-off :math:`f_c`, white noise :math:`\sigma` of samples :math:`\Delta t` apart keeps
    :math:`\sigma \sqrt{2 f_c \Delta t}`, and its second derivative :math:`(2\pi)^2 \sigma \sqrt{2 f_c^5 \Delta t / 5}`.
    """
    noise, fc, dt = noise_of(run), run.log.sampling.cutoff, run.log.dt
    torque = noise.torque * np.sqrt(2 * fc * dt)
    acceleration = (2 * np.pi) ** 2 * noise.angle * np.sqrt(2 * fc**5 * dt / 5)
    floor = _LEAST_TORQUE * rms(run.torque, 0)
    known: Array = np.hypot(torque, run.robot.drive.rotor_inertia * acceleration)
    return np.maximum(known, np.maximum(floor, np.finfo(np.float64).tiny))
