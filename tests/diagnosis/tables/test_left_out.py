"""Places are left out by fits of their own, which explain the rows that stay better than one step from the optimum."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.executors import Executor
from ffgym.diagnosis.tables.document import table_document
from ffgym.diagnosis.tables.fitting import FitTask, fit_structure
from ffgym.diagnosis.tables.problem import TableProblem
from ffgym.diagnosis.tables.procedure import diagnose_table
from tests.diagnosis.tables.small_table import DT, FAST, SLOW, small_table

STEPS = 3


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    return small_table(tmp_path_factory.mktemp("motions"))


@pytest.fixture(scope="module")
def problem(table):
    return TableProblem(table, "numbers", DT)


@pytest.fixture(scope="module")
def optimum(problem):
    return problem.search(np.zeros((1, 9)), STEPS, lambda point: None, {})


def cost_of_others(problem, place, x):
    """Sum of squares without the rows of a place, from the residuals of all rows."""
    ((_, residuals),) = problem.evaluate(x[None])
    rows, priors = residuals[: len(problem.rows_at(place))], residuals[len(problem.rows_at(place)) :]
    return float(np.sum(rows[~problem.rows_at(place)] ** 2) + np.sum(priors**2))


@pytest.mark.parametrize("place", [SLOW, pytest.param(FAST, marks=pytest.mark.slow)])
def test_a_fit_of_its_own_leaves_less_in_the_other_rows_than_one_step(problem, optimum, place):
    stepped = problem.step_without(place, optimum, problem.descent.jacobian(optimum))
    found = problem.search_without(place, optimum.x, STEPS, lambda point: None, {})
    assert found.cost == pytest.approx(cost_of_others(problem, place, found.x), rel=1e-12)
    assert found.cost < cost_of_others(problem, place, optimum.x)
    assert found.cost <= cost_of_others(problem, place, stepped)


def test_rows_that_are_left_out_do_not_move_their_own_prediction(table, problem, optimum):
    """Twice the measured errors at a place change the fit with it, and not the fit without it."""
    rows = [replace(r, value_mm=2 * r.value_mm) if r.motion.file == FAST else r for r in table.rows]
    other = TableProblem(replace(table, rows=tuple(rows)), "numbers", DT)
    for place, same in ((FAST, True), (SLOW, False)):
        one, two = (each.search_without(place, optimum.x, 1, lambda point: None, {}) for each in (problem, other))
        assert (one.x.tolist() == two.x.tolist()) is same


@pytest.mark.parametrize("kind", ["refit", "one step"])
def test_the_document_tells_which_fit_predicts_what_was_left_out(table, kind):
    found = diagnose_table(
        table,
        structures=("numbers",),
        pairs=False,
        executor=Executor(jobs=1),
        steps=1,
        left_out_by=kind,
        judge_dt=DT,
        sessions=(),
    )
    (structure,) = table_document(found)["structures"]
    assert structure["left_out_by"] == kind
    assert None not in structure["left_out_mm"]


@pytest.mark.slow
def test_the_prediction_of_a_place_comes_from_the_fit_without_it(table, problem, optimum, tmp_path):
    fit = fit_structure(FitTask(table=table, name="numbers", folder=tmp_path, steps=STEPS, judge_dt=DT))
    for place in (SLOW, FAST):
        found = problem.search_without(place, optimum.x, STEPS, lambda point: None, {})
        rows = table.at(place)
        np.testing.assert_array_equal(np.array(fit.left_out_mm)[rows], found.outcome[rows])
