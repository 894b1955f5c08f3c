"""What a search comes to, in a verdict and a sentence, and rivals that a log cannot rule out."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.result import Pattern, UnjudgedEffect
from ffgym.diagnosis.search import rivals
from ffgym.diagnosis.search.rivals import _compute_inexactness, _is_tied
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.verdict import (
    ReasonedVerdict,
    _is_explained,
    describe_explained,
    list_blind_rivals,
    name_shapes_at_limit,
    select_reported,
    weaken_for_blind_rivals,
    write_sentence,
)
from ffgym.effects import EFFECTS
from tests.diagnosis.result_samples import full_diagnosis, neutral_hypothesis

KEY = ("torque", 0)


def tried(left, numbers):
    """Something that was fitted: energy left in each block, and how many numbers it took."""
    hypothesis = SimpleNamespace(list_free=lambda: [None] * numbers)
    left = np.asarray(left, dtype=float)
    return SimpleNamespace(rss_by_block=left, rss=float(left.sum()), fit=SimpleNamespace(hypotheses=[hypothesis]))


def is_tied(best, other, *, numbers=(1, 1)):
    before = tried(np.full(100, 100.0), 0)
    return _is_tied(None, before, tried(best, numbers[0]), tried(other, numbers[1]), np.random.default_rng(0))


def test_a_rival_that_is_better_in_half_of_all_blocks_ties(monkeypatch):
    monkeypatch.setattr(rivals, "_compute_inexactness", lambda setting, best: 0.0)
    noise = np.random.default_rng(1).normal(size=100)
    assert is_tied(np.full(100, 10.0), 10.0 + 5 * noise, numbers=(1, 5))
    assert not is_tied(np.full(100, 10.0), 20.0 + 5 * noise)
    worse = 10.0 + 5 * (noise - noise.mean()) / noise.std() + 1.1  # by 2.2 standard deviations of the sum
    assert not is_tied(np.full(100, 10.0), worse, numbers=(1, 5))


@pytest.mark.parametrize(("more", "numbers", "ties"), [(1.7, (2, 1), True), (1.7, (1, 2), False), (2.1, (2, 1), False)])
def test_a_rival_with_no_more_numbers_ties_if_an_inexact_equation_would_leave_as_much(more, numbers, ties):
    """Both leave the same more in every block, so that resamples are sure; 90 were to be explained in each."""
    assert is_tied(np.full(100, 10.0), np.full(100, 10.0 + more), numbers=numbers) == ties


@pytest.mark.parametrize(("inexact", "ties"), [(99.0, False), (101.0, True)])
def test_a_rival_with_as_many_numbers_ties_if_the_best_leaves_as_much_above_the_noise(monkeypatch, inexact, ties):
    """It leaves 100 more of 9000; as a gear that errs beside a resolver, of which one leaves nothing but noise."""
    monkeypatch.setattr(rivals, "_compute_inexactness", lambda setting, best: inexact)
    assert is_tied(np.full(100, 10.0), np.full(100, 11.0), numbers=(3, 3)) == ties
    assert is_tied(np.full(100, 10.0), np.full(100, 11.0), numbers=(3, 2))
    assert not is_tied(np.full(100, 10.0), np.full(100, 13.0), numbers=(3, 3))


@pytest.mark.parametrize(
    ("loud", "open_share"), [(0.4, settings().rivals.unsure_floor), (1.0, settings().rivals.unsure_floor), (1.5, 0.5)]
)
def test_equations_are_as_inexact_as_what_the_best_leaves_where_it_acts(monkeypatch, loud, open_share):
    weights = {KEY: np.array([[1.0, 0.0], [2.0, 1.0]]), ("tool", 2): np.ones((2, 2))}
    setting = SimpleNamespace(weights=weights, blocks=SimpleNamespace(of_row=np.zeros((2, 2))))
    monkeypatch.setattr(rivals, "subtract_nuisances", lambda setting, fit: {})
    monkeypatch.setattr(rivals, "loudness", lambda setting, rest: {KEY: loud, ("tool", 2): 50.0})
    best = SimpleNamespace(fit=SimpleNamespace(columns=({KEY: np.ones((2, 2))},)))
    assert _compute_inexactness(setting, best) == pytest.approx(3 * open_share)


@pytest.mark.parametrize(
    ("before", "after", "explained"),
    [
        (3.0, settings().significance.quiet - 0.1, True),
        (3.0, settings().significance.quiet + 0.1, False),
        (101.0, 10.0, True),
        (101.0, 12.0, False),
    ],
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
    assert name_shapes_at_limit(setting, fit) == ((f"time of {hypothesis.label}",) if found else ())


def test_a_shape_that_stays_where_it_usually_is_is_not_at_the_end_of_its_range(one_axis):
    kind = EFFECTS["temperature_friction"]
    values = {name: np.array(p.neutral if p.default is None else p.default) for name, p in kind.parameters().items()}
    assert float(values["reference"]) == kind.parameters()["reference"].low
    hypothesis = Hypothesis(kind=kind, joint=one_axis.joints[0], source=None, values=values)
    rows = np.ones((50, 2))
    fit = SimpleNamespace(hypotheses=(hypothesis,), columns=[{KEY: 3 * rows}] * len(hypothesis.list_free()))
    assert name_shapes_at_limit(SimpleNamespace(weights={KEY: rows}), fit) == ()


def pattern(channel, component, message, share=0.5):
    numbers = {"frequency": None, "amplitude": 0.1, "share": share}
    return Pattern(channel=channel, component=component, variable="load", kind="function", message=message, **numbers)


PATTERNS = (
    pattern("torque", "j1", "first of j1"),
    pattern("torque", "j1", "second of j1", share=0.3),
    pattern("tool", "x", "of x"),
    pattern("torque", "j2", "of j2"),
    pattern("torque", "j3", "of j3"),
)


SHARE = "80 % of the misfit in the torque of j2, on motions left out of the fit"


def sentence(verdict, *, tied=True, stretched=(), patterns=PATTERNS):
    sample = full_diagnosis()
    judged = ReasonedVerdict(verdict=verdict, gains=(0.9,), explained=0.8, shapes_at_limit=stretched)
    rivals = [rival for rival in sample.rivals if tied or not rival.tied]
    return write_sentence(judged, sample.causes, rivals, patterns, SimpleNamespace(name="arm"), SHARE, sample.levels)


def test_beside_sure_causes_those_that_tie_are_told_and_what_each_of_some_components_depends_on():
    found = sentence("partly")
    assert found.startswith(
        "Partly explained by Friction that grows with load of j2: 80 % of the misfit in the torque of j2, on motions"
    )
    assert "; beyond that, payload would explain more; what is left then depends on: first of j1; of x; of j2." in found
    assert "second of j1" not in found
    assert "of j3" not in found


def test_the_verdict_states_the_share_of_the_table_and_on_which_data_the_causes_explain_it():
    sample = full_diagnosis()
    judged = ReasonedVerdict(verdict="named", gains=(0.9,), explained=0.5, shapes_at_limit=())
    assert describe_explained(judged, sample.causes, sample.levels, 2) == (
        "100 % of the misfit in the torque of j2, on motions left out of the fit"
    )
    assert "j2, on the half of the log left out" in describe_explained(judged, sample.causes, sample.levels, 1)
    assert describe_explained(judged, sample.causes, (), 2) == "50 % of the misfit, on the rows that were fitted"
    named = write_sentence(judged, sample.causes, (), (), SimpleNamespace(name="arm"), SHARE, sample.levels)
    assert named == f"Consistent with Friction that grows with load of j2, which explains {SHARE}."


def test_nothing_is_said_to_be_left_where_those_that_tie_would_leave_nothing():
    assert sentence("partly", patterns=()).endswith("; beyond that, payload would explain more.")
    assert sentence("partly", patterns=(), tied=False).endswith(", and something is left in the tool position.")


def test_a_rival_that_the_log_cannot_tell_from_a_cause_is_told_beside_it():
    sample = full_diagnosis()
    (cause,), (payload, *_) = sample.causes, sample.rivals
    judged = ReasonedVerdict(verdict="partly", gains=(0.9,), explained=0.8, shapes_at_limit=())
    found = write_sentence(
        judged, [cause], [replace(payload, against=cause.label)], (), SimpleNamespace(name="arm"), SHARE, sample.levels
    )
    assert "Friction that grows with load of j2 (these logs cannot tell it from payload): 80 % of the misfit" in found
    assert "beyond that" not in found


def test_a_rival_that_lost_is_not_told():
    assert "beyond that" not in sentence("partly", tied=False)
    assert "torque constant" not in sentence("ambiguous")


def test_a_shape_at_the_end_of_its_range_is_what_matters_most():
    found = sentence("partly", stretched=("time of dwell_stiction on j1",))
    assert "time of dwell_stiction on j1 is at the end of what is plausible: it may stand for something else" in found


@pytest.mark.parametrize(
    ("patterns", "told"), [(PATTERNS, "first of j1; of x; of j2."), ((), "nothing that was looked for.")]
)
def test_what_nobody_knows_is_described_by_what_it_depends_on(patterns, told):
    assert sentence("unknown", patterns=patterns).endswith(f"what is left depends on: {told}")


def test_an_effect_in_several_waves_is_told_once():
    sample = full_diagnosis()
    (cause, *_), (tied, *_) = sample.causes, [rival for rival in sample.rivals if rival.tied]
    judged = ReasonedVerdict(verdict="ambiguous", gains=(0.9, 0.8), explained=0.8, shapes_at_limit=())
    found = write_sentence(judged, [cause, cause], [tied, tied], (), SimpleNamespace(name="arm"), SHARE, sample.levels)
    assert found.startswith("Consistent with Friction that grows with load of j2 in 2 waves; but payload would explain")


def test_patterns_of_one_component_that_explain_as_much_stand_together():
    patterns = (
        pattern("torque", "j1", "first"),
        pattern("torque", "j1", "near", share=0.48),
        pattern("torque", "j1", "weak", share=0.2),
    )
    assert sentence("unknown", patterns=patterns).endswith("what is left depends on: first; near.")


NO_TEMPERATURE = UnjudgedEffect(effect="temperature_friction", joint="", reason="the log has no temperature")
NO_TOOL = UnjudgedEffect(effect="joint_zeros", joint="", reason="the log has no tracked tool position")


@pytest.mark.parametrize("name", ["viscous_drift", "coulomb_drift"])
def test_a_drift_may_be_one_of_temperature_where_nobody_measured_it(name):
    (rival,) = list_blind_rivals(
        [neutral_hypothesis(name), neutral_hypothesis("coulomb_level")], [NO_TOOL, NO_TEMPERATURE]
    )
    assert (rival.effect, rival.joint, rival.tied) == ("temperature_friction", "j2", True)
    assert rival.against == neutral_hypothesis(name).label
    assert "no temperature" in rival.reason


def test_where_all_is_measured_or_nothing_drifts_there_is_no_such_rival():
    assert not list_blind_rivals([neutral_hypothesis("viscous_drift")], [NO_TOOL])
    assert not list_blind_rivals([neutral_hypothesis("coulomb_level")], [NO_TEMPERATURE])


def test_friction_behind_the_elasticity_has_a_rival_where_nothing_sees_the_arm():
    causes = [neutral_hypothesis("arm_friction"), neutral_hypothesis("coulomb_level")]
    (rival,) = list_blind_rivals(causes, [NO_TOOL], sees_arm=False)
    assert (rival.effect, rival.against) == ("presliding", causes[0].label)
    assert "neither a tracked tool position nor encoders" in rival.reason
    assert not list_blind_rivals(causes, [])


@pytest.mark.parametrize(
    ("verdict", "drifts", "becomes"),
    [("named", True, "ambiguous"), ("named", False, "named"), ("partly", True, "partly")],
)
def test_nothing_that_may_be_temperature_is_named_without_reserve(verdict, drifts, becomes):
    judged = ReasonedVerdict(verdict=verdict, gains=(1.0,), explained=1.0, shapes_at_limit=())
    rivals = list_blind_rivals([neutral_hypothesis("viscous_drift")], [NO_TEMPERATURE] if drifts else [])
    assert weaken_for_blind_rivals(judged, rivals).verdict == becomes


@pytest.mark.parametrize(
    ("verdict", "is_told"), [("ambiguous", True), ("partly", True), ("unknown", False), ("none", False)]
)
def test_such_rivals_are_told_beside_causes_and_nowhere_else(verdict, is_told):
    judged = ReasonedVerdict(verdict=verdict, gains=(1.0,), explained=1.0, shapes_at_limit=())
    rivals = list_blind_rivals([neutral_hypothesis("viscous_drift")], [NO_TEMPERATURE])
    assert bool(select_reported(judged, rivals)) == is_told
