"""All that a diagnosis computes before it searches: replay, noise floor, and the columns of calibration and effects."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.as_moved import as_moved
from ffgym.diagnosis.calibration import Calibration, Doubt, doubts_of
from ffgym.diagnosis.column import Column, columns_of
from ffgym.diagnosis.evidence import blocks_of
from ffgym.diagnosis.exact import FOREIGN, UNKNOWN, Exact, exact_recordings, has_servo, is_foreign, is_same_motion
from ffgym.diagnosis.fit.calibrate import calibrate
from ffgym.diagnosis.fit.fit import evaluated, excess_of, loudness, without_calibration
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.setting import Setting
from ffgym.diagnosis.log import Log, log_of
from ffgym.diagnosis.measured import counting_rows, residual_rows, valid_rows
from ffgym.diagnosis.noise import Faultless, encoder_steps, faultless_residuals
from ffgym.diagnosis.replay import Replay, predicted, replay
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.search.candidates import Candidates, candidates_of
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.variant import variants
from ffgym.diagnosis.weights import bound_outliers, doubt_rows, first_swing, misread_friction, unknown_torque
from ffgym.effects import Effect, TorqueEffect, Torques
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions
from ffgym.simulation.plant import Machine

_QUIET, _GONE = 0.25, 0.15
"""Energy above that of noise, as a share of it and of what stood out, that is left where numbers are why; chosen."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Prepared:
    """Beginning of a search."""

    setting: Setting
    run: Replay
    """Of the nominal machine over its own motion: where motors move as measured, a wrong spring swings at a frequency
    of its own, and what an effect changes would be seen through that swing."""
    faultless: Faultless
    floor: Mapping[Channel, Array]
    """RMS of noise alone, (M, C)."""
    simulated: bool
    """Whether that motion is of the controller along set-points, which other logs may share."""
    no_servo: str = ""
    """Why the feedback torque is not compared, though the log has it; empty if it is."""


@dataclass(eq=False)
class Memory:
    """Things that logs of the same motions on the same nominal machine share, kept from one diagnosis to the next."""

    key: bytes = b""
    known: "NominalRun | None" = None
    columns: dict[str, list[Column]] = field(default_factory=dict)
    """Of effects, by their name."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NominalRun:
    """The nominal machine over its own motion."""

    exact: tuple[Recording, ...]
    run: Replay
    bias: Mapping[Channel, Array]
    doubts: tuple[Doubt, ...]
    simulated: bool
    """Under its controller, not as measured."""


def prepared(
    log: Log,
    nominal: Machine,
    calibration: Calibration,
    rng: np.random.Generator,
    memory: Memory | None = None,
    at: Array | None = None,
) -> Prepared:
    """Replay the nominal model, and find out what noise alone would leave.

    Args:
        log: of a machine.
        nominal: what the simulation believes.
        calibration: how well its numbers are known.
        rng: draws noise.
        memory: what logs of the same motions share.
        at: where those numbers stand already, in standard deviations of all doubts; None is as described.
    """
    like = replay(log, nominal)
    known = _known(log, like, calibration, memory)
    reason = ""
    if log.shows_servo and not has_servo(log.robot):
        reason = UNKNOWN
    elif log.shows_servo and not known.simulated and is_foreign(log):
        reason = FOREIGN
    if reason:
        bare = replace(log, feedback=None)
        return replace(prepared(bare, nominal, calibration, rng, memory, at), no_servo=reason)
    faultless = faultless_residuals(log, known.run, known.bias, like, rng)
    floor = faultless.floor(log)
    weights = {(channel, c): rows / floor[channel][:, c] for (channel, c), rows in counting_rows(log).items()}
    missed = {channel: rows - known.bias[channel] for channel, rows in residual_rows(log, predicted(like)).items()}
    doubtful = doubt_rows(weights, {"torque": unknown_torque(like, known.bias)})
    setting = Setting(
        log=log,
        nominal=nominal,
        blocks=blocks_of(valid_rows(log), log.sampling.row_dt),
        weights=bound_outliers(doubtful, missed),
        calibration=[doubt.per_sigma for doubt in known.doubts],
        doubts=known.doubts,
        like=like,
        bias=known.bias,
        floor=floor,
    )
    if at is not None and len(known.doubts) == len(at):  # the slopes of another machine are others
        doubts = tuple(replace(doubt, at=place) for doubt, place in zip(known.doubts, at.tolist(), strict=True))
        setting = replace(setting, doubts=doubts)
    setting = replace(setting, weights=doubt_rows(setting.weights, first_swing(setting)))
    return Prepared(setting=setting, run=known.run, faultless=faultless, floor=floor, simulated=known.simulated)


def within_calibration(
    ready: Prepared,
    calibration: Calibration,
    rng: np.random.Generator,
    causes: Sequence[Hypothesis] = (),
    *,
    thoroughly: bool = True,
) -> Prepared | None:
    """All of it about numbers within their calibration that explain more than slopes tell; None if there are none.

    Masses and inertias that were fitted to the torque of the logs are the best that there are already.

    Args:
        ready: about the numbers as described.
        calibration: how well those are known.
        rng: draws noise.
        causes: beside which numbers are fitted; they are not in what is returned.
        thoroughly: whether numbers count that explain a little only.
    """
    limits = settings().prior
    if calibration.base > 0:
        return None
    first, at = ready, np.zeros(len(ready.setting.doubts))
    for _ in range(limits.centres):
        found = calibrate(ready.setting, calibration, causes, thoroughly=thoroughly)
        if found is None or np.max(np.abs(found.sizes)) < limits.centred:
            break
        at = at + found.sizes
        again = prepared(first.setting.log, found.trial.numbers, calibration, rng, at=at)
        if len(again.setting.doubts) != len(at):
            break
        ready = again
    if ready is first:
        return None
    left = loudness(first.setting, without_calibration(first.setting, evaluated(first.setting, ())))
    return replace(ready, setting=replace(ready.setting, described=left), no_servo=first.no_servo)


def explains_all(ready: Prepared, numbers: Prepared) -> bool:
    """Tell whether numbers within their calibration are why a machine as it is described leaves more than noise."""
    first, excess = (excess_of(one.setting, evaluated(one.setting, ())) for one in (ready, numbers))
    return excess < first and excess < max(_QUIET, _GONE * first)


def _known(log: Log, like: Replay, calibration: Calibration, memory: Memory | None) -> NominalRun:
    """The nominal machine over its own motion, remembered if it is the same as the last time."""
    key = _key(log, like, calibration) if memory is not None else b""
    if (
        memory is not None
        and memory.known is not None
        and memory.key == key
        and is_same_motion(log, memory.known.exact)
    ):
        known = memory.known
        return replace(
            known, run=replace(known.run, state=known.run.state.with_values(temperature=like.state.temperature))
        )
    known = _along(exact_recordings(log, like), log, like)
    plain, left = _torque_left(log, like, 0.0), _torque_left(log, like, known.bias["torque"])
    most = plain if known.simulated else settings().prior.noisy_bias * plain
    if left > most:  # its motion is not the measured one where that matters, as at reversals, or has noise in it
        for smooth in (False, True) if known.simulated else (True,):
            motion = Exact(recordings=tuple(as_moved(log, like, smooth=smooth)), simulated=False)
            moved = _along(motion, log, like)
            if _torque_left(log, like, moved.bias["torque"]) < (plain if known.simulated else left):
                known = moved
                break
    known = replace(known, doubts=tuple(doubts_of(known.run, calibration)))
    if memory is not None and known.simulated:
        memory.key, memory.known, memory.columns = key, known, {}
    return known


def _along(exact: Exact, log: Log, like: Replay) -> NominalRun:
    """The nominal machine over a motion that it is known to make, without doubts."""
    clean = log_of(log.robot, exact.recordings, like=log)
    run = replay(clean, like.machine)
    bias = residual_rows(clean, predicted(run))
    bias["torque"] = bias["torque"] - misread_friction(exact.recordings, clean, run, encoder_steps(log))
    return NominalRun(exact=exact.recordings, run=run, bias=bias, doubts=(), simulated=exact.simulated)


def _torque_left(log: Log, like: Replay, bias: Array | float) -> float:
    """Energy of torque that the nominal model leaves where that counts, less a bias; each joint as a share of it."""
    missed, left = residual_rows(log, predicted(like))["torque"], 0.0
    for (channel, j), rows in counting_rows(log).items():
        if channel == "torque" and rows.any():
            rest = (missed - bias)[..., j][rows]
            left += float(np.sum(rest**2) / np.sum(missed[..., j][rows] ** 2))
    return left


def _key(log: Log, like: Replay, calibration: Calibration) -> bytes:
    """Hash what the nominal machine's own motion depends on; motions without set-points are never the same."""
    digest = hashlib.sha256(repr((calibration, log.names, log.sampling, log.robot.name)).encode())
    digest.update(like.machine.physics(ModelOptions(looks=False)).encode())
    digest.update(repr([log.tool is None, log.link is None, log.shows_servo]).encode())
    hot = log.temperature if any(reads_temperature(effect, like) for effect in like.machine.torque_effects) else None
    for values in (*(log.reference or ()), log.started, log.trembling, encoder_steps(log), hot):
        digest.update(b"-" if values is None else np.ascontiguousarray(values).tobytes())
    return digest.digest()


