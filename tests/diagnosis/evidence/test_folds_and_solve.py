"""What is left out is not fitted to, and bounded fits are those of a well-known solver."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from ffgym.diagnosis.evidence import blocks_of, half_folds, motion_folds
from ffgym.diagnosis.solving import bounded

ROW_DT = 0.01


def valid(*seconds):
    rows = np.zeros((round(max(seconds) / ROW_DT), len(seconds)), dtype=bool)
    for m, length in enumerate(seconds):
        rows[: round(length / ROW_DT), m] = True
    return rows


@given(st.lists(st.floats(0.2, 30.0), min_size=1, max_size=4))
def test_every_valid_row_is_of_one_block_of_its_motion_in_order_of_time(seconds):
    rows = valid(*seconds)
    blocks = blocks_of(rows, ROW_DT)
    assert np.all((blocks.of_row >= 0) == rows)
    for m in range(rows.shape[1]):
        own = blocks.of_row[rows[:, m], m]
        assert np.all(np.diff(own) >= 0)
        assert np.all(blocks.motion[own] == m)
        assert np.all(np.diff(blocks.half[np.unique(own)]) >= 0)


def test_halves_are_judged_by_fits_to_neither_them_nor_the_rows_at_the_cut():
    blocks = blocks_of(valid(12.0, 8.0), ROW_DT)
    folds = half_folds(blocks)
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
    blocks = blocks_of(valid(5.0, 3.0, 4.0), ROW_DT)
    for m, fold in enumerate(motion_folds(blocks)):
        np.testing.assert_array_equal(fold.test, blocks.motion == m)
        np.testing.assert_array_equal(fold.train, ~fold.test)
    assert motion_folds(blocks_of(valid(5.0), ROW_DT)) == []


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
    np.testing.assert_allclose(bounded(a.T @ a, a.T @ b, precision, low, high), expected, atol=1e-5)


@pytest.mark.parametrize("seed", range(12))
def test_many_parameters_that_hold_each_other_end_where_slopes_point_out_of_the_bounds(seed):
    """The conditions of Karush, Kuhn and Tucker, where exchanging all parameters at fault may go in circles."""
    rng, p = np.random.default_rng(seed), 60
    a = rng.normal(size=(80, p)) @ (np.eye(p) + 0.5 * rng.normal(size=(p, p)))
    gram, moment, precision = a.T @ a, a.T @ (50 * rng.normal(size=80)), np.ones(p)
    low, high = -rng.uniform(0, 0.3, p), rng.uniform(0, 0.3, p)
    low[:3] = high[:3] = 0.0
    x = bounded(gram, moment, precision, low, high)
    slope = moment - (gram + np.eye(p)) @ x
    near = 1e-9 * np.abs(moment).max()
    assert np.all((low <= x) & (x <= high))
    assert np.all((np.abs(slope) < near) | ((x == high) & (slope > 0)) | ((x == low) & (slope < 0)))


@given(st.lists(st.floats(0.2, 30.0), min_size=1, max_size=4))
def test_merged_blocks_leave_out_the_same_rows(seconds):
    blocks = blocks_of(valid(*seconds), ROW_DT)
    merged = blocks.merged()
    assert len(merged) <= min(len(blocks), 4 * len(seconds))
    for folds in (half_folds, motion_folds):
        for fine, coarse in zip(folds(blocks), folds(merged), strict=True):
            for part in ("train", "test"):
                rows = [
                    np.isin(one.of_row, np.flatnonzero(getattr(fold, part)))
                    for one, fold in ((blocks, fine), (merged, coarse))
                ]
                np.testing.assert_array_equal(*rows)
