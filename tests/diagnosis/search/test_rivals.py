"""Who rivals a cause: what explains the same; who ties, and what is named then."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.result import Rival
from ffgym.diagnosis.search import rivals as module
from ffgym.diagnosis.search.rivals import (
    compare_rivals,
    find_lookalikes,
    list_uncompared,
    select_tied,
    turn_into_rivals,
)
from ffgym.diagnosis.search.rounds import SearchRound, find_adoption
from ffgym.diagnosis.settings import settings
from ffgym.effects import EFFECTS

BLOCKS = 100


def hypothesis(name, joint, cycles=None):
    values = {p.name: np.array(p.high) for p in EFFECTS[name].parameters().values()}
    if cycles is not None:
        values["cycles"] = np.array(cycles)
    return Hypothesis(kind=EFFECTS[name], joint=joint, source=None, values=values)


def tried(name, joint, left, removes, cycles=None, beside=()):
    """A fitted candidate: energy left per block, and what it removes of each component."""
    one = hypothesis(name, joint, cycles)
    fit = SimpleNamespace(hypotheses=(*beside, one), columns=[{}] * len(one.list_free()), removes=removes)
    rows = np.full(BLOCKS, left)
    return SimpleNamespace(hypothesis=one, fit=fit, rss_by_block=rows, rss=float(rows.sum()))


@pytest.fixture
def judge(monkeypatch):
    """Loudness, components and gains are those that candidates were made with; further fits are as told.

    Equations are as inexact as is allowed for.
    """
    monkeypatch.setattr(module, "subtract_nuisances", lambda setting, fit: fit)
    monkeypatch.setattr(module, "loudness", lambda setting, fit: {k: 11.0 - fit.removes.get(k, 0.0) for k in "ab"})
    monkeypatch.setattr(module, "find_touched", lambda setting, columns: {"a"})
    monkeypatch.setattr(module, "compute_explained_by_newest", lambda *found: SimpleNamespace(of_excess=0.5))
    monkeypatch.setattr(module, "_compute_inexactness", lambda setting, best: np.inf)
    again = {}
    monkeypatch.setattr(module, "fit_and_score", lambda setting, hypotheses, like: again[hypotheses[-1].kind.name])
    return again


def judged(best, others, fitted=None):
    found, one = comparison(best, others, fitted)
    return found.rivals, one


def comparison(best, others, fitted=None):
    before = SimpleNamespace(rss_by_block=np.full(BLOCKS, 100.0), rss=100.0 * BLOCKS, fit=SimpleNamespace(removes={}))
    one = SearchRound(adopted=True, ranking=None, before=before, tried=(best, *others))
    fitted = fitted or best
    return compare_rivals(None, before, fitted, [one], np.random.default_rng(0)), one


TWICE, ONCE = (("kinematic_error", "resolver_ripple"), 2.0), (("resolver_ripple", "kinematic_error"), 1.0)
"""Two waves of a shaft, and what explains each: what was adopted, and its rival."""


def two_waves(judge, swapped):
    """Both waves of j1, adopted as another effect each; with the rival of one instead, they leave `swapped`."""
    before = SimpleNamespace(rss_by_block=np.full(BLOCKS, 100.0), rss=100.0 * BLOCKS, fit=SimpleNamespace(removes={}))
    rounds, causes = [], ()
    for (name, rival), cycles in (TWICE, ONCE):
        best, other = (tried(n, "j1", 10.0, {"a": 9.0}, cycles, causes) for n in (name, rival))
        rounds.append(SearchRound(adopted=True, ranking=None, before=before, tried=(best, other)))
        judge[rival] = tried(rival, "j1", swapped[rival], {"a": 9.0}, cycles)
        causes = best.fit.hypotheses
    for name, cycles, beside in (("resolver_ripple", 2.0, causes[1]), ("kinematic_error", 1.0, causes[0])):
        judge[name].fit.hypotheses = (beside, hypothesis(name, "j1", cycles))
    return compare_rivals(None, before, best, rounds, np.random.default_rng(0))


def test_what_explains_as_much_of_the_same_ties(judge):
    best, other = tried("stribeck_peak", "j1", 10.0, {"a": 9.0}), tried("dwell_stiction", "j1", 10.0, {"a": 9.0})
    (rival,), one = judged(best, [other])
    assert rival.tied
    assert rival.against == "stribeck_peak on j1"
    assert select_tied([best.hypothesis], [rival]) == [best.hypothesis]
    (mirrored,) = turn_into_rivals([best.hypothesis], [rival], [one])
    assert (mirrored.effect, mirrored.joint, mirrored.against) == ("stribeck_peak", "j1", "dwell_stiction on j1")
    assert mirrored.held_out_gain == pytest.approx(0.9)


def test_what_explains_as_much_of_something_else_is_no_tie(judge):
    best, other = tried("stribeck_peak", "j1", 10.0, {"a": 9.0}), tried("stribeck_peak", "j2", 10.0, {"b": 9.0})
    (rival,), _ = judged(best, [other])
    assert not rival.tied
    assert rival.reason == "explains little of what stribeck_peak on j1 does"


@pytest.mark.parametrize(("removes", "ties"), [(4.5, True), (4.4, False)])
def test_a_rival_removes_half_of_what_the_cause_does_where_it_acts(judge, removes, ties):
    best, other = tried("stribeck_peak", "j1", 10.0, {"a": 9.0}), tried("dwell_stiction", "j1", 10.0, {"a": removes})
    (rival,), _ = judged(best, [other])
    assert settings().rivals.instead == 0.5
    assert rival.tied == ties


def test_limits_of_rivals_are_within_them(judge):
    """Half of what the cause does is enough to lose by what is left; nine tenths to be fitted again beside others."""
    best = tried("coulomb_drift", "j1", 10.0, {"a": 10.0})
    half = tried("viscous_drift", "j1", 30.0, {"a": 10.0 * settings().rivals.instead})
    assert judged(best, [half])[0][0].reason == "leaves 3 times the energy on rows that were not used"
    near = tried("viscous_drift", "j1", 30.0, {"a": 10.0 * settings().rivals.near})
    judge["viscous_drift"] = tried("viscous_drift", "j1", 10.0, {"a": 9.0})
    fitted = tried("coulomb_drift", "j1", 10.0, {"a": 9.0}, beside=(hypothesis("torque_clock", ""),))
    assert judged(best, [near], fitted)[0][0].tied
    more, fewer = tried("stribeck_peak", "j1", 10.0, {"a": 9.0}), tried("coulomb_level", "j1", 11.8, {"a": 9.0})
    fewer.rss = 1180.0
    assert settings().rivals.alike * 90.0 * BLOCKS == fewer.rss - more.rss
    assert judged(more, [fewer])[0][0].tied


@pytest.mark.parametrize(("removes", "ties"), [(8.2, True), (8.0, False)])
def test_a_rival_that_lost_is_compared_again_if_it_removes_nearly_as_much_where_the_cause_acts(judge, removes, ties):
    best, other = tried("coulomb_drift", "j1", 10.0, {"a": 9.0}), tried("viscous_drift", "j1", 30.0, {"a": removes})
    judge["viscous_drift"] = tried("viscous_drift", "j1", 10.0, {"a": 9.0})
    fitted = tried("coulomb_drift", "j1", 10.0, {"a": 9.0})
    fitted.fit.hypotheses = (best.hypothesis, hypothesis("torque_clock", ""))
    (rival,), _ = judged(best, [other], fitted)
    assert settings().rivals.near == 0.9
    assert rival.tied == ties


def test_what_was_tried_where_nothing_was_adopted_or_of_a_cause_that_went_is_no_rival(judge):
    best, other = tried("stribeck_peak", "j1", 10.0, {"a": 9.0}), tried("dwell_stiction", "j1", 10.0, {"a": 9.0})
    third = tried("viscous_level", "j2", 10.0, {"a": 9.0})
    before = SimpleNamespace(rss_by_block=np.full(BLOCKS, 100.0), rss=100.0 * BLOCKS, fit=SimpleNamespace(removes={}))
    for adopted, fitted, count in ((True, best, 1), (False, best, 0), (True, third, 0)):
        one = SearchRound(adopted=adopted, ranking=None, before=before, tried=(best, other))
        found = compare_rivals(None, before, fitted, [one], np.random.default_rng(0))
        assert len(found.rivals) == count


def test_of_better_explanations_the_one_that_leaves_least_takes_the_place(judge):
    best = tried("coulomb_level", "j1", 10.0, {"a": 6.0})
    others = [tried(name, "j1", left, {"a": 6.0}) for name, left in (("viscous_level", 9.0), ("load_friction", 8.0))]
    assert [len(one.hypothesis.list_free()) for one in (best, *others)] == [1, 1, 1]
    assert comparison(best, others)[0].better is others[1]


@pytest.mark.parametrize(("more", "ties"), [(0.0, True), (1e-9, False)])
def test_a_rival_of_more_numbers_ties_only_if_it_leaves_no_more(judge, more, ties):
    """However inexact equations are: with more numbers it should leave less."""
    best = tried("coulomb_level", "j1", 10.0, {"a": 9.0})
    other = tried("stribeck_peak", "j1", 10.0 + more, {"a": 9.0})
    assert len(other.hypothesis.list_free()) > len(best.hypothesis.list_free())
    assert judged(best, [other])[0][0].tied == ties


@pytest.mark.parametrize(
    ("swapped", "inexactness", "more", "ties"),
    [
        (False, np.inf, 0.99, True),
        (False, np.inf, 1.01, False),
        (False, 0.5, 0.49, True),
        (False, 0.5, 0.51, False),
        (True, 0.5, 0.99, True),  # with fewer numbers it may leave a share of all
        (True, 0.5, 1.01, False),
    ],
)
def test_a_rival_may_leave_a_little_more_as_no_equation_is_exact(monkeypatch, judge, swapped, inexactness, more, ties):
    """Of what the cause removes, a share; with as many numbers no more than the cause leaves above noise, if less."""
    share = settings().rivals.alike * 90.0
    monkeypatch.setattr(module, "_compute_inexactness", lambda setting, best: inexactness * share * BLOCKS)
    name = "stribeck_peak" if swapped else "viscous_level"
    best = tried(name, "j1", 10.0, {"a": 9.0})
    other = tried("coulomb_level", "j1", 10.0 + more * share, {"a": 9.0})
    assert judged(best, [other])[0][0].tied == ties


def test_what_an_explanation_leaves_above_noise_counts_for_each_row_where_it_acts(monkeypatch):
    """With half of the rows of one component without weight; the floor is as unsure where nothing is above it."""
    floor = settings().rivals.unsure_floor
    blocks = SimpleNamespace(of_row=np.zeros((50, 2), dtype=int))
    weights = {"a": np.array([1.0, 0.0]), "b": np.full((50, 2), 3.0), "c": np.array([1.0, 1.0])}
    monkeypatch.setattr(module, "subtract_nuisances", lambda setting, fit: None)
    monkeypatch.setattr(module, "loudness", lambda setting, rest: {"a": 3.5, "b": 1.0 + floor / 2, "c": 9.0})
    monkeypatch.setattr(module, "find_touched", lambda setting, columns: {"a", "b"})
    best = SimpleNamespace(fit=SimpleNamespace(columns=()))
    found = module._compute_inexactness(SimpleNamespace(blocks=blocks, weights=weights), best)
    assert found == pytest.approx(2.5 * 50 + floor * 100)


def test_a_rival_is_judged_where_the_newest_numbers_of_the_best_act(monkeypatch, judge):
    asked = []
    monkeypatch.setattr(module, "find_touched", lambda setting, columns: asked.append(columns) or {"a"})
    best = tried("stribeck_peak", "j1", 10.0, {"a": 9.0})
    n = len(best.hypothesis.list_free())
    best.fit.columns = [{"k": k} for k in range(n + 5)]
    judged(best, [tried("dwell_stiction", "j1", 10.0, {"a": 9.0})])
    assert asked == [best.fit.columns[5:]]


def test_what_leaves_less_but_explains_something_else_takes_no_place(judge):
    best, other = tried("coulomb_level", "j1", 10.0, {"a": 9.0}), tried("viscous_level", "j2", 9.0, {"b": 9.0})
    assert comparison(best, [other])[0].better is None


@pytest.mark.parametrize("gain", [0.0, -1.0])
def test_beside_a_cause_that_removes_nothing_where_it_acts_any_gain_is_as_much(judge, gain):
    best, other = tried("stribeck_peak", "j1", 10.0, {"a": gain}), tried("dwell_stiction", "j1", 10.0, {"a": 1.0})
    assert judged(best, [other])[0][0].tied


def test_a_rival_that_was_fitted_beside_others_takes_no_place_by_its_first_fit(judge):
    """It ties, and no other cause stayed: how it does alone is not known."""
    best, other = tried("coulomb_level", "j1", 10.0, {"a": 9.0}), tried("viscous_level", "j1", 9.0, {"a": 9.0})
    other.fit.hypotheses = (hypothesis("torque_clock", ""), other.hypothesis)
    found = comparison(best, [other])[0]
    assert (found.rivals[0].tied, found.better) == (True, None)
    other.fit.hypotheses = (other.hypothesis,)
    assert comparison(best, [other])[0].better is other


def test_a_cause_that_was_dropped_is_a_rival_of_the_one_that_ties_with_it():
    """Rivals that do not tie, and those of other causes, say nothing of it."""
    one = hypothesis("viscous_level", "j1")
    rivals = [
        Rival(effect=effect, joint="j2", held_out_gain=0.5, tied=tied, against=against, reason="")
        for effect, tied, against in (
            ("coulomb_level", True, one.label),
            ("cogging", False, one.label),
            ("backlash", True, "payload"),
        )
    ]
    best = tried("viscous_level", "j1", 30.0, {})
    before = SimpleNamespace(rss=100.0 * BLOCKS)
    rounds = [SearchRound(adopted=True, ranking=None, before=before, tried=(best,))]
    (found,) = turn_into_rivals([one], rivals, rounds)
    assert (found.effect, found.joint, found.against, found.tied) == (
        *("viscous_level", "j1", "coulomb_level on j2"),
        True,
    )
    assert found.held_out_gain == pytest.approx(0.7)


def test_a_rival_of_more_numbers_takes_no_place_however_little_it_leaves(judge):
    best, other = tried("coulomb_level", "j1", 10.0, {"a": 9.0}), tried("cogging", "j1", 9.9, {"a": 9.0})
    assert len(other.hypothesis.list_free()) > len(best.hypothesis.list_free())
    assert comparison(best, [other])[0].better is None
    assert comparison(other, [best])[0].rivals[0].tied


def test_a_rival_that_leaves_as_much_takes_no_place(judge):
    best, other = tried("stribeck_peak", "j1", 10.0, {"a": 9.0}), tried("dwell_stiction", "j1", 10.0, {"a": 9.0})
    best.fit.hypotheses = other.fit.hypotheses = (best.hypothesis,)
    assert comparison(best, [other])[0].better is None


def test_lookalikes_are_listed_of_causes_that_were_compared_with_nothing():
    def alike(effect, against):
        return Rival(effect=effect, joint="j1", held_out_gain=0.1, tied=False, against=against, reason="less")

    one, other = hypothesis("viscous_level", "j1"), hypothesis("coulomb_level", "j1")
    final = SimpleNamespace(fit=SimpleNamespace(hypotheses=(one, other)))
    listed = [alike("stribeck_peak", one.label), alike("coulomb_level", one.label), alike("cogging", "payload")]
    compared = [alike("dwell_stiction", other.label), alike("load_friction", other.label)]
    rounds = tuple(SimpleNamespace(alike=(each,)) for each in (*listed, compared[1]))
    assert list_uncompared(rounds, final, (compared[0],)) == (listed[0],)


def test_what_leaves_more_says_how_much_more(judge):
    best, other = tried("stribeck_peak", "j1", 10.0, {"a": 9.0}), tried("stribeck_peak", "j2", 25.0, {"a": 8.0})
    (rival,), _ = judged(best, [other])
    assert not rival.tied
    assert rival.reason == "leaves 2.5 times the energy on rows that were not used"


def test_the_general_form_of_a_cause_that_explains_no_more_is_no_tie(judge):
    best, other = tried("stribeck_peak", "j1", 10.0, {"a": 9.0}), tried("falling_friction", "j1", 10.0, {"a": 9.0})
    (rival,), _ = judged(best, [other])
    assert not rival.tied
    (rival,), _ = judged(other, [best])
    assert rival.tied


def test_what_was_adopted_beside_a_cause_is_no_rival_of_it(judge):
    best, other = tried("viscous_level", "j1", 10.0, {"a": 9.0}), tried("torque_clock", "", 10.0, {"a": 9.0})
    fitted = SimpleNamespace(fit=SimpleNamespace(hypotheses=(best.hypothesis, other.hypothesis)))
    found, _ = judged(best, [other], fitted)
    assert found == ()


@pytest.mark.parametrize(("then", "ties"), [(10.0, True), (60.0, False)])
def test_a_rival_that_was_led_astray_is_compared_again_beside_the_other_causes(judge, then, ties):
    """Alone it leaves more on other rows, but removes as much where the cause acts."""
    best, other = tried("coulomb_drift", "j1", 10.0, {"a": 6.0}), tried("viscous_drift", "j1", 30.0, {"a": 6.0})
    judge["viscous_drift"] = tried("viscous_drift", "j1", then, {"a": 6.0})
    beside = hypothesis("torque_clock", "")
    fitted = tried("coulomb_drift", "j1", 10.0, {"a": 6.0})
    fitted.fit.hypotheses = (best.hypothesis, beside)
    (rival,), _ = judged(best, [other], fitted)
    assert rival.tied == ties


def test_causes_that_no_rival_ties_with_are_sure():
    rival = Rival(effect="b", joint="j1", held_out_gain=0.5, tied=False, against="viscous_level on j1", reason="lost")
    assert select_tied([hypothesis("viscous_level", "j1")], [rival]) == []


def test_a_cause_gives_way_to_a_rival_that_explains_more_beside_what_came_later(judge):
    found = two_waves(judge, {"resolver_ripple": 9.9, "kinematic_error": 10.1})
    assert [h.label for h in found.better.fit.hypotheses] == ["resolver_ripple on j1"] * 2


@pytest.mark.parametrize(("then", "gives_way"), [(9.0, True), (11.0, False)])
def test_a_cause_gives_way_to_another_effect_that_leaves_less_beside_what_came_later(judge, then, gives_way):
    best, other = tried("coulomb_level", "j1", 10.0, {"a": 6.0}), tried("viscous_level", "j1", 30.0, {"a": 6.0})
    beside = hypothesis("torque_clock", "")
    judge["viscous_level"] = tried("viscous_level", "j1", then, {"a": 6.0}, beside=(beside,))
    fitted = tried("coulomb_level", "j1", 10.0, {"a": 6.0})
    fitted.fit.hypotheses = (best.hypothesis, beside)
    before = SimpleNamespace(rss_by_block=np.full(BLOCKS, 100.0), rss=100.0 * BLOCKS, fit=SimpleNamespace(removes={}))
    one = SearchRound(adopted=True, ranking=None, before=before, tried=(best, other))
    better = compare_rivals(None, before, fitted, [one], np.random.default_rng(0)).better
    assert (better is not None) == gives_way


def test_of_explanations_that_tie_the_one_of_fewer_effects_stands(judge):
    found = two_waves(judge, {"resolver_ripple": 10.1, "kinematic_error": 90.0})
    assert [h.label for h in found.better.fit.hypotheses] == ["resolver_ripple on j1"] * 2


def test_nothing_gives_way_to_what_explains_less(judge):
    assert two_waves(judge, {"resolver_ripple": 90.0, "kinematic_error": 90.0}).better is None


@pytest.mark.parametrize(("second", "ties"), [(90.0, False), (10.0, True)])
def test_a_wave_of_a_cause_of_which_another_wave_is_sure_ties_with_nothing(judge, second, ties):
    """Both waves are of the resolver, and a gear error explains the first as well; and the second?"""
    before = SimpleNamespace(rss_by_block=np.full(BLOCKS, 100.0), rss=100.0 * BLOCKS, fit=SimpleNamespace(removes={}))
    one, two = (tried("resolver_ripple", "j1", 10.0, {"a": 9.0}, cycles) for cycles in (1.0, 2.0))
    two.fit.hypotheses = (one.hypothesis, two.hypothesis)
    lefts, rounds = {1.0: 10.0, 2.0: second}, []
    for best, cycles in ((one, 1.0), (two, 2.0)):
        other = tried("kinematic_error", "j1", lefts[cycles], {"a": 9.0}, cycles)
        rounds.append(SearchRound(adopted=True, ranking=None, before=before, tried=(best, other)))
    again = {cycles: tried("kinematic_error", "j1", left, {"a": 9.0}, cycles) for cycles, left in lefts.items()}
    module.fit_and_score = lambda setting, hypotheses, like: again[float(hypotheses[-1].values["cycles"])]
    rivals = compare_rivals(None, before, two, rounds, np.random.default_rng(0)).rivals
    assert [rival.tied for rival in rivals] == [ties, ties]
    assert select_tied(two.fit.hypotheses, rivals) == (list(two.fit.hypotheses) if ties else [])


def test_of_explanations_that_tie_the_plausible_one_stands(judge):
    """A spring of 100 N m/rad is none of cables, though their equation has one."""
    cables, spring = (tried(name, "j1", 10.0, {"a": 9.0}) for name in ("cable_pull", "gravity_term"))
    (rival,), _ = judged(spring, [cables])
    assert rival.tied
    cables.hypothesis.values["stiffness"] = np.array(100.0)
    (rival,), _ = judged(spring, [cables])
    assert not rival.tied
    assert rival.reason == "explains as much, but would take a stiffness of 100 N m/rad, where 0 to 30 is plausible"
    assert comparison(cables, [spring])[0].better is spring
    spring.hypothesis.values["stiffness"] = np.array(5800.0)
    assert comparison(cables, [spring])[0].better is None
    assert judged(cables, [spring])[0][0].tied


def test_a_rival_beside_which_another_cause_must_be_too_large_says_which_that_is(judge):
    """Not a size of the rival itself: it is told whose."""
    beside, larger = hypothesis("viscous_level", "j2"), hypothesis("viscous_level", "j2")
    larger.values["change"] = np.array(50.0)
    best = tried("gravity_term", "j1", 10.0, {"a": 9.0}, beside=(beside,))
    other = tried("cable_pull", "j1", 10.0, {"a": 9.0}, beside=(beside,))
    judge["cable_pull"] = tried("cable_pull", "j1", 10.0, {"a": 9.0}, beside=(larger,))
    (rival,), _ = judged(best, [other])
    assert not rival.tied
    assert rival.reason.startswith("explains as much, but would take a change of 50")
    assert rival.reason.endswith(" of viscous_level on j2")


@pytest.mark.parametrize(("cycles", "found"), [(2.1, 1), (1.0, 0), (3.5, 0)])
def test_a_cause_is_found_in_the_round_of_its_wave_however_far_that_moved(cycles, found):
    """A wave that no round tried so is taken for the first of its effect."""
    tries = [tried("cogging", "j1", 10.0, {}, wave) for wave in (1.0, 2.0)]
    rounds = [SearchRound(adopted=True, ranking=None, before=None, tried=(one,)) for one in tries]
    assert find_adoption(rounds, hypothesis("cogging", "j1", cycles)) == (rounds[found], tries[found])


def lookalikes(monkeypatch, scores):
    """Rivals by the list of confusable effects, of candidates with scores, for Stribeck friction of j1."""
    monkeypatch.setattr(module, "compute_explained_by_newest", lambda *found: SimpleNamespace(of_excess=0.6))
    columns = [SimpleNamespace(effect=EFFECTS[name], joint=joint) for name, joint in scores]
    candidates = SimpleNamespace(groups=range(len(columns)), first=lambda group: columns[group])
    score = np.array(list(scores.values()))
    ranking = SimpleNamespace(order=np.argsort(-score), score=score)
    adopted = SimpleNamespace(hypothesis=hypothesis("stribeck_peak", "j1"))
    return find_lookalikes(None, candidates, ranking, None, adopted)


def test_what_is_known_to_look_alike_on_the_same_joint_is_told_with_its_share(monkeypatch):
    kind = EFFECTS["stribeck_peak"]
    like = next(name for name, one in EFFECTS.items() if one.code in kind.confusable_with)
    unlike = next(name for name, one in EFFECTS.items() if one.code not in (kind.code, *kind.confusable_with))
    scores = {("stribeck_peak", "j1"): 8.0, (like, "j1"): 6.0, (like, "j2"): 7.0, (unlike, "j1"): 7.5}
    (rival,) = lookalikes(monkeypatch, scores)
    assert (rival.effect, rival.joint, rival.tied) == (like, "j1", False)
    assert rival.held_out_gain == pytest.approx(0.45)
    assert rival.reason == "explains 75% of what stribeck_peak on j1 does, on rows that were not used"
    assert lookalikes(monkeypatch, {("stribeck_peak", "j1"): 0.0, (like, "j1"): -1.0}) == ()
    assert lookalikes(monkeypatch, {(like, "j1"): 5.0}) == ()
    (silent,) = lookalikes(monkeypatch, {("stribeck_peak", "j1"): 1e-3, (like, "j1"): -1.0})
    assert silent.held_out_gain == 0.0