def candidates_for(ready: Prepared, kinds: Sequence[type[Effect]], memory: Memory | None = None) -> Candidates:
    """Effects that depend on no frequency, beside calibration errors; what other logs share is remembered."""
    lasting = [kind for kind in kinds if not repeats(kind)]
    shared = []
    if memory is not None and ready.simulated:  # columns that are the same at any temperature
        for kind in lasting:
            some = next(variants(kind, ready.run.robot, {}), None)
            if some is None or not reads_temperature(some.effect, ready.run):
                shared.append(kind)
    known = {} if memory is None else memory.columns
    new = [kind for kind in lasting if kind not in shared or kind.name not in known]
    found: dict[str, list[Column]] = {kind.name: [] for kind in new}
    for column in columns_of(ready.run, new, {}):
        found[column.effect.name].append(column)
    if memory is not None:
        memory.columns |= {kind.name: found[kind.name] for kind in shared if kind.name in found}
    columns = [column for kind in lasting for column in (found | known if kind in shared else found)[kind.name]]
    setting = ready.setting
    return candidates_of(setting.doubts, columns, setting.blocks.merged(), setting.weights)


def repeats(kind: type[Effect]) -> bool:
    """Tell whether an effect repeats with the motor angle, at a frequency that must be looked for."""
    return any(p.is_looked_for for p in kind.parameters().values())


def reads_temperature(effect: Effect, run: Replay) -> bool:
    """Tell whether an effect depends on temperature, tried in the middle of a replay."""
    if not isinstance(effect, TorqueEffect):
        return False
    shape = run.state.motor_angle.shape
    middle = run.state.each(lambda values: np.broadcast_to(values, shape)[shape[0] // 2])
    memory = effect.initial_memory(middle)
    warm = middle.with_values(temperature=middle.temperature + settings().prior.warmer)
    here, warmer = (effect.torques(state, memory, run.log.dt)[0] for state in (middle, warm))
    return not all(np.array_equal(getattr(here, f.name), getattr(warmer, f.name)) for f in fields(Torques))
