"""What a round of the search tries."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.search import search as module
from ffgym.diagnosis.search.rounds import SearchRound
from ffgym.diagnosis.settings import settings
from ffgym.effects import EFFECTS


def cogging(joint, cycles):
    values = {"amplitude": np.array(0.01), "cycles": np.array(cycles), "phase": np.array(0.0)}
    return Hypothesis(kind=EFFECTS["cogging"], joint=joint, source=None, values=values)


def sized(name, joint):
    """A cause with a single size."""
    kind = EFFECTS[name]
    return Hypothesis(
        kind=kind, joint=joint, source=None, values={n: np.array(p.high) for n, p in kind.parameters().items()}
    )


@pytest.fixture
def fit_best(monkeypatch):
    """Fits of candidates with scores and energies left, beside causes that are there; 2 are left without them."""

    def fitted(found, *, scores=None, left=None, changed=None, there=(), needless=(), beaten=(), report=None):
        scores = np.ones(len(found)) if scores is None else np.array(scores)
        left = dict(zip((one.label for one in found), left or [1.0] * len(found), strict=True))
        ranking = SimpleNamespace(order=range(len(found)), score=scores, is_significant=lambda i: scores[i] > 0)
        known = SimpleNamespace(groups=range(len(found)), first=lambda i: found[i], nuisance_places=None)

        def fit_and_score(setting, all_of, like):
            *others, newest = all_of
            assert others == list(there)
            if left[newest.label] is None:
                raise FFGymError("no such machine")
            return SimpleNamespace(hypothesis=newest, rss=left[newest.label])

        monkeypatch.setattr(module, "find_changed_components", lambda *given: changed[given[2]] if changed else {})
        monkeypatch.setattr(module, "propose_start", lambda evidence, candidates, i, *_: found[i])
        monkeypatch.setattr(module, "_shrink_to_possible", lambda setting, others, start: start)
        monkeypatch.setattr(module, "fit_and_score", fit_and_score)
        now = SimpleNamespace(fit=SimpleNamespace(hypotheses=tuple(there)), rss=2.0)
        setting = SimpleNamespace(log=SimpleNamespace(robot=None))
        report = report or (lambda what, share: None)
        tried = module._fit_best(setting, known, ranking, None, now, needless, beaten, report)
        return [one.hypothesis for one in tried]

    return fitted


def test_a_cause_that_is_there_or_that_others_made_up_for_is_not_tried_again(fit_best):
    """Else it would come, be dropped beside the next, and come again."""
    one, other, third = cogging("j1", 3.0), cogging("j2", 1.0), cogging("j3", 3.0)
    assert fit_best([one, other, third]) == [one, other, third]
    assert fit_best([one, other, third], there=[third]) == [one, other]
    assert fit_best([one, other, third], needless=[cogging("j1", 3.05)]) == [other, third]
    assert fit_best([one, other, third], needless=[cogging("j1", 6.0)]) == [one, other, third]


def test_a_few_of_the_best_are_fitted_on_joints_where_none_was_beaten(fit_best):
    most = settings().search.tried
    many, told = [cogging(f"j{k}", 3.0) for k in range(1, most + 3)], []
    assert fit_best(many, report=lambda what, share: told.append((what, share))) == many[:most]
    assert told == [(f"fitting {one.label}", pytest.approx(k / most)) for k, one in enumerate(many[:most])]
    assert fit_best(many, beaten={"j1"}) == many[1 : most + 1]
    assert fit_best(many, left=[1.0, None, *[1.0] * most]) == [many[0], *many[2 : most + 1]]


def test_what_scores_far_less_than_the_best_or_no_more_than_chance_is_not_fitted(fit_best):
    one, other, third = cogging("j1", 3.0), cogging("j2", 1.0), cogging("j3", 3.0)
    near = settings().search.near_best
    assert fit_best([one, other, third], scores=[8.0, 8.0 * near, 7.9 * near]) == [one, other]
    assert fit_best([one, other, third], scores=[8.0, 0.0, 8.0]) == [one]
    assert fit_best([one, other, third], scores=[0.4, 0.3, 0.3]) == [one, other, third]


def test_the_same_effect_on_a_joint_is_fitted_once(fit_best):
    first, again = cogging("j1", 3.0), cogging("j1", 7.0)
    assert fit_best([first, again]) == [first]


def test_rivals_of_the_best_change_what_it_changes(fit_best):
    one, other, third = cogging("j1", 3.0), cogging("j2", 1.0), cogging("j3", 3.0)
    shared = settings().search.same_target
    changed = [{"a": 1.0}, {"a": 0.5 * shared, "b": 1 - 0.5 * shared}, {"a": shared, "b": 1 - shared}]
    assert fit_best([one, other, third], changed=changed) == [one, third]


def test_the_fit_that_leaves_least_is_first_with_a_price_of_each_number(fit_best):
    """Three numbers of a wave against one: they must remove more than their price, a share of what is explained."""
    wave, level = cogging("j1", 3.0), sized("viscous_level", "j2")
    slack = settings().search.slack
    numbers = len(wave.list_free()) - len(level.list_free())
    assert numbers >= 1
    assert fit_best([wave, level], left=[1.0, 1.0]) == [level, wave]
    assert fit_best([level, wave], left=[1.0, 1.0 - 1.2 * numbers * slack]) == [wave, level]
    assert fit_best([level, wave], left=[1.0, 1.0 - 0.8 * numbers * slack]) == [level, wave]
    # of 2 that were left, a tenth is explained: the price of a number is smaller than where half is
    assert fit_best([level, wave], left=[1.9, 1.9 - 0.2 * numbers * slack]) == [wave, level]
    assert fit_best([level, wave], left=[0.1, 0.1 - 0.2 * numbers * slack]) == [wave, level]
    # nothing is paid for what explains nothing
    assert fit_best([wave, level], left=[2.5, 2.5]) == [wave, level]
    assert fit_best([level, wave], left=[2.5, 2.5]) == [level, wave]


def test_what_ties_with_a_rival_is_explained_all_the_same(monkeypatch):
    """A quiet cause beside a loud one that ties: alone it would seem to leave nearly all where both act."""
    loud, quiet = cogging("j1", 3.0), cogging("j1", 7.0)
    model = lambda setting, kept: SimpleNamespace(fit=SimpleNamespace(hypotheses=tuple(kept)))  # noqa: E731
    monkeypatch.setattr(module, "explains_most", lambda setting, nominal, now: loud in now.fit.hypotheses)
    monkeypatch.setattr(module, "fit_and_score", model)
    monkeypatch.setattr(module, "correct_bias", lambda setting, fit: fit)
    monkeypatch.setattr(module, "score", lambda setting, fit: SimpleNamespace(fit=fit))
    nominal = model(None, ())

    told = []

    def kept_of(all_of, kept):
        report = lambda what, share: told.append((what, share))  # noqa: E731
        return module._conclude(None, nominal, model(None, all_of), kept, report).fit.hypotheses

    assert kept_of([loud, quiet], [quiet]) == (quiet,)
    assert kept_of([loud, quiet], [loud, quiet]) == (loud, quiet)
    assert kept_of([quiet], [quiet]) == ()
    assert kept_of([], []) == ()
    assert told == [("fitting all of it once more", 1.0)] * 2


def test_a_cause_of_which_nothing_is_left_once_all_is_fitted_together_is_none(monkeypatch):
    here, gone = cogging("j1", 3.0), cogging("j2", 1.0)
    model = lambda setting, kept: SimpleNamespace(fit=SimpleNamespace(hypotheses=tuple(kept)))  # noqa: E731

    def corrected(setting, fit):
        left = (h.fix_at_null("amplitude") if h.joint == "j2" else h for h in fit.hypotheses)
        return SimpleNamespace(hypotheses=tuple(left))

    monkeypatch.setattr(module, "explains_most", lambda setting, nominal, now: True)
    monkeypatch.setattr(module, "fit_and_score", model)
    monkeypatch.setattr(module, "correct_bias", corrected)
    monkeypatch.setattr(module, "score", lambda setting, fit: SimpleNamespace(fit=fit))
    nominal = model(None, ())
    for all_of, left in (((here, gone), (here,)), ((gone,), ())):
        found = module._conclude(None, nominal, model(None, all_of), all_of, lambda what, share: None)
        assert found.fit.hypotheses == left


def model(kept):
    """A fitted model of some causes."""
    equations = SimpleNamespace(rows=np.array([4.0, 3.0]))
    return SimpleNamespace(fit=SimpleNamespace(hypotheses=tuple(kept), equations=equations))


CAUSES = [cogging("j1", 3.0), cogging("j2", 1.0), cogging("j3", 3.0)]


@pytest.fixture
def searched(monkeypatch):
    """A search that finds three causes one by one, some of which tie; and how many each round had."""

    def run(most=None, tied=(), better=()):
        ranked, better = [], iter(better)

        def run_round(problem, candidates, null_residuals, nominal, now, known, report):
            n = len(now.fit.hypotheses)
            ranked.append(n)
            assert not list(known)
            adopted = n < len(CAUSES)
            return SearchRound(before=now, ranking=None, tried=(model(CAUSES[: n + 1]),) * adopted, adopted=adopted)

        for name, function in {
            "_run_round": run_round,
            "fit_and_score": lambda problem, kept: model(kept),
            "refit": lambda problem, tried: tried,
            "drop_needless": lambda problem, grown: grown,
            "compare_rivals": lambda *_: SimpleNamespace(rivals=("rival",), better=next(better, None)),
            "select_tied": lambda hypotheses, rivals: [h for h in hypotheses if h in tied],
            "turn_into_rivals": lambda unsure, rivals, rounds: tuple(h.label for h in unsure),
            "list_uncompared": lambda rounds, now, rivals: ("uncompared",),
            "_conclude": lambda problem, nominal, now, kept, report: model(kept),
        }.items():
            monkeypatch.setattr(module, name, function)
        return module.search(None, lambda fit: None, {}, None, most=most), ranked

    return run


@pytest.mark.parametrize(("most", "found"), [(1, 1), (2, 2), (5, 3), (None, 3)])
def test_no_more_causes_are_looked_for_than_asked(searched, most, found):
    result, ranked = searched(most)
    assert list(result.final.fit.hypotheses) == CAUSES[:found]
    assert ranked == list(range(found if most == found else found + 1))
    assert result.whole is result.final
    assert result.rows == 7.0


@pytest.mark.parametrize(
    ("tied", "final", "unsure"), [([], CAUSES, []), (CAUSES[:1], CAUSES[1:], CAUSES[:1]), (CAUSES, CAUSES, [])]
)
def test_causes_that_tie_are_left_out_beside_sure_ones_and_are_their_rivals(searched, tied, final, unsure):
    result, _ = searched(tied=tied)
    assert list(result.final.fit.hypotheses) == final
    assert list(result.unsure) == unsure
    assert list(result.whole.fit.hypotheses) == CAUSES
    assert result.rivals == ("rival", *(h.label for h in unsure), "uncompared")


def test_rivals_that_explain_more_take_places_as_often_as_the_search_may_exchange(searched):
    most = settings().search.exchanges
    others = [model([cogging("j4", float(k))]) for k in range(1, most + 2)]
    for n in range(most + 2):
        result, _ = searched(better=others[:n])
        assert list(result.final.fit.hypotheses) == (list(others[min(n, most) - 1].fit.hypotheses) if n else CAUSES)


def test_what_others_made_up_for_is_told_to_later_rounds(searched, monkeypatch):
    """The second cause makes up for the first, and the third for none."""
    told, before = [], [(), CAUSES[1:2], CAUSES[1:3]]
    searched()

    def run_round(problem, candidates, null_residuals, nominal, now, needless, report):
        told.append(list(needless))
        tried = [CAUSES[:1], CAUSES[:2], CAUSES[1:]][len(told) - 1] if len(told) < 4 else ()
        found = (model(tried), model([cogging("j4", 1.0)])) if len(told) < 4 else ()
        return SearchRound(before=now, ranking=None, tried=found, adopted=len(told) < 4)

    monkeypatch.setattr(module, "_run_round", run_round)
    monkeypatch.setattr(
        module,
        "drop_needless",
        lambda problem, grown: model(CAUSES[1:2]) if CAUSES[0] in grown.fit.hypotheses[:-1] else grown,
    )
    result = module.search(None, lambda fit: None, {}, None)
    assert list(result.final.fit.hypotheses) == before[2]
    assert told == [[], [], CAUSES[:1], CAUSES[:1]]


@pytest.mark.parametrize("possible", range(6))
@pytest.mark.parametrize(("name", "is_link"), [("viscous_level", False), ("arm_friction", True)])
def test_a_start_is_halved_until_a_machine_can_have_it_and_given_up_in_the_end(monkeypatch, name, is_link, possible):
    """Beyond the spring the arm must stay where it is, too: nothing else is replayed to see that."""
    start = sized(name, "j1")
    assert (start.kind.side == "link") == is_link
    tried = []

    def can_be(causes):
        tried.append(causes)
        return len(tried) > possible

    monkeypatch.setattr(module, "build_machine", lambda nominal, causes: True if is_link or can_be(causes) else None)
    monkeypatch.setattr(module, "compute_rss", lambda problem, causes: 1.0 if is_link and can_be(causes) else np.inf)
    found = module._shrink_to_possible(SimpleNamespace(nominal=None), CAUSES[:1], start)
    if possible >= module._HALVINGS:
        assert found is None
        return
    for causes, k in zip(tried, range(possible + 1), strict=True):
        assert causes[0] is CAUSES[0]
        (size, *_) = (p for p in start.kind.parameters().values() if p.role == "size")
        assert causes[1].values[size.name] == pytest.approx(start.values[size.name] * 0.5**k)
    assert found is tried[-1][1]


def test_a_start_behind_the_spring_that_no_machine_can_have_is_not_replayed(monkeypatch):
    monkeypatch.setattr(module, "build_machine", lambda nominal, causes: None)
    monkeypatch.setattr(module, "compute_rss", lambda problem, causes: 1.0)
    assert module._shrink_to_possible(SimpleNamespace(nominal=None), (), sized("arm_friction", "j1")) is None


def round_of(monkeypatch, tried, *, worthy=(), now=None, nominal=None):
    """A round in which joints are tried in turn; and what it asked the ranking."""
    asked = {}
    rows = {("torque", 0): np.zeros((4, 1, 1))}
    batches = iter([*tried, *[[]] * 9])

    def form_equations(together):
        asked["together"] = together["torque", 0]
        return SimpleNamespace(rows=np.array([6.0]), n_components=2)

    def rank(equations, candidates, places, *, with_most):
        asked["with_most"] = with_most
        return SimpleNamespace(threshold=5.0)

    monkeypatch.setattr(module, "split_components", lambda residual: residual)
    monkeypatch.setattr(module, "rank", rank)
    monkeypatch.setattr(module, "_fit_best", lambda *_: next(batches))
    monkeypatch.setattr(module, "find_lookalikes", lambda problem, candidates, ranking, before, one: (one,))
    monkeypatch.setattr(module, "is_significant", lambda problem, nominal, now, one, chance: one in worthy)
    candidates = SimpleNamespace(design=SimpleNamespace(form_equations=form_equations), nuisance_places=np.arange(0))
    now = now or SimpleNamespace(fit=SimpleNamespace(residual=rows))
    null = {("torque", 0): np.ones((4, 1, 2))}
    return module._run_round(None, candidates, null, nominal or now, now, (), None), asked


def test_the_log_comes_first_and_replays_without_fault_behind_it(monkeypatch):
    now = SimpleNamespace(fit=SimpleNamespace(residual={("torque", 0): np.full((4, 1, 1), 7.0)}))
    one, asked = round_of(monkeypatch, [], now=now)
    assert np.array_equal(asked["together"][0, 0], [7.0, 1.0, 1.0])
    assert asked["with_most"]
    assert (one.tried, one.adopted, one.before) == ((), False, now)
    other = SimpleNamespace(fit=SimpleNamespace(residual={("torque", 0): np.zeros((4, 1, 1))}))
    assert not round_of(monkeypatch, [], now=now, nominal=other)[1]["with_most"]


def test_the_first_that_is_significant_is_adopted_and_told_before_those_that_fitted_better(monkeypatch):
    first, second, third = (Tried(cogging(f"j{k}", 3.0)) for k in (1, 2, 3))
    one, _ = round_of(monkeypatch, [[first, second, third]], worthy=(second, third))
    assert (one.adopted, one.tried, one.alike) == (True, (second, first, third), (second,))
    none, _ = round_of(monkeypatch, [[first, second], [third]])
    assert (none.adopted, none.tried, none.alike) == (False, (first, second), ())


@dataclass(frozen=True, eq=False)
class Tried:
    """A candidate that was fitted."""

    hypothesis: Hypothesis


@pytest.mark.parametrize("where", [0, 1, settings().search.elsewhere, settings().search.elsewhere + 1])
def test_where_no_joint_that_was_tried_has_a_cause_others_are_tried(monkeypatch, where):
    """`where` is the number of joints that are tried before the one with a cause."""
    beaten_then = []

    def fit_best(problem, candidates, ranking, equations, now, needless, beaten, report):
        beaten_then.append(set(beaten))
        return [Tried(cogging(f"j{len(beaten)}", 3.0))]

    rows = {("torque", 0): np.zeros((4, 1, 1))}
    equations = SimpleNamespace(rows=np.array([6.0]), n_components=2)
    given = []
    monkeypatch.setattr(module, "split_components", lambda residual: residual)
    monkeypatch.setattr(module, "rank", lambda *_, **how: SimpleNamespace(threshold=5.0))
    monkeypatch.setattr(module, "_fit_best", fit_best)
    monkeypatch.setattr(module, "find_lookalikes", lambda *_: ())
    monkeypatch.setattr(
        module,
        "is_significant",
        lambda problem, nominal, now, tried, chance: given.append(chance) or tried.hypothesis.joint == f"j{where}",
    )
    candidates = SimpleNamespace(
        design=SimpleNamespace(form_equations=lambda together: equations), nuisance_places=np.arange(0)
    )
    now = SimpleNamespace(fit=SimpleNamespace(residual=rows))
    one = module._run_round(None, candidates, rows, now, now, (), None)
    most = settings().search.elsewhere
    assert one.adopted == (where <= most)
    assert len(beaten_then) == min(where, most) + 1
    assert beaten_then[-1] == {f"j{k}" for k in range(min(where, most))}
    assert one.tried[0].hypothesis.joint == (f"j{where}" if one.adopted else "j0")
    assert set(given) == {15.0}  # the threshold, in energy of noise in one component
