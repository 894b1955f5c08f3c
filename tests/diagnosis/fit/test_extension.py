"""A model that is written pays for the numbers that it moves, and for none that only say how rows were written."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit import written as module
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.problem import HELD
from ffgym.diagnosis.fit.written import _Extension, _fit_by_priors, _Model, _solve, build_extended_model
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.solving import Priors
from ffgym.effects import EFFECTS

ENERGY = np.array([3.0, 5.0, 7.0])
"""Energy that is left in three blocks, the last of which is not fitted to."""


@pytest.fixture
def extension(monkeypatch):
    """An extension of two numbers of the machine and one of the clock, with a cause; replays leave `ENERGY`."""
    cause = Hypothesis(kind=EFFECTS["load_friction"], joint="j1", source=None, values={"share": np.array(0.1)})
    of = [EFFECTS["torque_constant"], EFFECTS["coulomb_level"], EFFECTS["torque_clock"]]
    problem = SimpleNamespace(
        nuisances=[SimpleNamespace(column=SimpleNamespace(effect=effect)) for effect in of],
        design=SimpleNamespace(form_equations=lambda residual: SimpleNamespace(energy=ENERGY)),
    )
    fit = SimpleNamespace(n_nuisances=3, run=None, hypotheses=(cause,))
    monkeypatch.setattr(module, "split_components", lambda residual: residual)
    monkeypatch.setattr(module, "possible_numbers", lambda problem, sizes: None if sizes[0] > 5 else sizes)
    monkeypatch.setattr(
        module, "replay_hypotheses", lambda problem, hypotheses, numbers, run: SimpleNamespace(residual={})
    )
    chosen = np.array([True, True, False])
    begun = _Model(sizes=np.zeros(3), hypotheses=(cause,), cost=np.inf, compute_equations=lambda: None)
    return _Extension(problem=problem, fit=fit, chosen=chosen), begun


def test_a_model_costs_what_it_leaves_and_what_its_numbers_moved_by(extension):
    slope, begun = extension
    there = slope.move(begun, np.array([0.5, -2.0, 3.0, 1.0]))
    np.testing.assert_array_equal(there.sizes, [0.5, -2.0, 0.0])  # a clock is how rows were written
    assert slope.cost(there) == pytest.approx(8.0 + 0.25 + 4.0)
    (free,) = begun.hypotheses[0].list_free()
    assert float(there.hypotheses[0].values["share"]) == pytest.approx(0.1 + free.step)


def test_a_number_that_hardly_moved_stays(extension):
    slope, begun = extension
    there = slope.move(begun, np.array([0.5 * HELD, -2.0 * HELD, 0.0, 0.0]))
    assert (there.sizes[0], there.sizes[1]) == (0.0, -2.0 * HELD)
    assert slope.move(begun, np.array([HELD, 0.0, 0.0, 0.0])).sizes[0] == 0.0


def test_where_no_machine_can_be_there_is_no_model(extension):
    slope, begun = extension
    assert slope.move(begun, np.array([6.0, 0.0, 0.0, 0.0])) is None


def equations(gram, moment):
    """Sums over blocks: products of columns (B, P, P), and with residuals of the log and of noise, (B, P, 2)."""
    moment = np.array(moment)
    return SimpleNamespace(gram=np.array(gram), moment=np.stack([moment, 1e3 + moment], axis=2))


def fit_with(precision, low, high, n_nuisances, **more):
    priors = Priors(precision=np.array(precision), low=np.array(low), high=np.array(high))
    return SimpleNamespace(priors=priors, n_nuisances=n_nuisances, **more)


BLOCKS = equations(
    [[[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]], np.diag([2.0, 1.0, 5.0]), np.eye(3) * 99.0],
    [[4.0, 1.0, -7.0], [6.0, 2.0, -9.0], [99.0, 99.0, 99.0]],
)
"""Three numbers that do not act on each other; the third block is not fitted to."""


def test_a_step_minimises_what_chosen_blocks_leave_and_what_numbers_cost_from_what_is_described():
    """The first number is a doubt that already moved by a half; causes are free to begin where they are."""
    fit = fit_with([2.0, 0.1, 0.2], [-9.0] * 3, [9.0] * 3, 1)
    step = _solve(BLOCKS, fit, np.array([0.5]), np.array([True, True, False]))
    np.testing.assert_allclose(step, [(10 - 2 * 0.5) / (3 + 2), 3 / (3 + 0.1), -16 / (8 + 0.2)])


def test_a_step_ends_where_a_number_is_at_its_bound_from_what_is_described():
    fit = fit_with([2.0, 0.1, 0.2], [-9.0, -9.0, -1.0], [1.25, 9.0, 1.0], 1)
    step = _solve(BLOCKS, fit, np.array([0.5]), np.array([True, True, False]))
    np.testing.assert_allclose(step, [0.75, 3 / 3.1, -1.0])
    down = equations(-BLOCKS.gram, -BLOCKS.moment[..., 0])
    fit = fit_with([2.0, 0.1, 0.2], [-1.25, -9.0, -1.0], [9.0, 9.0, 1.0], 1)
    step = _solve(equations(BLOCKS.gram, down.moment[..., 0]), fit, np.array([0.5]), np.array([True, True, False]))
    np.testing.assert_allclose(step, [-1.75, -3 / 3.1, 1.0])


def test_a_model_by_priors_is_the_machine_that_its_steps_lead_to(extension, monkeypatch):
    """No step leads further down, as whatever is replayed leaves the same energy."""
    slope, _ = extension
    sums = equations([np.eye(4)] * 3, [[1.0, -2.0, 3.0, 0.0]] * 3)
    n = slope.fit.hypotheses[0].list_free()
    fit = fit_with([1.0] * 4, [-9.0] * 4, [9.0] * 4, 3, equations=sums, hypotheses=slope.fit.hypotheses, run=None)
    assert len(n) == 1
    tried = []

    def replay(problem, hypotheses, numbers, run):
        tried.append(SimpleNamespace(residual={}, numbers=numbers))
        return tried[-1]

    monkeypatch.setattr(module, "replay_hypotheses", replay)
    monkeypatch.setattr(module, "_evidence", lambda problem, trial: sums)
    found = _fit_by_priors(slope.problem, fit, slope.chosen)
    assert found is tried[0]
    np.testing.assert_allclose(found.numbers, [2 / 3, -4 / 3, 0.0])
    monkeypatch.setattr(module, "possible_numbers", lambda problem, sizes: None)
    assert _fit_by_priors(slope.problem, fit, slope.chosen) is None


class Biased:
    """A problem of two blocks whose bias is told when it is exchanged."""

    log, blocks = None, (0, 1)

    def with_bias(self, bias):
        return bias


@pytest.mark.parametrize("train", [None, np.array([True, False])])
@pytest.mark.parametrize("refit", [None, lambda recordings: None])
def test_of_a_written_model_only_that_is_taken_off_which_its_replay_misses(monkeypatch, train, refit):
    """And its numbers are fitted as they were to the logs, if they were."""
    fit = SimpleNamespace(run=None, residual={"torque": np.array([1.0, 2.0])})
    monkeypatch.setattr(module, "predict", lambda run: None)
    monkeypatch.setattr(module, "compute_residuals", lambda log, predicted: {"torque": np.array([1.5, 5.0])})
    monkeypatch.setattr(module, "_refit", lambda bias, fit, how, chosen: ("refit", how, bias, chosen))
    monkeypatch.setattr(module, "_fit_by_priors", lambda bias, fit, chosen: ("priors", None, bias, chosen))
    way, how, bias, chosen = build_extended_model(Biased(), fit, ParameterPrior(refit=refit), train)
    assert (way, how) == ("priors" if refit is None else "refit", refit)
    np.testing.assert_array_equal(bias["torque"], [0.5, 3.0])
    np.testing.assert_array_equal(chosen, [True, True] if train is None else train)
