"""When a rival ties, and when a cause may stand for something else."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.search import rivals
from ffgym.diagnosis.search.rivals import _UNSURE, _inexactness, _is_tied
from ffgym.diagnosis.verdict import LOUD, _is_explained, stretched_shapes
from ffgym.effects import EFFECTS

KEY = ("torque", 0)


def tried(left, numbers):
    """Something that was fitted: energy left in each block, and how many numbers it took."""
    hypothesis = SimpleNamespace(free=lambda: [None] * numbers)
    left = np.asarray(left, dtype=float)
    return SimpleNamespace(left=left, total=float(left.sum()), fit=SimpleNamespace(hypotheses=[hypothesis]))


def is_tied(best, other, *, numbers=(1, 1)):
    before = tried(np.full(100, 100.0), 0)
    return _is_tied(None, before, tried(best, numbers[0]), tried(other, numbers[1]), np.random.default_rng(0))


def test_a_rival_that_is_better_in_half_of_all_blocks_ties(monkeypatch):
    monkeypatch.setattr(rivals, "_inexactness", lambda setting, best: 0.0)
    noise = np.random.default_rng(1).normal(size=100)
    assert is_tied(np.full(100, 10.0), 10.0 + 5 * noise, numbers=(1, 5))
    assert not is_tied(np.full(100, 10.0), 20.0 + 5 * noise)
    worse = 10.0 + 5 * (noise - noise.mean()) / noise.std() + 1.1  # by 2.2 standard deviations of the sum
    assert not is_tied(np.full(100, 10.0), worse, numbers=(1, 5))


@pytest.mark.parametrize(("more", "numbers", "ties"), [(1.0, (2, 1), True), (1.0, (1, 2), False), (3.0, (2, 1), False)])
def test_a_rival_with_no_more_numbers_ties_if_an_inexact_equation_would_leave_as_much(more, numbers, ties):
    """Both leave the same more in every block, so that resamples are sure; 90 were to be explained in each."""
    assert is_tied(np.full(100, 10.0), np.full(100, 10.0 + more), numbers=numbers) == ties


@pytest.mark.parametrize(("inexact", "ties"), [(99.0, False), (101.0, True)])
def test_a_rival_with_as_many_numbers_ties_if_the_best_leaves_as_much_above_the_noise(monkeypatch, inexact, ties):
    """It leaves 100 more of 9000; as a gear that errs beside a resolver, of which one leaves nothing but noise."""
    monkeypatch.setattr(rivals, "_inexactness", lambda setting, best: inexact)
    assert is_tied(np.full(100, 10.0), np.full(100, 11.0), numbers=(3, 3)) == ties
    assert is_tied(np.full(100, 10.0), np.full(100, 11.0), numbers=(3, 2))
    assert not is_tied(np.full(100, 10.0), np.full(100, 13.0), numbers=(3, 3))


@pytest.mark.parametrize(("loud", "open_share"), [(0.4, _UNSURE), (1.0, _UNSURE), (1.5, 0.5)])
def test_equations_are_as_inexact_as_what_the_best_leaves_where_it_acts(monkeypatch, loud, open_share):
    weights = {KEY: np.array([[1.0, 0.0], [2.0, 1.0]]), ("tool", 2): np.ones((2, 2))}
    setting = SimpleNamespace(weights=weights, blocks=SimpleNamespace(of_row=np.zeros((2, 2))))
    monkeypatch.setattr(rivals, "without_calibration", lambda setting, fit: {})
    monkeypatch.setattr(rivals, "loudness", lambda setting, rest: {KEY: loud, ("tool", 2): 50.0})
    best = SimpleNamespace(fit=SimpleNamespace(columns=({KEY: np.ones((2, 2))},)))
    assert _inexactness(setting, best) == pytest.approx(3 * open_share)


@pytest.mark.parametrize(
    ("before", "after", "explained"),
    [(3.0, LOUD - 0.1, True), (3.0, LOUD + 0.1, False), (101.0, 10.0, True), (101.0, 12.0, False)],
)
def test_nothing_is_named_without_reserve_while_a_component_is_left_with_what_no_clean_log_has(
    before, after, explained
):
    """As the flexibility of a base, of which the stiffness of a joint explains four fifths."""
    other = ("tool", 2)
    assert _is_explained({KEY: before, other: 1.1}, {KEY: after, other: 1.1}) == explained


@pytest.mark.parametrize(
    ("time", "size", "found"), [(0.1, 3.0, True), (1.2, 3.0, False), (0.1, 1e-3, False), (10.0, 3.0, True)]
)
def test_a_shape_at_the_end_of_its_range_is_told_where_the_log_shows_it(time, size, found, one_axis):
    kind, joint = EFFECTS["dwell_stiction"], one_axis.joints[0]
    values = {"share": np.array(0.2), "time": np.array(time), "slip": np.array(0.02)}
    hypothesis = Hypothesis(kind=kind, joint=joint, source=None, values=values)
    rows = np.ones((50, 2))
    fit = SimpleNamespace(hypotheses=(hypothesis,), columns=[{KEY: size * rows}] * 3)
    setting = SimpleNamespace(weights={KEY: rows})
    assert stretched_shapes(setting, fit) == ((f"time of {hypothesis.label}",) if found else ())


def test_a_shape_that_stays_where_it_usually_is_is_not_at_the_end_of_its_range(one_axis):
    kind = EFFECTS["temperature_friction"]
    values = {name: np.array(p.neutral if p.default is None else p.default) for name, p in kind.parameters().items()}
    assert float(values["reference"]) == kind.parameters()["reference"].low
    hypothesis = Hypothesis(kind=kind, joint=one_axis.joints[0], source=None, values=values)
    rows = np.ones((50, 2))
    fit = SimpleNamespace(hypotheses=(hypothesis,), columns=[{KEY: 3 * rows}] * len(hypothesis.free()))
    assert stretched_shapes(SimpleNamespace(weights={KEY: rows}), fit) == ()
