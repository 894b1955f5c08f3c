"""Noise floor of residuals without any fault: the nominal model, replayed over its own simulation with the log's noise.

Nothing of the residual that is diagnosed enters: noise is what the sensors show above the band in which machines move,
and what replay and simulation differ by is seen where both are of the same model.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.log import Log, assemble_log
from ffgym.diagnosis.noise_spectrum import NoiseSpectrum, estimate_noise_spectrum
from ffgym.diagnosis.replay import Replay, predict, predict_feedback, predict_tracker, replay
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.residual_rows import compute_residuals, filter_measured, find_valid_rows
from ffgym.diagnosis.sampling import estimate_noise_above_band
from ffgym.diagnosis.settings import settings
from ffgym.logs.preparation import read_motor_side
from ffgym.recordings import Recording

_ROUNDING = 1e-12
"""Relative differences of angles that are those of floating point."""

_MULTIPLE, _MOST = 0.02, 0.99
"""Largest distance of a change from a multiple of the smallest one, and least share of such changes, for an encoder's
step."""

_QUIETEST, _QUIETEST_SERVO = 0.3, 1.0
"""Share of its RMS in all motions that the noise of a component has in each of them at least. An encoder that stands
shows none, until it stands at the edge of a step; and the servo, which acts on what it reads, is wrong by as much all
the time."""

_TORQUES: frozenset[Channel] = frozenset({"torque", "servo"})


@dataclass(frozen=True, kw_only=True, eq=False)
class Noise:
    """White noise of each signal, standard deviations, shape (M, N), or (M, 3) for the tool; torques may have more."""

    angle: Array
    """Noise of `motor.position`, motor side [rad]."""
    step: Array
    """Step of the encoder, motor side [rad]; 0 if it has none."""
    torque: Array
    """Noise of the acting motor torque, motor side [N m]."""
    tool: Array | None
    link: Array | None
    feedback: Array | None
    colours: Mapping[str, NoiseSpectrum] = field(default_factory=dict)
    """Spectra by family of columns; the noise of others is white."""


def estimate_noise(run: Replay) -> Noise:
    """Estimate white noise of a log's signals from what is above the band of motions.

    Of samples some milliseconds apart, reversals and stops are in that band, too. They are in the signal and not in
    what a model leaves of it, which has them only where the model is wrong; noise is no louder than either.
    """
    log, left = run.read, _subtract_model(run)
    low_pass = log.sampling.motion_filter

    def each(values: Array) -> Array:
        return np.stack([estimate_noise_above_band(values[:n, i], low_pass, log.dt) for i, n in enumerate(log.lengths)])

    def least(values: Array | None, family: str) -> Array | None:
        if values is None:
            return None
        return np.minimum(each(values), each(left[family])) if family in left else each(values)

    return Noise(
        angle=np.stack(
            [estimate_noise_above_band(read_motor_side(log.robot, one), low_pass, log.dt) for one in log.recordings]
        ),
        step=find_encoder_steps(log),
        torque=np.minimum(each(log.torque), each(left["motor.effort"])),
        tool=least(log.tool, "tcp.position"),
        link=least(log.link, "link.position"),
        feedback=least(log.feedback, "feedback.effort"),
    )


def _add_spectra(noise: Noise, log: Log, like: Replay, own: Replay) -> Noise:
    """Add to noise the falling part that torques and trackers have beside white noise."""
    left, white, colours, less = (
        _subtract_model(like),
        _subtract_model(own),
        dict[str, NoiseSpectrum](),
        dict[str, Any](),
    )
    for family, name in (("motor.effort", "torque"), ("feedback.effort", "feedback"), ("tcp.position", "tool")):
        if family not in left:
            continue
        # only samples that the filter of the motion knows
        known, signals = log.known.T, (getattr(log, name), left[family], white[family])
        seen, rest, own_rest = ([values[rows, i] for i, rows in enumerate(known)] for values in signals)
        if not all(np.isfinite(values).all() for values in seen):
            continue
        # standard deviation above the band, where all of it is white
        above, sampling = getattr(noise, name), log.sampling
        level, alike = np.median(above, axis=0), family == "tcp.position"
        bands = sampling.cutoff, sampling.motion_filter, log.dt
        # estimate the part that falls with frequency, and take it off the white part
        colour = estimate_noise_spectrum(seen, rest, own_rest, *bands, level=level, alike=alike)
        if not colour.is_white:
            colours[family], less[name] = colour, colour.beside(above)
    return replace(noise, colours=colours, **less)


def _subtract_model(run: Replay) -> dict[str, Array]:
    """Subtract the model from torques and tracker positions at all samples, by family of columns."""
    read = run.read
    left = {"motor.effort": read.torque - run.torque}
    if read.feedback is not None and read.shows_servo:
        left["feedback.effort"] = read.feedback - predict_feedback(read, run.robot)
    if read.tool is not None:
        left["tcp.position"] = read.tool - predict_tracker(run)
    return left


def find_encoder_steps(log: Log) -> Array:
    """Find steps of the encoders in each motion, shape (M, N), motor side [rad]; 0 where there are none."""
    found = []
    for recording in log.recordings:
        if (bits := recording.header.encoder_bits) is not None:
            found.append(np.full(log.robot.n_joints, 2 * np.pi / 2**bits))
        else:
            found.append(np.array([_find_step(angle) for angle in read_motor_side(log.robot, recording).T]))
    return np.stack(found)


def _find_step(angle: Array) -> float:
    """Smallest change of a reading (T,) if all changes are multiples of it, else 0."""
    changes = np.abs(np.diff(angle))
    changes = changes[changes > _ROUNDING * max(1.0, float(np.abs(angle).max()))]
    if not len(changes):
        return 0.0
    step = float(changes.min())
    multiples = changes / step
    return step if np.mean(np.abs(multiples - np.round(multiples)) < _MULTIPLE) > _MOST else 0.0


def add_noise(exact: Recording, noise: Noise, i: int, rng: np.random.Generator) -> Recording:
    """An exact recording as the sensors of the i-th motion of a log would have it.

    Angles are rounded to the steps of the encoder, which is no white noise where a motor stands.
    """
    header, columns, n = exact.header, dict(exact.columns), len(exact)
    for j, joint in enumerate(header.joints):
        # noise that is more than that of rounding comes before it
        step, angle = float(noise.step[i, j]), exact[f"motor.position.{joint}"]
        more = np.sqrt(max(float(noise.angle[i, j]) ** 2 - step**2 / 12, 0.0))
        seen = angle + rng.normal(scale=more, size=n) if more > 0 else angle
        columns[f"motor.position.{joint}"] = np.round(seen / step) * step if step > 0 else seen
        # white noise of torques, and the part that falls with frequency
        for family, size in (("motor.effort", noise.torque), ("feedback.effort", noise.feedback)):
            if size is not None and exact.has(family):
                drawn = rng.normal(scale=size[i, j], size=n)
                if family in noise.colours:
                    drawn = drawn + noise.colours[family].drawn(j, n, rng)
                columns[f"{family}.{joint}"] = exact[f"{family}.{joint}"] + drawn
        if noise.link is not None:
            drawn = rng.normal(scale=noise.link[i, j], size=n)
            columns[f"link.position.{joint}"] = exact[f"link.position.{joint}"] + drawn
    if noise.tool is not None:
        for k, axis in enumerate("xyz"):
            seen = exact[f"tcp.position.{axis}"] + rng.normal(scale=noise.tool[i, k], size=n)
            if "tcp.position" in noise.colours:
                seen = seen + noise.colours["tcp.position"].drawn(k, n, rng)
            columns[f"tcp.position.{axis}"] = seen
    return Recording(columns=columns, header=header)


@dataclass(frozen=True, kw_only=True, eq=False)
class NullSimulation:
    """Residuals of a model without fault, with this log's noise."""

    draws: Mapping[Channel, Array]
    """(R, M, C, D) for D draws."""
    least: Mapping[Channel, Array] = field(default_factory=dict)
    """RMS that any model leaves beside noise, (C,) each; what is not there is 0."""

    def floor(self, log: Log) -> dict[Channel, Array]:
        """RMS by channel, shape (M, C); in no motion much less than in all."""
        valid = find_valid_rows(log)
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


