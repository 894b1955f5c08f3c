"""Preparation of a search: nominal replay, bias, noise floor, and columns of nuisance parameters and effects."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.clean_recordings import (
    FOREIGN,
    UNKNOWN,
    CleanRecordings,
    has_foreign_servo,
    has_servo,
    is_same_motion,
    make_clean_recordings,
)
from ffgym.diagnosis.clean_replay import replay_finely
from ffgym.diagnosis.fit.calibrate import calibrate
from ffgym.diagnosis.fit.fit import compute_excess, evaluate, loudness, subtract_nuisances
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.problem import FitProblem
from ffgym.diagnosis.log import Log, assemble_log
from ffgym.diagnosis.noise import NullSimulation, find_encoder_steps, simulate_null_residuals
from ffgym.diagnosis.nuisance import NuisanceParameter, ParameterPrior, list_nuisance_parameters
from ffgym.diagnosis.replay import Replay, predict, replay
from ffgym.diagnosis.resampling import cut_blocks
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.residual_rows import compute_residuals, find_counting_rows, find_valid_rows
from ffgym.diagnosis.search.candidates import Candidates, build_candidates
from ffgym.diagnosis.sensitivity import Sensitivity, compute_sensitivities
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.variant import list_variants
from ffgym.diagnosis.weights import (
    bound_outliers,
    downweight,
    estimate_misread_friction,
    estimate_unknown_torque,
    fit_first_swing,
)
from ffgym.effects import Effect, TorqueEffect, Torques
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions
from ffgym.simulation.plant import Machine

_LOUDER = 1.1
"""Noise floor over that of before from which on it is another; chosen: draws of the noise differ by some per cent."""

_QUIET, _GONE = 0.25, 0.15
"""Energy above that of noise, as a share of it and of what stood out, that is left where numbers are why; chosen."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PreparedSearch:
    """Prepared problem of a search, with the noise floor."""

    problem: FitProblem
    run: Replay
    """Replay of the nominal machine over its own motion: where motors move as measured, a wrong spring swings at a
    frequency of its own, and what an effect changes would be seen through that swing."""
    null: NullSimulation
    floor: Mapping[Channel, Array]
    """RMS of noise alone, (M, C)."""
    simulated: bool
    """True if that motion is of the controller along set-points, which other logs may share."""
    no_servo: str = ""
    """Why the feedback torque is not compared, though the log has it; empty if it is."""


