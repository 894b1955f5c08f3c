"""What a cause is credited with: what it removes where it acts, beyond what inexact causes before it would leave."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit.fit import Fit, compute_explained, subtract_nuisances
from ffgym.diagnosis.normal_equations import build_design_matrix
from ffgym.diagnosis.resampling import cut_blocks
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


def test_no_cause_explains_more_than_all_where_the_floor_of_noise_is_too_high():
    gone = compute_explained({ONE: 1.2}, {ONE: 0.1}, {ONE})
    assert gone.of_excess == pytest.approx(1.0)
    assert compute_explained({ONE: 0.4}, {ONE: 0.1}, {ONE}).of_excess == pytest.approx(1.0)
    assert compute_explained({ONE: 3.0}, {ONE: 2.0}, {ONE}).of_excess == pytest.approx(0.5)