def simulate_null_residuals(
    log: Log, own: Replay, bias: Mapping[Channel, Array], like: Replay, rng: np.random.Generator
) -> NullSimulation:
    """Simulate residuals without fault: the nominal model over its own recordings with a log's noise, less `bias`.

    The noise is seen in what a replay of the log leaves: of the nominal model, or of one that explains it better.
    """
    limits = settings().noise
    noise = estimate_noise(like)

    def drawn() -> Replay:
        seen = [add_noise(recording, noise, i, rng) for i, recording in enumerate(own.read.recordings)]
        return replay(assemble_log(log.robot, seen, like=log), own.machine, nearby=own)

    # one draw with white noise; its residual shows what else is in that of the log
    runs = [drawn()]
    noise = _add_spectra(noise, log, like, runs[0])
    if noise.colours:
        runs.clear()
    runs += [drawn() for _ in range(limits.draws - len(runs))]
    # residuals of all draws, without the bias of the replay
    draws: dict[Channel, list[Array]] = {}
    for run in runs:
        for channel, rows in compute_residuals(run.read, predict(run)).items():
            draws.setdefault(channel, []).append(rows - bias[channel])
    # RMS of torques that count, about their means in a motion: weights stay; and of what they bend springs by
    least, weight, measured = {}, find_valid_rows(log).astype(np.float64), filter_measured(log)
    bent = log.sampling(own.deflection.angle)
    changing: dict[Channel, Array] = {channel: measured[channel] for channel in draws.keys() & _TORQUES}
    if "link" in draws:
        changing["link"] = bent
    if "tool" in draws:
        changing["tool"] = np.einsum("rmkn,rmn->rmk", own.tool_jacobian, bent)
    for channel, rows in changing.items():
        about = rows - np.einsum("rmc,rm->mc", rows, weight) / np.maximum(weight.sum(axis=0), 1.0)[:, None]
        least[channel] = limits.torque_change_floor * np.sqrt(
            np.einsum("rmc,rm->c", about**2, weight) / max(weight.sum(), 1.0)
        )
    return NullSimulation(draws={channel: np.stack(each, axis=-1) for channel, each in draws.items()}, least=least)


def compute_torque_noise(run: Replay) -> Array:
    r"""Compute the RMS that white noise of torque and angle gives the residual, shape (M, N), motor side [N m].

    Through a low-pass of cut-off :math:`f_c`, white noise :math:`\sigma` of samples :math:`\Delta t` apart keeps
    :math:`\sigma \sqrt{2 f_c \Delta t}`, and its second derivative :math:`(2\pi)^2 \sigma \sqrt{2 f_c^5 \Delta t / 5}`.
    """
    noise, fc, dt = estimate_noise(run), run.log.sampling.cutoff, run.log.dt
    torque = noise.torque * np.sqrt(2 * fc * dt)
    acceleration = (2 * np.pi) ** 2 * noise.angle * np.sqrt(2 * fc**5 * dt / 5)
    floor = settings().noise.torque_floor * rms(run.torque, 0)
    known: Array = np.hypot(torque, run.robot.drive.rotor_inertia * acceleration)
    return np.maximum(known, np.maximum(floor, np.finfo(np.float64).tiny))
