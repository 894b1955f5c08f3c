"""The model as it is written: causes, and the numbers that were fitted beside them.

A fit to a log holds for causes and calibration errors together; with the nominal numbers in their place, a cause that
overlaps one of them would make the model worse. So both are put into one machine, which is replayed, and fitted once
more about where it then is.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.fit.descent import Slope, Steps, descend
from ffgym.diagnosis.fit.fit import Fit, Trial, replay_hypotheses
from ffgym.diagnosis.fit.hypothesis import Hypothesis, move_hypotheses
from ffgym.diagnosis.fit.problem import HELD, FitProblem, compute_tangents, split_components
from ffgym.diagnosis.normal_equations import NormalEquations
from ffgym.diagnosis.nuisance import NuisanceParameter, ParameterPrior, Refit
from ffgym.diagnosis.replay import predict
from ffgym.diagnosis.replay.channels import undo_delay
from ffgym.diagnosis.residual_rows import compute_residuals
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import solve_bounded
from ffgym.effects import ClockEffect, Effect, NativeEffect
from ffgym.effects.friction.stribeck import StribeckPeak
from ffgym.logs.preparation import convert_to_recorded_side
from ffgym.recordings import Recording
from ffgym.simulation.plant import Machine

_ROUNDING = 1e-12
"""Least excess of a breakaway torque over the Coulomb torque, as a share of it: sums are rounded."""


def with_numbers(nominal: Machine, nuisances: Sequence[NuisanceParameter], sizes: Array) -> Machine:
    """The nominal machine with its calibration errors corrected.

    By sizes (len(doubts),) in standard deviations; 0 for those that are not of the machine.
    """
    # one effect of each kind with the numbers of all its joints
    n, joints, values = nominal.robot.n_joints, nominal.robot.joints, dict[type[Effect], dict[str, Array]]()
    for nuisance, size in zip(nuisances, sizes.tolist(), strict=True):
        column, known = nuisance.column, nuisance.column.effect.parameters()
        own = values.setdefault(
            column.effect, {name: np.full(p.shape(n), p.neutral) for name, p in known.items() if p.null is not None}
        )
        place = joints.index(column.joint) if column.joint else () if column.part is None else column.part
        own[column.parameter][place] += size * nuisance.sigma
    # numbers go into the description where it has them, and stand beside it as effects where it has not
    robot, beside = nominal.robot, list[Effect]()
    for effect in (kind(**own) for kind, own in values.items()):
        if effect.is_null:
            continue
        if isinstance(effect, StribeckPeak):  # a breakaway torque comes down to the Coulomb torque at most
            least = (1 + _ROUNDING) - robot.friction.static / robot.friction.coulomb
            effect = replace(effect, level=np.maximum(effect.level, least))
        if isinstance(effect, NativeEffect):
            robot = effect.in_description(robot)
        else:
            beside.append(effect)
    return replace(nominal, robot=robot, effects=(*nominal.effects, *beside))


def possible_numbers(problem: FitProblem, sizes: Array) -> Machine | None:
    """The machine with its numbers corrected; None if none can be so."""
    try:
        machine = with_numbers(problem.nominal, problem.nuisances, sizes)
        _ = machine.physical
    except FFGymError:
        return None
    return machine


def build_extended_model(
    problem: FitProblem, fit: Fit, prior: ParameterPrior, train: BoolArray | None = None
) -> Trial | None:
    """Causes of a fit, and numbers beside them, as one model that can be written to a file; None if no machine can.

    Fitted to the blocks of `train` (B,), or to all. Of its residual nothing is taken off but what the replay itself
    misses.
    """
    chosen = np.ones(len(problem.blocks), dtype=np.bool_) if train is None else train
    # a fit with causes knows what the replay of their machine misses
    missed = compute_residuals(problem.log, predict(fit.run))
    problem = problem.with_bias({channel: missed[channel] - rows for channel, rows in fit.residual.items()})
    if prior.refit is not None:
        return _refit(problem, fit, prior.refit, chosen)
    return _fit_by_priors(problem, fit, chosen)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Model:
    """Causes with numbers beside them, in one machine."""

    sizes: Array
    """Changes of the numbers of the machine, in standard deviations."""
    hypotheses: tuple[Hypothesis, ...]
    cost: float
    compute_equations: Callable[[], NormalEquations]
    """Computes the slopes about it, which the last step needs no more."""
    trial: Trial | None = None
    """The machine, replayed; None before the first step."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Extension(Slope[_Model]):
    """Numbers of the machine in standard deviations and free numbers of causes in practical steps."""

    problem: FitProblem
    fit: Fit
    chosen: BoolArray
    """Blocks that are fitted to."""

    def cost(self, point: _Model) -> float:
        return point.cost

    def step(self, point: _Model, reach: float) -> Array:
        return _solve(point.compute_equations(), self.fit, point.sizes, self.chosen)

    def move(self, point: _Model, step: Array) -> _Model | None:
        n = self.fit.n_nuisances
        # errors of the machine become its numbers; those of how rows were written do not
        of_machine = np.array(
            [not issubclass(nuisance.column.effect, ClockEffect) for nuisance in self.problem.nuisances], np.bool_
        )
        sizes, hypotheses = point.sizes + step[:n] * of_machine, move_hypotheses(point.hypotheses, step[n:])
        sizes[np.abs(sizes) <= HELD] = 0.0
        numbers = possible_numbers(self.problem, sizes)
        trial = None if numbers is None else replay_hypotheses(self.problem, hypotheses, numbers, self.fit.run)
        if trial is None:
            return None
        left = self.problem.design.form_equations(split_components(trial.residual)).energy
        cost = float(left[self.chosen].sum() + sizes @ sizes)
        equations = partial(_evidence, self.problem, trial)
        return _Model(sizes=sizes, hypotheses=hypotheses, compute_equations=equations, cost=cost, trial=trial)

    def renew(self, point: _Model, *, is_last: bool) -> _Model:
        return point


