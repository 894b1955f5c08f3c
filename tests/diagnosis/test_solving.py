"""Least squares with bounds on folds, and gains of many candidates at once."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from ffgym.diagnosis.normal_equations import build_design_matrix
from ffgym.diagnosis.resampling import cut_blocks, make_half_folds, make_motion_folds
from ffgym.diagnosis.solving import Candidate, Priors, compute_block_rss, screen, solve, solve_bounded

ROW_DT = 0.01


def valid(*seconds):
    rows = np.zeros((round(max(seconds) / ROW_DT), len(seconds)), dtype=bool)
    for m, length in enumerate(seconds):
        rows[: round(length / ROW_DT), m] = True
    return rows


@given(st.lists(st.floats(0.2, 30.0), min_size=1, max_size=4))
def test_every_valid_row_is_of_one_block_of_its_motion_in_order_of_time(seconds):
    rows = valid(*seconds)
    blocks = cut_blocks(rows, ROW_DT)
    assert np.all((blocks.of_row >= 0) == rows)
    for m in range(rows.shape[1]):
        own = blocks.of_row[rows[:, m], m]
        assert np.all(np.diff(own) >= 0)
        assert np.all(blocks.motion[own] == m)
        assert np.all(np.diff(blocks.half[np.unique(own)]) >= 0)


def test_halves_are_judged_by_fits_to_neither_them_nor_the_rows_at_the_cut():
    blocks = cut_blocks(valid(12.0, 8.0), ROW_DT)
    folds = make_half_folds(blocks)
    assert len(folds) == 4
    for fold in folds:
        assert not np.any(fold.train & fold.test)
        (motion,) = np.unique(blocks.motion[fold.test])
        assert len(np.unique(blocks.half[fold.test])) == 1
        assert not np.any(fold.train & blocks.guard & (blocks.motion == motion))
        last, first = np.flatnonzero(fold.test), np.flatnonzero(fold.train & (blocks.motion == motion))
        assert np.abs(last[:, None] - first[None]).min() > 1
    np.testing.assert_array_equal(sum(fold.test.astype(int) for fold in folds), 1)


def test_each_motion_is_left_out_as_a_whole():
    blocks = cut_blocks(valid(5.0, 3.0, 4.0), ROW_DT)
    for m, fold in enumerate(make_motion_folds(blocks)):
        np.testing.assert_array_equal(fold.test, blocks.motion == m)
        np.testing.assert_array_equal(fold.train, ~fold.test)
    assert make_motion_folds(cut_blocks(valid(5.0), ROW_DT)) == []


@pytest.mark.parametrize("seed", [*range(10), 43, 64])
def test_a_bounded_fit_with_a_prior_is_that_of_scipy(seed):
    rng = np.random.default_rng(seed)
    p = int(rng.integers(1, 12))
    a, b = rng.normal(size=(30, p)) @ rng.normal(size=(p, p)), rng.normal(size=30) * 5
    precision = rng.uniform(0.01, 2.0, size=p)
    high = rng.uniform(0.05, 1.0, size=p)
    low = -rng.uniform(0.05, 1.0, size=p)
    stacked = np.vstack([a, np.diag(np.sqrt(precision))])
    expected = lsq_linear(stacked, np.concatenate([b, np.zeros(p)]), (low, high), method="bvls").x
    np.testing.assert_allclose(solve_bounded(a.T @ a, a.T @ b, precision, low, high), expected, atol=1e-5)


@pytest.mark.parametrize("seed", range(12))
def test_many_parameters_that_hold_each_other_end_where_slopes_point_out_of_the_bounds(seed):
    """The conditions of Karush, Kuhn and Tucker, where exchanging all parameters at fault may go in circles."""
    rng, p = np.random.default_rng(seed), 60
    a = rng.normal(size=(80, p)) @ (np.eye(p) + 0.5 * rng.normal(size=(p, p)))
    gram, moment, precision = a.T @ a, a.T @ (50 * rng.normal(size=80)), np.ones(p)
    low, high = -rng.uniform(0, 0.3, p), rng.uniform(0, 0.3, p)
    low[:3] = high[:3] = 0.0
    x = solve_bounded(gram, moment, precision, low, high)
    slope = moment - (gram + np.eye(p)) @ x
    near = 1e-9 * np.abs(moment).max()
    assert np.all((low <= x) & (x <= high))
    assert np.all((np.abs(slope) < near) | ((x == high) & (slope > 0)) | ((x == low) & (slope < 0)))


@given(st.lists(st.floats(0.2, 30.0), min_size=1, max_size=4))
def test_merged_blocks_leave_out_the_same_rows(seconds):
    blocks = cut_blocks(valid(*seconds), ROW_DT)
    merged = blocks.merge()
    assert len(merged) <= min(len(blocks), 4 * len(seconds))
    for folds in (make_half_folds, make_motion_folds):
        for fine, coarse in zip(folds(blocks), folds(merged), strict=True):
            for part in ("train", "test"):
                rows = [
                    np.isin(one.of_row, np.flatnonzero(getattr(fold, part)))
                    for one, fold in ((blocks, fine), (merged, coarse))
                ]
                np.testing.assert_array_equal(*rows)


SCREEN_DT = 0.02
N_CALIBRATION, N_COLUMNS = 3, 6
CALIBRATION = np.arange(N_CALIBRATION)
CANDIDATES = (
    Candidate(columns=np.array([3]), one_sided=False),
    Candidate(columns=np.array([4, 5]), one_sided=False),
    Candidate(columns=np.array([5]), one_sided=True),
)
WIDE = 10.0


@pytest.fixture(scope="module")
def problem():
    """Rows of columns (C, R, M) and residuals (R, M, K) of one component, their sums and priors."""
    rng = np.random.default_rng(0)
    rows = (400, 3)
    columns = rng.normal(size=(N_COLUMNS, *rows)) * 0.05
    residual = columns[4][..., None] * [30.0, 0.0, 0.0] + 0.3 * columns[0][..., None] + rng.normal(size=(*rows, 3))
    valid = np.ones(rows, dtype=bool)
    valid[:5] = False
    blocks = cut_blocks(valid, SCREEN_DT)
    key = ("torque", 0)
    evidence = build_design_matrix(blocks, [{key: c} for c in columns], {key: valid.astype(float)}).form_equations(
        {key: residual}
    )
    priors = Priors(
        precision=np.array([1.0] * N_CALIBRATION + [WIDE**-2] * (N_COLUMNS - N_CALIBRATION)),
        low=np.array([-3.0] * N_CALIBRATION + [-np.inf] * 3),
        high=np.array([3.0] * N_CALIBRATION + [np.inf] * 3),
    )
    return columns, residual, blocks, evidence, priors


def rows_of(blocks, chosen):
    """Rows of some blocks."""
    return np.isin(blocks.of_row, np.flatnonzero(chosen))


def brute(problem, fold, places, k):
    """Energy left in what is left out by a fit with priors to the other rows."""
    columns, residual, blocks, _, priors = problem
    train, test = rows_of(blocks, fold.train), rows_of(blocks, fold.test)
    a = columns[places][:, train].T
    stacked = np.vstack([a, np.diag(np.sqrt(priors.precision[places]))])
    x = np.linalg.lstsq(stacked, np.concatenate([residual[train, k], np.zeros(len(places))]), rcond=None)[0]
    return np.sum((residual[test, k] - columns[places][:, test].T @ x) ** 2), x


@pytest.mark.parametrize("split", [make_half_folds, make_motion_folds])
def test_held_out_gains_are_those_of_fits_to_the_rows(problem, split):
    _, _, blocks, evidence, priors = problem
    folds = split(blocks)
    gain, left = screen(evidence, folds, CALIBRATION, CANDIDATES, priors)
    for k in range(3):
        before = sum(brute(problem, fold, CALIBRATION, k)[0] for fold in folds)
        assert left[k] == pytest.approx(before)
        for i in (0, 1):
            places = np.concatenate([CALIBRATION, CANDIDATES[i].columns])
            after = sum(brute(problem, fold, places, k)[0] for fold in folds)
            assert gain[i, k] == pytest.approx(before - after, abs=1e-6 * before)


def test_a_candidate_of_one_sign_gains_nothing_where_the_other_would_help(problem):
    columns, _, blocks, evidence, priors = problem
    key = ("torque", 0)
    weights = {key: (blocks.of_row >= 0).astype(float)}
    for sign, helps in ((1.0, True), (-1.0, False)):
        residual = {key: sign * 20 * columns[5][..., None]}
        gain, _ = screen(
            build_design_matrix(blocks, [{key: c} for c in columns], weights).form_equations(residual),
            make_half_folds(blocks),
            CALIBRATION,
            CANDIDATES,
            priors,
        )
        assert (gain[2, 0] > 0) == helps
        assert gain[1, 0] > 0
    assert evidence.n_components == 1


def test_sizes_that_a_log_without_noise_shows_as_one_are_screened_as_one(problem):
    """Two equal columns of 1e7 times the noise: rounding leaves nothing that tells them apart."""
    columns, residual, blocks, _, priors = problem
    columns = columns.copy()
    columns[4:] = 1e8 * columns[4]
    key, weights = ("torque", 0), {("torque", 0): (blocks.of_row >= 0).astype(float)}
    evidence = build_design_matrix(blocks, [{key: c} for c in columns], weights).form_equations({key: residual})
    alone = Candidate(columns=np.array([4]), one_sided=False)
    gain, _ = screen(evidence, make_half_folds(blocks), CALIBRATION, (alone, CANDIDATES[1]), priors)
    np.testing.assert_allclose(gain[1], gain[0], rtol=1e-3, atol=1e-3)


def test_energy_left_by_block_adds_up_to_that_of_all_that_was_left_out(problem):
    _, _, blocks, evidence, priors = problem
    folds = make_half_folds(blocks)
    left = compute_block_rss(evidence, folds, CALIBRATION, priors)
    assert left.sum() == pytest.approx(sum(brute(problem, fold, CALIBRATION, 0)[0] for fold in folds))


def test_calibration_at_its_bound_comes_back_when_the_cause_joins(problem):
    """The residual is all of candidate 1; a calibration column that looks like it must not keep its share."""
    columns, _, blocks, _, priors = problem
    columns = columns.copy()
    columns[0] = columns[4] + 0.1 * columns[0]
    key, weights = ("torque", 0), {("torque", 0): (blocks.of_row >= 0).astype(float)}
    rng = np.random.default_rng(1)
    residual = {key: 60 * columns[4][..., None] + 0.1 * rng.normal(size=(*columns.shape[1:], 1))}
    evidence = build_design_matrix(blocks, [{key: c} for c in columns], weights).form_equations(residual)
    assert solve(evidence, CALIBRATION, priors)[0] == priors.high[0]
    gain, left = screen(evidence, make_half_folds(blocks), CALIBRATION, CANDIDATES, priors)
    assert gain[1, 0] > 0.99 * left[0]


def test_scaled_columns_are_columns_in_other_units_and_may_be_added_one_by_one(problem):
    columns, residual, blocks, evidence, _ = problem
    key, units = ("torque", 0), np.linspace(0.5, 3.0, N_COLUMNS)
    weights, parts = {key: (blocks.of_row >= 0).astype(float)}, [{key: c} for c in columns]
    stack = build_design_matrix(blocks, parts[:2], weights, units[:2])
    for k in range(2, N_COLUMNS):
        stack = stack.beside([parts[k]], units[k : k + 1])
    found = stack.form_equations({key: residual})
    np.testing.assert_allclose(found.gram, evidence.gram * units[:, None] * units)
    np.testing.assert_allclose(found.moment, evidence.moment * units[:, None])
