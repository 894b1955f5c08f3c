"""What a cause is credited with: what it removes where it acts, beyond what inexact causes before it would leave."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit import fit as module
from ffgym.diagnosis.fit.fit import (
    Fit,
    compute_excess,
    compute_explained,
    compute_row_energy,
    find_touched,
    loudness,
    subtract_nuisances,
)
from ffgym.diagnosis.normal_equations import build_design_matrix
from ffgym.diagnosis.resampling import cut_blocks
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import Priors

ONE, OTHER = ("torque", 0), ("torque", 1)


def test_a_cause_is_credited_with_what_it_removes_where_it_acts():
    gone = compute_explained({ONE: 11.0, OTHER: 50.0}, {ONE: 3.0, OTHER: 50.0}, {ONE})
    assert gone.of_excess == pytest.approx(0.8)
    assert gone.of_all == pytest.approx(8 / 11)
    assert gone.excess == pytest.approx(10 / 11)


def test_what_an_inexact_cause_would_leave_is_not_credited_to_another():
    before, after = {ONE: 3.0, OTHER: 3.0}, {ONE: 1.0, OTHER: 1.0}
    assert compute_explained(before, after, {ONE}, {ONE: 2.5}).of_excess == 0.0
    assert compute_explained(before, after, {ONE, OTHER}, {ONE: 1.0, OTHER: 0.0}).of_excess == pytest.approx(0.75)
    assert compute_explained(before, after, {ONE}, {ONE: 0.5}).of_excess == pytest.approx(0.75)


def test_what_a_cause_adds_counts_against_it_whatever_is_allowed_for():
    assert compute_explained({ONE: 3.0}, {ONE: 5.0}, {ONE}, {ONE: 2.5}).of_excess == pytest.approx(-1.0)
    assert compute_explained({ONE: 3.0}, {ONE: 3.5}, {ONE}, {ONE: 1.0}).of_excess == pytest.approx(-0.25)
    assert compute_explained({ONE: 3.0}, {ONE: 2.5}, {ONE}, {ONE: 1.0}).of_excess == 0.0  # all of it is allowed for


def test_what_comes_within_the_noise_is_nothing_that_was_to_be_explained():
    gone = compute_explained({ONE: 0.9, OTHER: 0.5}, {ONE: 0.2, OTHER: 0.8}, {ONE, OTHER})
    assert gone.of_excess == pytest.approx((0.7 - 0.3) / 0.7)


def test_a_component_with_no_more_left_than_an_inexact_cause_leaves_does_not_judge_another():
    before, after = {ONE: 3.0, OTHER: 3.0}, {ONE: 2.9, OTHER: 1.0}
    assert compute_explained(before, after, {ONE, OTHER}, {ONE: 2.5, OTHER: 0.0}).of_excess == pytest.approx(1.0)
    assert compute_explained(before, after, {ONE, OTHER}).of_excess == pytest.approx(0.525)


def test_the_best_component_and_how_many_are_heard_are_told_where_one_drowns_the_others():
    keys = [("torque", k) for k in range(4)]
    before = dict(zip(keys, (1001.0, 201.0, 101.0, 1.5), strict=True))
    after = dict(zip(keys, (951.0, 101.0, 61.0, 1.5), strict=True))
    gone = compute_explained(before, after, set(keys))
    assert gone.of_excess == pytest.approx(190 / 1300.5)
    assert gone.n_loud == 3  # the quiet one has hardly anything to say
    assert gone.best == pytest.approx(0.5)
    assert compute_explained(before, before, set(keys)).best == 0.0


def test_calibration_explains_what_it_can_beside_hypotheses_as_they_are():
    """A step of the hypothesis would change what the calibration does, which is all that there is."""
    rows = np.sin(np.linspace(0, 20, 400)).reshape(-1, 1)
    key, column = ("torque", 0), {("torque", 0): 0.5 * rows}
    residual = {"torque": rows[..., None]}
    blocks = cut_blocks(np.ones((400, 1), dtype=bool), 0.01)
    stack = build_design_matrix(blocks, [column], {key: np.ones(1)}).beside([{key: rows}])
    priors = Priors(precision=np.array([1e-6, 1e-9]), low=np.full(2, -9.0), high=np.full(2, 9.0))
    found = Fit(
        numbers=None,
        hypotheses=(),
        run=None,
        residual=residual,
        columns=({key: rows},),
        equations=stack.form_equations({key: rows[..., None]}),
        priors=priors,
        left=0.0,
    )
    rest = subtract_nuisances(SimpleNamespace(nuisance_columns=[column]), found)
    assert np.abs(rest["torque"]).max() < 1e-4
    np.testing.assert_array_equal(residual["torque"][..., 0], rows)
    with pytest.raises(ValueError, match="shorter"):
        subtract_nuisances(SimpleNamespace(nuisance_columns=[column, column]), found)


def test_no_cause_explains_more_than_all_where_the_floor_of_noise_is_too_high():
    gone = compute_explained({ONE: 1.2}, {ONE: 0.1}, {ONE})
    assert gone.of_excess == pytest.approx(1.0)
    assert compute_explained({ONE: 0.4}, {ONE: 0.1}, {ONE}).of_excess == pytest.approx(1.0)
    assert compute_explained({ONE: 3.0}, {ONE: 2.0}, {ONE}).of_excess == pytest.approx(0.5)


def test_shares_of_little_energy_are_shares_all_the_same():
    """As of a log whose noise is less than its floor."""
    gone = compute_explained({ONE: 0.5}, {ONE: 0.3}, {ONE})
    assert gone.of_all == pytest.approx(0.4)
    assert gone.of_excess == pytest.approx(1.0)
    assert gone.excess == 0.0
    half = compute_explained({ONE: 1.5}, {ONE: 1.25}, {ONE})
    assert (half.of_excess, half.best) == (pytest.approx(0.5), pytest.approx(0.5))
    assert half.excess == pytest.approx(0.5 / 1.5)


def test_where_nothing_is_above_the_noise_nothing_is_explained():
    gone = compute_explained({ONE: 0.5, OTHER: 0.0}, {ONE: 0.5, OTHER: 0.0}, {ONE, OTHER})
    assert (gone.of_excess, gone.of_all, gone.excess, gone.n_loud, gone.best) == (0.0, 0.0, 0.0, 0, 0.0)
    nothing = compute_explained({ONE: 0.0}, {ONE: 0.0}, {ONE})
    assert (nothing.of_excess, nothing.of_all, nothing.excess) == (0.0, 0.0, 0.0)


def test_a_component_with_as_much_left_as_an_inexact_cause_leaves_does_not_judge_either():
    before, after = {ONE: 3.0, OTHER: 3.0}, {ONE: 2.0, OTHER: 2.0}
    assert compute_explained(before, after, {ONE, OTHER}, {ONE: 2.0, OTHER: 0.0}).of_all == pytest.approx(1 / 3)


def test_the_best_component_is_among_those_with_a_tenth_of_all_or_more():
    """Of three with 1, 1 and 18 above the noise, or with 2, 0 and 18."""
    keys = [("torque", k) for k in range(3)]
    after = dict.fromkeys(keys, 1.0)
    before = dict(zip(keys, (2.0, 2.0, 19.0), strict=True))
    few = compute_explained(before, after | {keys[2]: 10.0}, set(keys))
    assert (few.n_loud, few.best) == (3, pytest.approx(0.5))
    before = dict(zip(keys, (3.0, 1.0, 19.0), strict=True))
    few = compute_explained(before, after | {keys[2]: 10.0}, set(keys))
    assert (few.n_loud, few.best) == (2, pytest.approx(1.0))


def test_energy_is_per_row_that_counts():
    rows = np.array([[1.0, 2.0], [3.0, 4.0]])
    assert compute_row_energy(rows, np.array([[1.0, 0.0], [2.0, 1.0]])) == pytest.approx((1 + 36 + 16) / 3)
    assert compute_row_energy(rows, np.array([0.0, 0.5])) == pytest.approx((1 + 4) / 2)
    assert compute_row_energy(rows[:1], np.array([3.0, 0.0])) == pytest.approx(9.0)
    assert compute_row_energy(rows, np.zeros(2)) == 0.0


def test_the_excess_is_that_of_the_loudest_component_above_its_noise(monkeypatch):
    """Beside calibration, in rows that are valid."""
    valid = np.array([[True], [True], [False], [True]])
    monkeypatch.setattr(module, "find_valid_rows", lambda log: valid)
    weights = {ONE: np.array([2.0]), OTHER: np.array([1.0]), ("tool", 0): np.array([[1.0], [1.0], [1.0], [0.0]])}
    rows = np.array([[[1.0, 2.0]], [[-1.0, 1.0]], [[9.0, 9.0]], [[2.0, 0.0]]])
    rest = {"torque": rows, "tool": rows[..., :1]}
    problem = SimpleNamespace(log=None, weights=weights)
    found = loudness(problem, rest)
    assert found == {ONE: pytest.approx(4 * 6 / 3), OTHER: pytest.approx(5 / 3), ("tool", 0): pytest.approx(1.0)}
    monkeypatch.setattr(module, "subtract_nuisances", lambda problem, fit: fit)
    assert compute_excess(problem, rest) == pytest.approx(7.0)


def test_columns_touch_components_with_a_notable_share_of_their_energy():
    """In all channels, or in the same one: a tool moves by millimetres where a torque is large."""
    share = settings().search.touched
    small, tool = ("torque", 2), ("tool", 0)
    weights = dict.fromkeys((ONE, OTHER, small, tool), np.array([1.0]))
    problem = SimpleNamespace(weights=weights)

    def rows(energy):
        return np.full((4, 1), energy**0.5)

    columns = [{ONE: rows(60.0), OTHER: rows(share * 60)}, {ONE: rows(40.0), OTHER: rows(share * 60)}]
    columns.append({small: rows(share * 50), tool: rows(share * 50)})
    assert find_touched(problem, columns) == {ONE, OTHER}
    assert find_touched(problem, columns[:2]) == {ONE, OTHER}  # with the energy of both
    assert find_touched(problem, columns, by_channel=True) == {ONE, OTHER, tool}
    few = [{key: 1e-3 * values for key, values in column.items()} for column in columns]
    assert find_touched(problem, few) == {ONE, OTHER}
    assert find_touched(problem, few, by_channel=True) == {ONE, OTHER, tool}
    assert find_touched(problem, [{ONE: rows(0.0)}]) == set()
    assert find_touched(problem, []) == set()