@dataclass(eq=False)
class DiagnosisCache:
    """Cache of what logs of the same motions on the same nominal machine share, from one diagnosis to the next."""

    key: bytes = b""
    known: "NominalRun | None" = None
    columns: dict[str, list[Sensitivity]] = field(default_factory=dict)
    """Columns of effects, by their name."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NominalRun:
    """Replay of the nominal machine over its own motion."""

    exact: tuple[Recording, ...]
    run: Replay
    bias: Mapping[Channel, Array]
    nuisances: tuple[NuisanceParameter, ...]
    simulated: bool
    """Under its controller, not as measured."""


def prepare(
    log: Log,
    nominal: Machine,
    prior: ParameterPrior,
    rng: np.random.Generator,
    cache: DiagnosisCache | None = None,
    at: Array | None = None,
) -> PreparedSearch:
    """Replay the nominal model, and find out what noise alone would leave.

    Args:
        log: of a machine.
        nominal: what the simulation believes.
        prior: how well its numbers are known.
        rng: draws noise.
        cache: what logs of the same motions share.
        at: where those numbers stand already, in standard deviations of all doubts; None is as described.
    """
    # replay along the log, and the nominal machine over a clean motion of its own, for the bias
    like = replay(log, nominal)
    known = _recall_or_run(log, like, prior, cache)
    # leave out the feedback torque if the documented servo did not make it
    reason = ""
    if log.shows_servo and not has_servo(log.robot):
        reason = UNKNOWN
    elif log.shows_servo and not known.simulated and has_foreign_servo(log):
        reason = FOREIGN
    if reason:
        bare = replace(log, feedback=None)
        return replace(prepare(bare, nominal, prior, rng, cache, at), no_servo=reason)
    null_residuals = simulate_null_residuals(log, known.run, known.bias, like, rng)
    floor = null_residuals.floor(log)
    problem = FitProblem(
        log=log,
        nominal=nominal,
        blocks=cut_blocks(find_valid_rows(log), log.sampling.row_dt),
        weights=_weigh_rows(log, like, known.bias, floor),
        nuisance_columns=[nuisance.per_sigma for nuisance in known.nuisances],
        nuisances=known.nuisances,
        like=like,
        bias=known.bias,
        floor=floor,
    )
    # nuisance parameters count from the description, not from where they stand already
    if at is not None and len(known.nuisances) == len(at):  # the slopes of another machine are others
        nuisances = tuple(
            replace(nuisance, at=place) for nuisance, place in zip(known.nuisances, at.tolist(), strict=True)
        )
        problem = replace(problem, nuisances=nuisances)
    # springs may swing freely at first, by a state that the log does not show: such rows count less
    problem = replace(problem, weights=downweight(problem.weights, fit_first_swing(problem)))
    return PreparedSearch(problem=problem, run=known.run, null=null_residuals, floor=floor, simulated=known.simulated)


def _weigh_rows(
    log: Log, like: Replay, bias: Mapping[Channel, Array], floor: Mapping[Channel, Array]
) -> Mapping[tuple[Channel, int], Array]:
    """Weigh rows by one over the noise floor (M, C); less where torque is unknown or rows are outliers."""
    weights = {(channel, c): rows / floor[channel][:, c] for (channel, c), rows in find_counting_rows(log).items()}
    missed = {channel: rows - bias[channel] for channel, rows in compute_residuals(log, predict(like)).items()}
    return bound_outliers(downweight(weights, {"torque": estimate_unknown_torque(like, bias)}), missed)


def renew_floor(ready: PreparedSearch, explained: Replay, rng: np.random.Generator) -> PreparedSearch | None:
    """Estimate the noise floor anew, in what a model with causes leaves of a log; None if it is no higher.

    What a cause does lies over the noise of the band, and may hide that it is louder there than above.
    """
    problem, log = ready.problem, ready.problem.log
    null = simulate_null_residuals(log, ready.run, problem.bias, explained, rng)
    floor = null.floor(log)
    if not any(np.any(floor[channel] > _LOUDER * ready.floor[channel]) for channel in floor):
        return None
    problem = replace(problem, floor=floor, weights=_weigh_rows(log, problem.like, problem.bias, floor))
    problem = replace(problem, weights=downweight(problem.weights, fit_first_swing(problem)))
    return replace(ready, problem=problem, null=null, floor=floor)


def fit_within_prior(
    ready: PreparedSearch,
    prior: ParameterPrior,
    rng: np.random.Generator,
    causes: Sequence[Hypothesis] = (),
    *,
    thoroughly: bool = True,
) -> PreparedSearch | None:
    """Fit numbers within their prior, and prepare the search about them; None if they explain no more than slopes.

    Masses and inertias that were fitted to the torque of the logs are the best that there are already.

    Args:
        ready: about the numbers as described.
        prior: how well those are known.
        rng: draws noise.
        causes: beside which numbers are fitted; they are not in what is returned.
        thoroughly: whether numbers count that explain a little only.
    """
    limits = settings().prior
    if prior.base > 0:
        return None
    # alternate: fit the numbers, then prepare bias and noise about them anew
    first, at = ready, np.zeros(len(ready.problem.nuisances))
    for _ in range(limits.centres):
        found = calibrate(ready.problem, prior, causes, thoroughly=thoroughly)
        if found is None or np.max(np.abs(found.sizes)) < limits.centred:
            break
        at = at + found.sizes
        again = prepare(first.problem.log, found.trial.numbers, prior, rng, at=at)
        if len(again.problem.nuisances) != len(at):
            break
        ready = again
    if ready is first:
        return None
    # what the description leaves says how much of it the fitted numbers may leave
    left = loudness(first.problem, subtract_nuisances(first.problem, evaluate(first.problem, ())))
    return replace(ready, problem=replace(ready.problem, described=left), no_servo=first.no_servo)


def explains_all(ready: PreparedSearch, numbers: PreparedSearch) -> bool:
    """Tell whether numbers within their prior explain all that the machine as described leaves above noise."""
    first, excess = (compute_excess(one.problem, evaluate(one.problem, ())) for one in (ready, numbers))
    return excess < first and excess < max(_QUIET, _GONE * first)


def _recall_or_run(log: Log, like: Replay, prior: ParameterPrior, cache: DiagnosisCache | None) -> NominalRun:
    """Run the nominal machine over its own motion, or recall it if it is the same as the last time."""
    key = _hash_motion(log, like, prior) if cache is not None else b""
    if cache is not None and cache.known is not None and cache.key == key and is_same_motion(log, cache.known.exact):
        known = cache.known
        return replace(
            known, run=replace(known.run, state=known.run.state.with_values(temperature=like.state.temperature))
        )
    # simulate or replay the nominal machine, and see whether its bias fits the measured motion
    known = _replay_along(make_clean_recordings(log, like), log, like)
    plain, left = _compute_torque_left(log, like, 0.0), _compute_torque_left(log, like, known.bias["torque"])
    most = plain if known.simulated else settings().prior.noisy_bias * plain
    if left > most:  # its motion is not the measured one where that matters, as at reversals, or has noise in it
        for smooth in (False, True) if known.simulated else (True,):
            motion = CleanRecordings(recordings=tuple(replay_finely(log, like, smooth=smooth)), simulated=False)
            moved = _replay_along(motion, log, like)
            if _compute_torque_left(log, like, moved.bias["torque"]) < (plain if known.simulated else left):
                known = moved
                break
    # nuisance parameters along that motion
    known = replace(known, nuisances=tuple(list_nuisance_parameters(known.run, prior)))
    if cache is not None and known.simulated:
        cache.key, cache.known, cache.columns = key, known, {}
    return known


def _replay_along(exact: CleanRecordings, log: Log, like: Replay) -> NominalRun:
    """Replay the nominal machine along a clean motion of its own, without nuisance parameters."""
    clean = assemble_log(log.robot, exact.recordings, like=log)
    run = replay(clean, like.machine)
    bias = compute_residuals(clean, predict(run))
    bias["torque"] = bias["torque"] - estimate_misread_friction(exact.recordings, clean, run, find_encoder_steps(log))
    return NominalRun(exact=exact.recordings, run=run, bias=bias, nuisances=(), simulated=exact.simulated)


def _compute_torque_left(log: Log, like: Replay, bias: Array | float) -> float:
    """Compute the energy of torque that the nominal model leaves less a bias, each joint as a share of that without."""
    missed, left = compute_residuals(log, predict(like))["torque"], 0.0
    for (channel, j), rows in find_counting_rows(log).items():
        if channel == "torque" and rows.any():
            rest = (missed - bias)[..., j][rows]
            left += float(np.sum(rest**2) / np.sum(missed[..., j][rows] ** 2))
    return left


def _hash_motion(log: Log, like: Replay, prior: ParameterPrior) -> bytes:
    """Hash what the nominal machine's own motion depends on; motions without set-points are never the same."""
    digest = hashlib.sha256(repr((prior, log.names, log.sampling, log.robot.name)).encode())
    digest.update(like.machine.physics(ModelOptions(looks=False)).encode())
    digest.update(repr([log.tool is None, log.link is None, log.shows_servo]).encode())
    hot = log.temperature if any(reads_temperature(effect, like) for effect in like.machine.torque_effects) else None
    for values in (*(log.reference or ()), log.started, log.trembling, find_encoder_steps(log), hot):
        digest.update(b"-" if values is None else np.ascontiguousarray(values).tobytes())
    return digest.digest()