def _fit_by_priors(problem: FitProblem, fit: Fit, chosen: BoolArray) -> Trial | None:
    """Correct nuisance parameters as their priors and the log have them, beside the causes."""
    none = np.zeros(fit.n_nuisances)
    start = _Model(sizes=none, hypotheses=fit.hypotheses, compute_equations=lambda: fit.equations, cost=np.inf)
    steps = Steps(most=settings().estimator.model_steps, least_reach=np.inf)
    found = descend(_Extension(problem=problem, fit=fit, chosen=chosen), start, steps)
    return None if found is None else found.trial


def _evidence(problem: FitProblem, tried: Trial) -> NormalEquations:
    """Sums of calibration errors and free numbers about a model."""
    columns = compute_tangents(tried.run, tried.numbers, tried.hypotheses)
    return problem.design.beside(columns).form_equations(split_components(tried.residual))


def _solve(equations: NormalEquations, fit: Fit, sizes: Array, chosen: BoolArray) -> Array:
    """Changes of calibration errors and free numbers where errors of `sizes` are in the model already."""
    precision = fit.priors.precision
    there = np.concatenate([sizes, np.zeros(len(precision) - fit.n_nuisances)])
    pull = equations.moment[chosen].sum(axis=0)[:, 0] - precision * there
    gram = equations.gram[chosen].sum(axis=0)
    return solve_bounded(gram, pull, precision, fit.priors.low - there, fit.priors.high - there)


def _refit(problem: FitProblem, fit: Fit, refit: Refit, chosen: BoolArray) -> Trial | None:
    """Fit the numbers that were fitted to the logs anew, to the torque that the causes leave."""
    motions = np.unique(problem.blocks.motion[chosen]).tolist()
    numbers, hypotheses, best = problem.nominal, fit.hypotheses, None
    # twice, as causes and numbers each depend on the other
    for last in (False, True):
        tried, plain = replay_hypotheses(problem, hypotheses, numbers), replay_hypotheses(problem, (), numbers)
        if tried is None or plain is None:
            return best
        # fit the numbers to the torque without what the causes add
        added = tried.run.torque - plain.run.torque
        effects = tried.machine.effects
        left = [_without_causes(problem, i, effects, added[: problem.log.lengths[i], i]) for i in motions]
        numbers = replace(problem.nominal, robot=refit(left))
        best = replay_hypotheses(problem, hypotheses, numbers)
        if best is None or last or not hypotheses:
            return best
        # move the sizes of the causes to what suits the new numbers
        x = _solve(_evidence(problem, best), fit, np.zeros(fit.n_nuisances), chosen)
        hypotheses = move_hypotheses(hypotheses, x[fit.n_nuisances :])
    return best


def _without_causes(problem: FitProblem, motion: int, effects: Sequence[Effect], torque: Array) -> Recording:
    """The recording of a motion in step with its positions, less a torque (T, N), motor side [N m]."""
    recording = problem.log.recordings[motion]
    own = convert_to_recorded_side(problem.log.robot.drive, recording.header, torque)
    names = [f"motor.effort.{joint}" for joint in recording.header.joints]
    measured = np.stack([recording[name] for name in names], axis=1)
    rest = undo_delay(measured, "torque", effects, recording.dt) - own
    return recording.with_columns({name: rest[:, j] for j, name in enumerate(names)})
