"""Numbers of a machine within their calibration that explain a log, where slopes about the described ones do not.

Columns of a calibration are slopes. A spring that is a per cent stiffer than described swings at another frequency, and
after ten swings its phase is another one; masses that are known to five per cent are off by products of such shares.
Numbers are fitted by Gauss-Newton steps in a trust region, each with slopes about where the last one led: slopes that
stay do not lead to the numbers of an arm that swings, and long steps leave the valley in which those lie.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.computing import FAILED
from ffgym.diagnosis.fit.descent import Slope, Steps, descend
from ffgym.diagnosis.fit.fit import Trial, build_priors, compute_row_energy, replay_hypotheses
from ffgym.diagnosis.fit.hypothesis import Hypothesis, move_hypotheses
from ffgym.diagnosis.fit.problem import HELD, FitProblem, compute_tangents, split_components
from ffgym.diagnosis.fit.written import possible_numbers
from ffgym.diagnosis.normal_equations import DesignMatrix, NormalEquations, build_design_matrix
from ffgym.diagnosis.nuisance import ParameterPrior, list_nuisance_parameters
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import solve_bounded
from ffgym.effects import NativeEffect


@dataclass(frozen=True, kw_only=True, eq=False)
class Calibrated:
    """A nominal machine with other numbers, and what they leave."""

    sizes: Array
    """Differences in standard deviations of the nuisance parameters; 0 for those that are no numbers of the robot."""
    trial: Trial
    equations: NormalEquations
    cost: float
    """Energy that is left beside errors that are no numbers of the robot, and the squares of all errors."""


def calibrate(
    setting: FitProblem, prior: ParameterPrior, causes: Sequence[Hypothesis] = (), *, thoroughly: bool = True
) -> Calibrated | None:
    """Find numbers within their calibration that explain a log better than slopes tell; None if there are none.

    They are fitted beside `causes`, and these beside them; a number that is a cause stays as it is described. Numbers
    that explain a little only count if it is done `thoroughly`; else a search ends where further slopes say no more
    than the first ones.
    """
    # begin at the numbers as they are; where slopes tell all that they do, nothing is to be found
    described = replay_hypotheses(setting, causes)
    if not setting.nuisances or described is None:
        return None
    problem = _Numbers(setting=setting, prior=prior)
    slopes = problem.slopes(described) if causes else setting.design
    at_rest = np.zeros(len(setting.nuisances))
    now = None if slopes is None else problem.place(at_rest, described, slopes)
    if now is None:
        return None
    limits, predicted = settings().estimator, problem.predict_energy(now)
    if not causes:
        # one step as far as slopes say; where it leaves less than they promise, the numbers lie near
        far = problem.move(now, step := problem.step(now, np.inf))
        if far is not None and not problem.is_bent(now, far, step):
            return None
        now = now if far is None or far.cost > predicted else problem.renew(far, is_last=False)
    # descend from there; a search that is not thorough ends where slopes promise neither much less nor noise alone
    most = np.inf if thoroughly else max(limits.promises * predicted, float(now.equations.rows.sum()))
    steps = Steps(
        most=limits.number_steps,
        reach=limits.number_reach,
        least_reach=limits.number_least_reach,
        gain=limits.number_gain,
    )
    found = descend(replace(problem, most=most), now, steps)
    return found if found is not None and found.sizes.any() else None


@dataclass(frozen=True, kw_only=True, eq=False)
class _Numbers(Slope[Calibrated]):
    """Numbers of the robot in standard deviations, beside causes and errors that are no numbers."""

    setting: FitProblem
    prior: ParameterPrior
    most: float = np.inf
    """Energy that slopes may promise to leave at most, if all of it is to be due to numbers."""

    @cached_property
    def of_robot(self) -> BoolArray:
        """Errors that are numbers of the robot, shape (K,)."""
        return np.array([issubclass(nuisance.column.effect, NativeEffect) for nuisance in self.setting.nuisances])

    @cached_property
    def at(self) -> Array:
        """Place of the nominal machine from what is described, in standard deviations, shape (K,)."""
        return np.array([nuisance.at for nuisance in self.setting.nuisances])

    def slopes(self, trial: Trial) -> DesignMatrix | None:
        """Columns of all errors and causes about a machine; None if it has others than the described one."""
        nuisances = list_nuisance_parameters(trial.run, self.prior)
        if len(nuisances) != len(self.setting.nuisances):
            return None
        stack = build_design_matrix(
            self.setting.blocks, [nuisance.per_sigma for nuisance in nuisances], self.setting.weights
        )
        try:
            return (
                stack.beside(compute_tangents(trial.run, trial.numbers, trial.hypotheses))
                if trial.hypotheses
                else stack
            )
        except FAILED:
            return None

    def place(self, sizes: Array, trial: Trial, slopes: DesignMatrix) -> Calibrated | None:
        """A place whose errors that are no numbers are fitted by slopes; None if what it leaves is no number."""
        evidence = slopes.form_equations(split_components(trial.residual))
        priors = self.setting.nuisance_priors(trial.hypotheses)
        rest = np.flatnonzero(~self.of_robot)
        gram, pull = evidence.gram.sum(axis=0)[np.ix_(rest, rest)], evidence.moment.sum(axis=0)[rest, 0]
        x = solve_bounded(gram, pull - self.at[rest], np.ones(len(rest)), priors.low[rest], priors.high[rest])
        left = float(evidence.energy.sum() - 2 * x @ pull + x @ gram @ x)
        errors = self.at + sizes
        errors[rest] += x
        cost = left + float(errors @ errors)
        return Calibrated(sizes=sizes, trial=trial, equations=evidence, cost=cost) if np.isfinite(cost) else None

    def cost(self, point: Calibrated) -> float:
        return point.cost

    def renew(self, point: Calibrated, *, is_last: bool) -> Calibrated:
        slopes = None if is_last else self.slopes(point.trial)
        again = None if slopes is None else self.place(point.sizes, point.trial, slopes)
        return again or point

    def length(self, step: Array) -> float:
        return super().length(step[: len(self.of_robot)])

    def is_hopeless(self, point: Calibrated) -> bool:
        # energy that is due to something else than numbers stays, whatever slopes there are
        return np.isfinite(self.most) and self.predict_energy(point) > self.most

    def step(self, point: Calibrated, reach: float) -> Array:
        step = self._solve(point, reach)
        step[: len(self.of_robot)] *= self.of_robot  # other errors are fitted in each place
        return step

    def _solve(self, point: Calibrated, reach: float) -> Array:
        """Solve for changes of all errors and causes by slopes, those of numbers within a reach."""
        priors, n = build_priors(self.setting, point.trial.hypotheses), len(self.of_robot)
        there, low, high = np.zeros(len(priors.low)), priors.low.copy(), priors.high.copy()
        there[:n] = self.at + point.sizes
        low[:n], high[:n] = low[:n] - point.sizes, high[:n] - point.sizes
        low[:n] = np.where(self.of_robot, np.maximum(low[:n], -reach), low[:n])
        high[:n] = np.where(self.of_robot, np.minimum(high[:n], reach), high[:n])
        gram, pull = point.equations.gram.sum(axis=0), point.equations.moment.sum(axis=0)[:, 0]
        ends = np.minimum(low, -HELD), np.maximum(high, HELD)
        step: Array = solve_bounded(gram, pull - there, priors.precision, *ends)
        return step

    def predict_energy(self, now: Calibrated) -> float:
        """Predict the least energy by slopes about a place, however far numbers move."""
        step = self._solve(now, np.inf)
        gram, pull = now.equations.gram.sum(axis=0), now.equations.moment.sum(axis=0)[:, 0]
        return float(now.equations.energy.sum() - 2 * step @ pull + step @ gram @ step)

    def move(self, point: Calibrated, step: Array) -> Calibrated | None:
        n, causes = len(self.of_robot), point.trial.hypotheses
        priors = self.setting.nuisance_priors(causes)
        sizes = np.clip(point.sizes + step[:n], priors.low, priors.high)
        sizes[np.abs(sizes) <= HELD] = 0.0
        machine = possible_numbers(self.setting, sizes)
        trial = None if machine is None else replay_hypotheses(self.setting, move_hypotheses(causes, step[n:]), machine)
        return None if trial is None else self.place(sizes, trial, point.equations.design)

    def is_bent(self, now: Calibrated, there: Calibrated, step: Array) -> bool:
        """Tell whether a replay with other numbers, a step away, differs from what slopes say of it."""
        # change by the other numbers beyond what their slopes say
        beyond = {channel: now.trial.residual[channel] - rows for channel, rows in there.trial.residual.items()}
        for column, size in zip(self.setting.nuisance_columns, step.tolist(), strict=True):
            for (channel, c), rows in column.items():
                if channel in beyond:
                    beyond[channel][:, :, c] -= size * rows
        is_used, weights = self.setting.blocks.of_row >= 0, self.setting.weights
        bent = [compute_row_energy(beyond[c][:, :, k], w * is_used) for (c, k), w in weights.items() if c in beyond]
        return max(bent, default=0.0) > settings().estimator.bent