def list_candidates(
    ready: PreparedSearch, kinds: Sequence[type[Effect]], cache: DiagnosisCache | None = None
) -> Candidates:
    """List candidates that depend on no frequency, beside nuisance parameters; shared columns are cached."""
    # effects whose columns are the same at any temperature are shared by logs of the same motions
    lasting = [kind for kind in kinds if not repeats(kind)]
    shared = []
    if cache is not None and ready.simulated:  # columns that are the same at any temperature
        for kind in lasting:
            some = next(list_variants(kind, ready.run.robot, {}), None)
            if some is None or not reads_temperature(some.effect, ready.run):
                shared.append(kind)
    known = {} if cache is None else cache.columns
    # compute the columns that are not cached
    new = [kind for kind in lasting if kind not in shared or kind.name not in known]
    found: dict[str, list[Sensitivity]] = {kind.name: [] for kind in new}
    for column in compute_sensitivities(ready.run, new, {}):
        found[column.effect.name].append(column)
    if cache is not None:
        cache.columns |= {kind.name: found[kind.name] for kind in shared if kind.name in found}
    columns = [column for kind in lasting for column in (found | known if kind in shared else found)[kind.name]]
    problem = ready.problem
    return build_candidates(problem.nuisances, columns, problem.blocks.merge(), problem.weights)


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
