"""Where candidates act, which of them explain the same, and what they begin with."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import optimize

from ffgym.diagnosis.normal_equations import build_design_matrix
from ffgym.diagnosis.resampling import cut_blocks
from ffgym.diagnosis.search import ranking as module
from ffgym.diagnosis.search.candidates import Candidates
from ffgym.diagnosis.search.ranking import (
    _compute_largest,
    _fit_linearly,
    build_hypothesis,
    compute_overlap,
    find_changed_components,
    propose_start,
    rank,
)
from ffgym.diagnosis.sensitivity import Sensitivity
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import Candidate, Priors
from ffgym.effects import EFFECTS
from ffgym.robot import load_robot

FIRST, SECOND = ("torque", 0), ("tool", 1)
ROWS = (300, 2)
NONE = np.array([], dtype=int)


def problem(columns, residual, groups):
    """Evidence of columns by component, and candidates of them without calibration."""
    blocks = cut_blocks(np.ones(ROWS, dtype=bool), 0.02)
    evidence = build_design_matrix(blocks, columns, {key: np.ones(ROWS) for key in residual}).form_equations(
        {key: rows[..., None] for key, rows in residual.items()}
    )
    n = len(columns)
    priors = Priors(precision=np.full(n, 1e-2), low=np.full(n, -np.inf), high=np.full(n, np.inf))
    made = [Candidate(columns=np.array(group), one_sided=False) for group in groups]
    return evidence, SimpleNamespace(groups=made, priors=priors)


def test_a_candidate_acts_where_its_fit_changes_the_predictions():
    rng = np.random.default_rng(0)
    a, b, c = rng.normal(size=(3, *ROWS))
    columns = [{FIRST: a, SECOND: 2 * b}, {SECOND: c}, {FIRST: b}]
    evidence, candidates = problem(columns, {FIRST: 3 * a + b, SECOND: 6 * b + c}, [[0], [1], [2], [0, 1]])
    where = [find_changed_components(evidence, candidates, i, NONE) for i in range(4)]
    assert where[0][FIRST] == pytest.approx(np.sum(a**2) / (np.sum(a**2) + 4 * np.sum(b**2)))
    assert where[1] == {FIRST: 0.0, SECOND: 1.0}
    assert where[2] == {FIRST: 1.0, SECOND: 0.0}
    assert compute_overlap(where[1], where[2]) == 0.0
    assert compute_overlap(where[0], where[0]) == pytest.approx(1.0)
    assert compute_overlap(where[0], where[1]) == pytest.approx(where[0][SECOND])
    both = 9 * np.sum(a**2) / (9 * np.sum(a**2) + np.sum((6 * b + c) ** 2))
    assert where[3][FIRST] == pytest.approx(both, rel=0.02)


def test_what_explains_nothing_acts_nowhere():
    evidence, candidates = problem([{FIRST: np.ones(ROWS)}], {FIRST: np.zeros(ROWS)}, [[0]])
    assert find_changed_components(evidence, candidates, 0, NONE) == {}


def test_columns_that_are_alike_do_not_begin_with_large_numbers_that_cancel():
    """The difference of both would explain all; their mean explains as much as 1e-5 of their energy leaves."""
    rng = np.random.default_rng(1)
    same, own = rng.normal(size=(2, *ROWS))
    columns = [{FIRST: 100 * same}, {FIRST: 100 * same + 0.1 * own}]
    evidence, candidates = problem(columns, {FIRST: 200 * same + 5 * own}, [[0, 1]])
    found = _fit_linearly(evidence, candidates, 0, NONE)
    assert np.abs(found).max() < 2.5
    assert found.sum() == pytest.approx(2.0, rel=0.01)


def test_columns_that_differ_begin_with_what_they_are():
    rng = np.random.default_rng(2)
    a, b = rng.normal(size=(2, *ROWS))
    evidence, candidates = problem([{FIRST: 50 * a}, {FIRST: 50 * b}], {FIRST: 100 * a - 150 * b}, [[0, 1]])
    np.testing.assert_allclose(_fit_linearly(evidence, candidates, 0, NONE), [2.0, -3.0], rtol=1e-3)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("bound", "most"), [(4.0, (1 / 0.3 - 0.4) ** 2), (np.inf, 0.0)])
def test_calibration_hides_no_more_of_an_effect_than_its_bounds_allow(bound, most, sign):
    """A backlash that gravity preloads is a shift of the tool, of which calibration makes a tenth of a step at most."""
    shift = np.ones(ROWS)
    evidence, candidates = problem([{FIRST: 0.1 * shift}, {FIRST: sign * shift}], {FIRST: shift}, [[1]])
    ends = np.array([bound, np.inf])
    candidates.priors = Priors(precision=np.array([1e-9, 1e-2]), low=-ends, high=ends)
    (found,) = _compute_largest(evidence, candidates, np.array([0]))
    assert found == pytest.approx(most * shift.size, rel=1e-3, abs=1e-3)


def test_what_calibration_cannot_imitate_is_what_the_best_of_it_leaves_at_the_largest_plausible_size():
    """Least squares over rows, with a row for each prior, gives the same; one bound holds, the other two do not."""
    rng = np.random.default_rng(4)
    rows = rng.normal(size=(2, *ROWS))
    mixed = [rows[0], rows[0] + 0.5 * rows[1]]
    own = 2.0 * rows[0] - 1.5 * rows[1] + 0.3 * rng.normal(size=ROWS)
    evidence, candidates = problem([{FIRST: each} for each in (*mixed, own)], {FIRST: own}, [[2]])
    step, precision = settings().screening.step, np.array([50.0, 200.0, 1e-2])
    low, high = np.array([-1.0, -2.0, -np.inf]), np.array([1e3, 1e3, np.inf])
    candidates.priors = Priors(precision=precision, low=low, high=high)
    design = np.vstack([np.stack([each.ravel() for each in mixed], axis=1), np.diag(np.sqrt(precision[:2]))])
    target = np.concatenate([own.ravel() / step, np.zeros(2)])
    best = optimize.lsq_linear(design, target, bounds=(low[:2], high[:2]))
    assert list(best.active_mask) == [0, -1]
    (found,) = _compute_largest(evidence, candidates, np.array([0, 1]))
    assert found == pytest.approx(2 * best.cost, rel=1e-4)


def test_calibration_that_is_sure_hides_less():
    """Half of what least squares would use it for, where its prior weighs as much as the log."""
    rows = np.ones(ROWS)
    evidence, candidates = problem([{FIRST: rows}, {FIRST: rows}], {FIRST: rows}, [[1]])
    endless = np.full(2, np.inf)
    candidates.priors = Priors(precision=np.array([float(rows.size), 1e-2]), low=-endless, high=endless)
    (found,) = _compute_largest(evidence, candidates, np.array([0]))
    assert found == pytest.approx(0.5 * rows.size / settings().screening.step ** 2)


def test_of_a_candidate_of_several_columns_the_largest_is_told():
    rows = np.random.default_rng(5).normal(size=ROWS)
    evidence, candidates = problem([{FIRST: rows}, {FIRST: 3 * rows}], {FIRST: rows}, [[0, 1], [0]])
    energy = np.sum(rows**2) / settings().screening.step ** 2
    np.testing.assert_allclose(_compute_largest(evidence, candidates, NONE), [9 * energy, energy])


def test_a_candidate_begins_with_its_linear_fit_in_units_of_its_parameters():
    rows = np.random.default_rng(6).normal(size=(2, *ROWS))
    evidence, candidates = problem([{FIRST: each} for each in rows], {FIRST: 4.0 * rows[0] + 3.0 * rows[1]}, [[1]])
    kind = EFFECTS["torque_offset"]
    column = Sensitivity(effect=kind, joint="j1", parameter="offset", shape={}, parts={})
    candidates.scale, candidates.of = np.array([7.0, 0.5]), lambda group: [column]
    found = propose_start(evidence, candidates, 0, np.array([0]), load_robot("irb4600_60_205"))
    assert (found.kind, found.joint) == (kind, "j1")
    assert float(found.values["offset"]) == pytest.approx(1.5, rel=1e-3)


def test_a_vector_begins_at_the_sums_of_its_parts():
    kind = EFFECTS["tool_frame"]
    columns = [
        Sensitivity(effect=kind, joint="", parameter="offset", part=part, shape={}, parts={}) for part in (0, 2, 2)
    ]
    found = build_hypothesis(columns, np.array([1e-4, 2e-4, -5e-4]), load_robot("irb4600_60_205"))
    np.testing.assert_allclose(found.values["offset"], [1e-4, 0.0, -3e-4])


def wave(sizes):
    """Cogging of two waves in quadrature, or of one alone, with such sizes."""
    kind = EFFECTS["cogging"]
    phases = (0.0, np.pi / 2)[: len(sizes)]
    columns = [
        Sensitivity(
            effect=kind, joint="j2", parameter="amplitude", shape={"cycles": 6.0, "phase": phase}, span=k, parts={}
        )
        for k, phase in enumerate(phases)
    ]
    return build_hypothesis(columns, np.array(sizes), load_robot("irb4600_60_205"))


def test_two_waves_in_quadrature_begin_as_one_with_amplitude_and_phase():
    found = wave([0.3, 0.4])
    assert float(found.values["amplitude"]) == pytest.approx(0.5)
    assert float(found.values["phase"]) == pytest.approx(np.arctan2(0.4, 0.3))
    assert float(found.values["cycles"]) == 6.0
    alone = wave([0.3])
    assert (float(alone.values["amplitude"]), float(alone.values["phase"])) == (0.3, 0.0)
    assert alone.source is None


def test_what_one_joint_does_to_another_begins_with_its_source():
    kind = EFFECTS["wrist_coupling"]
    (name,) = (p.name for p in kind.parameters().values() if p.per == "pair")
    column = Sensitivity(effect=kind, joint="j6", parameter=name, part=4, shape={}, parts={})
    found = build_hypothesis([column], np.array([0.01]), load_robot("irb4600_60_205"))
    assert (found.source, found.joint) == (4, "j6")
    assert float(found.values[name]) == pytest.approx(0.01)


HALVES = np.array([[40.0, 1.0, 3.0], [90.0, 2.0, 1.0], [60.0, 0.0, 0.0]])
"""Energy that three candidates remove from rows left out of a log, and of two surrogate logs."""
MOTIONS = np.array([[20.0, 1.0, 1.0], [50.0, 4.0, 1.0], [80.0, 0.0, 2.0]])


@pytest.mark.parametrize("has_motions", [True, False])
@pytest.mark.parametrize("n_logs", [3, 2, 1])
def test_candidates_stand_in_the_order_of_both_splits_and_chance_is_the_best_of_surrogates(
    monkeypatch, has_motions, n_logs
):
    monkeypatch.setattr(module, "make_half_folds", lambda blocks: "halves")
    monkeypatch.setattr(module, "make_motion_folds", lambda blocks: "motions" if has_motions else [])
    gains = {"halves": HALVES[:, :n_logs], "motions": MOTIONS[:, :n_logs]}
    monkeypatch.setattr(module, "screen", lambda equations, folds, *_: (gains[folds], None))
    monkeypatch.setattr(module, "_estimate_extreme", lambda largest: list(largest))
    equations = SimpleNamespace(blocks=None, rows=np.array([12.0, 28.0]), n_components=4)
    found = rank(equations, SimpleNamespace(groups=(), priors=None), NONE, with_most=False)
    score = 0.5 * (HALVES + (MOTIONS if has_motions else HALVES))[:, :n_logs] / 10.0
    np.testing.assert_allclose(found.score, score[:, 0])
    assert list(found.order) == [1, 2, 0]
    assert found.threshold == pytest.approx(list(score[:, 1:].max(axis=0)) if n_logs > 1 else [0.0])
    assert found.most.size == 0
    monkeypatch.setattr(module, "_compute_largest", lambda *given: np.array([50.0, 5.0, 20.0]))
    assert list(rank(equations, SimpleNamespace(groups=(), priors=None), NONE).most) == [5.0, 0.5, 2.0]


def test_a_score_is_significant_beyond_chance_alone():
    one = module.Ranking(score=np.array([2.0, 1.0]), order=np.array([0, 1]), threshold=1.0, most=np.zeros(0))
    assert [one.is_significant(i) for i in (0, 1)] == [True, False]


def test_what_spans_a_shape_begins_at_its_mean_by_sizes():
    kind, robot = EFFECTS["payload"], load_robot("irb4600_60_205")
    known = kind.parameters()
    (name,) = (name for name, p in known.items() if p.role == "span" and p.per == "vector")
    places = [np.array([0.1, 0.0, 0.0]), np.array([0.0, 0.0, 0.2])]
    columns = [Sensitivity(effect=kind, joint="", parameter="mass", shape={name: place}, parts={}) for place in places]
    found = build_hypothesis(columns, np.array([1.0, 3.0]), robot)
    assert float(found.values["mass"]) == pytest.approx(4.0)
    np.testing.assert_allclose(found.values[name], [0.025, 0.0, 0.15])
    cancelled = build_hypothesis(columns, np.array([1.0, -1.0]), robot)
    default = known[name].neutral if known[name].default is None else known[name].default
    np.testing.assert_array_equal(cancelled.values[name], np.full(3, default))


def test_overlap_is_the_share_that_both_change():
    assert compute_overlap({FIRST: 0.6, SECOND: 0.4}, {FIRST: 0.25}) == pytest.approx(0.25)
    assert compute_overlap({FIRST: 0.6, SECOND: 0.4}, {FIRST: 0.9, SECOND: 0.1}) == pytest.approx(0.7)
    assert compute_overlap({FIRST: 0.6}, {SECOND: 1.0}) == 0.0


def test_a_share_begins_within_what_is_plausible_and_a_torque_within_what_is_possible():
    robot = load_robot("irb4600_60_205")
    for name, size in (("load_friction", "share"), ("asymmetry", None), ("torque_offset", "offset")):
        kind = EFFECTS[name]
        p = kind.parameters()[size or next(iter(kind.parameters()))]
        column = Sensitivity(effect=kind, joint="j1", parameter=p.name, shape={}, parts={})
        found = build_hypothesis([column], np.array([1e3 * p.high]), robot)
        assert float(found.values[p.name]) == (p.high if p.unit == "1" else min(p.maximum, 1e3 * p.high))
        lowest = build_hypothesis([column], np.array([-1e3 * p.high]), robot)
        assert float(lowest.values[p.name]) == (p.low if p.unit == "1" else max(p.minimum, -1e3 * p.high))


@pytest.mark.parametrize(("name", "one_sided"), [("backlash", True), ("coulomb_level", False)])
def test_what_cannot_be_negative_is_a_candidate_of_one_side(name, one_sided):
    kind = EFFECTS[name]
    p = next(p for p in kind.parameters().values() if p.role == "size")
    assert (p.minimum == p.null) == one_sided
    empty = np.zeros(0)
    none = Candidates(
        nuisances=(),
        columns=(),
        groups=(),
        scale=empty,
        priors=Priors(precision=empty, low=empty, high=empty),
        design=SimpleNamespace(beside=lambda rows, scale: None),
    )
    column = Sensitivity(effect=kind, joint="j1", parameter=p.name, shape={}, parts={})
    (group,) = none.beside([column]).groups
    assert (group.one_sided, list(group.columns)) == (one_sided, [0])
