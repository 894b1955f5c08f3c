"""Causes of a search when one more was adopted, and sizes that nobody asks for."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.search import rounds as module
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import Priors
from ffgym.effects import EFFECTS

SETTING = SimpleNamespace(nominal=None)


@pytest.fixture
def search(monkeypatch):
    """A search in which fits of some causes leave so much, by slopes and by replaying."""
    replayed = []

    def make(by_slopes, by_replaying):
        def tried(causes, left):
            return SimpleNamespace(rss=left["".join(causes)], fit=SimpleNamespace(hypotheses=tuple(causes)))

        def refined(setting, begun, like, *, roughly):
            assert roughly  # its energy alone decides
            replayed.append("".join(begun.fit.hypotheses))
            return tried(begun.fit.hypotheses, by_replaying)

        monkeypatch.setattr(module, "build_machine", lambda nominal, causes: causes)
        monkeypatch.setattr(module, "evaluate", lambda setting, causes, like: tried(causes, by_slopes))
        monkeypatch.setattr(module, "score", lambda setting, fit: fit)
        monkeypatch.setattr(module, "refine", refined)
        monkeypatch.setattr(
            module,
            "fit_and_score",
            lambda setting, causes, like, *, begun: tried(causes, by_replaying) if begun else None,
        )
        return module.drop_needless(SETTING, tried("abc", by_replaying)).fit.hypotheses, replayed

    return make


def test_a_cause_that_others_make_up_for_by_replaying_is_dropped(search):
    slopes = {"bc": 1.4, "ac": 9.0, "c": 9.0}
    assert search(slopes, {"abc": 1.0, "bc": 1.04, "c": 9.0}) == (("b", "c"), ["bc"])


def test_a_cause_is_kept_that_others_come_near_to_but_do_not_make_up_for(search):
    assert search({"bc": 1.4, "ac": 1.2}, {"abc": 1.0, "bc": 1.06, "ac": 1.06}) == (("a", "b", "c"), ["bc", "ac"])


def test_a_cause_without_which_slopes_leave_much_is_kept_unreplayed(search):
    assert search({"bc": 2.1, "ac": 2.1}, {"abc": 1.0}) == (("a", "b", "c"), [])


@pytest.mark.parametrize("is_needed", [False, True])
def test_a_cause_is_dropped_up_to_the_limits_and_kept_beyond_them(search, is_needed):
    """The limits are of what all causes leave: 1 here."""
    limits = settings().search
    needed = 1.0 + limits.needed + (1e-12 if is_needed else 0.0)
    slopes = {"bc": 1.0 + limits.clearly_needed, "ac": 9.0, "c": 9.0}
    assert search(slopes, {"abc": 1.0, "bc": needed})[0] == (("a", "b", "c") if is_needed else ("b", "c"))


def test_the_newest_cause_is_not_asked_whether_it_is_needless(search):
    assert search({"bc": 9.0, "ac": 9.0, "ab": 1.0}, {"abc": 1.0, "ab": 0.5}) == (("a", "b", "c"), [])


def test_causes_that_are_left_out_of_a_result_take_their_rivals_along(monkeypatch):
    """The others are fitted again without them; without all of them nothing was found."""

    def model(*names):
        causes = tuple(SimpleNamespace(label=name) for name in names)
        return SimpleNamespace(fit=SimpleNamespace(hypotheses=causes))

    def fit_and_score(setting, causes, *, begun):
        assert begun  # from where they are
        return model(*(one.label for one in causes))

    monkeypatch.setattr(module, "fit_and_score", fit_and_score)
    nominal, final = model(), model("a", "b", "c")
    rivals = tuple(SimpleNamespace(against=name) for name in "abb")
    found = module.SearchResult(
        nominal=nominal, candidates=None, final=final, whole=final, rounds=(), rivals=rivals, unsure=(), rows=1.0
    )
    a, b, c = final.fit.hypotheses
    left = module.leave_out(SETTING, found, [b])
    assert [one.label for one in left.final.fit.hypotheses] == ["a", "c"]
    assert left.whole is left.final
    assert [rival.against for rival in left.rivals] == ["a"]
    more = SimpleNamespace(fit=SimpleNamespace(hypotheses=(a, b, c, SimpleNamespace(label="d"))))
    both = module.leave_out(SETTING, replace(found, whole=more), [b])
    assert [one.label for one in both.final.fit.hypotheses] == ["a", "c"]
    assert [one.label for one in both.whole.fit.hypotheses] == ["a", "c", "d"]
    none = module.leave_out(SETTING, found, [a, b, c])
    assert none.final is nominal
    assert not none.rivals


SIZES = {"viscous", "coulomb", "breakaway"}


def warm():
    values = {"viscous": 0.02, "scale": 25.0, "coulomb": -0.005, "breakaway": 0.001, "reference": 20.0}
    return Hypothesis(
        kind=EFFECTS["temperature_friction"],
        joint="j3",
        source=None,
        values={n: np.array(v) for n, v in values.items()},
    )


def tried(hypothesis, total):
    free = hypothesis.list_free()
    n = len(free)
    priors = Priors(precision=np.ones(n), low=np.full(n, -3.0), high=np.full(n, 3.0))
    return SimpleNamespace(
        hypothesis=hypothesis, rss=total, fit=SimpleNamespace(hypotheses=(hypothesis,), priors=priors)
    )


@pytest.mark.parametrize("needed", [{"coulomb"}, {"coulomb", "viscous"}, {"viscous", "coulomb", "breakaway"}])
def test_a_size_that_rows_left_out_do_not_ask_for_is_null(needed, monkeypatch):
    """Each size costs 1; without one that is needed 100 more are left. By slopes, too, where one is held at null."""

    def total(kept):
        return 100.0 * len(needed - kept) + len(kept)

    def left_out(setting, fit, priors):
        assert np.all(priors.low < priors.high)
        free, held = fit.hypotheses[-1].list_free(), priors.high - priors.low < 1e-3
        for number, bound in zip(free, held, strict=True):
            if bound:
                at = number.value + number.step * priors.low[free.index(number)]
                assert at == pytest.approx(0.0, abs=1e-5)
        return np.array([total({f.name for f, out in zip(free, held, strict=True) if not out} & SIZES)])

    monkeypatch.setattr(module, "compute_held_out_rss", left_out)
    monkeypatch.setattr(module, "evaluate", lambda setting, hypotheses, like: hypotheses)
    monkeypatch.setattr(module, "refine", lambda setting, begun, like: begun)
    monkeypatch.setattr(
        module, "score", lambda setting, begun: tried(begun[-1], total({f.name for f in begun[-1].list_free()} & SIZES))
    )
    slim = module.prune(None, tried(warm(), total(SIZES))).hypothesis
    assert {free.name for free in slim.list_free()} & SIZES == needed
    assert slim.null == SIZES - needed
    assert all(slim.values[name] == 0.0 for name in slim.null)
    assert slim.move([0.1] * len(slim.list_free())).null == slim.null


@pytest.mark.parametrize(
    ("by_slopes", "by_fit", "goes"), [(0.0, 0.0, False), (-1.0, 0.0, False), (0.0, -1.0, False), (-1.0, -1.0, True)]
)
def test_a_size_goes_only_if_less_is_left_without_it_by_slopes_and_by_a_fit(monkeypatch, by_slopes, by_fit, goes):
    """Energies are what is left more without the first size that is tried; the others are needed."""

    def left_out(setting, fit, priors):
        free, held = fit.hypotheses[-1].list_free(), priors.high - priors.low < 1e-3
        out = {f.name for f, is_held in zip(free, held, strict=True) if is_held}
        return np.array([10.0 + by_slopes if out == {"breakaway"} else 99.0])

    monkeypatch.setattr(module, "compute_held_out_rss", left_out)
    monkeypatch.setattr(module, "evaluate", lambda setting, hypotheses, like: hypotheses)
    monkeypatch.setattr(module, "refine", lambda setting, begun, like: begun)
    monkeypatch.setattr(module, "score", lambda setting, begun: tried(begun[-1], 10.0 + by_fit))
    slim = module.prune(None, tried(warm(), 10.0)).hypothesis
    assert slim.null == ({"breakaway"} if goes else set())


def test_a_size_of_the_newest_cause_is_held_at_null_beside_an_earlier_one(monkeypatch):
    """Bounds of what came before, nuisance parameters and another cause, stay."""
    before = Hypothesis(kind=EFFECTS["viscous_level"], joint="j1", source=None, values={"change": np.array(0.3)})
    free = warm().list_free()
    first = 2 + len(before.list_free())
    n = first + len(free)
    priors = Priors(precision=np.arange(n), low=np.full(n, -3.0), high=np.full(n, 3.0))
    fit = SimpleNamespace(hypotheses=(before, warm()), priors=priors)
    given = []
    monkeypatch.setattr(module, "compute_held_out_rss", lambda problem, fit, priors: given.append(priors) or np.ones(3))
    assert module._compute_rss_without(None, fit, "coulomb") == 3.0
    moved = np.flatnonzero(given[0].low != -3.0)
    assert list(moved) == [first + [number.name for number in free].index("coulomb")]
    assert list(np.flatnonzero(given[0].high != 3.0)) == list(moved)
    assert np.array_equal(given[0].precision, priors.precision)
    assert np.all(priors.low == -3.0)


def test_what_cannot_be_fitted_without_a_size_keeps_it(monkeypatch):
    def refine(setting, begun, like):
        raise FFGymError("no such machine")

    monkeypatch.setattr(module, "compute_held_out_rss", lambda *given: np.array([1.0]))
    monkeypatch.setattr(module, "evaluate", lambda setting, hypotheses, like: hypotheses)
    monkeypatch.setattr(module, "refine", refine)
    whole = tried(warm(), 10.0)
    assert module.prune(None, whole) is whole


def test_the_newest_cause_of_a_fit_is_the_last():
    fit = SimpleNamespace(hypotheses=("first", "second", "last"))
    assert module.ScoredFit(fit=fit, rss_by_block=np.ones(2)).hypothesis == "last"


def test_a_cause_was_adopted_where_something_was():
    """A round that adopted nothing tried it, too."""
    first, later = tried(warm(), 1.0), tried(warm(), 2.0)
    without = module.SearchRound(before=None, ranking=None, tried=(first,), adopted=False)
    adopted = module.SearchRound(before=None, ranking=None, tried=(later,), adopted=True)
    assert module.find_adoption([without, adopted], warm()) == (adopted, later)


def test_causes_are_fitted_from_where_they_are_told_and_none_is_the_model_as_it_is(monkeypatch):
    monkeypatch.setattr(module, "score", lambda setting, fit: fit)
    monkeypatch.setattr(module, "evaluate", lambda setting, causes: ("as it is", causes))
    monkeypatch.setattr(module, "fit", lambda setting, causes, *, begun, like: (causes, begun, like))
    assert module.fit_and_score(SETTING, ()) == ("as it is", ())
    assert module.fit_and_score(SETTING, ["a"], "like it") == (["a"], False, "like it")
    assert module.fit_and_score(SETTING, ["a"], begun=True) == (["a"], True, None)


@pytest.fixture
def finer(monkeypatch):
    """Refit of so many causes that leave so much of 100 by noise; polishing gives what it is told to."""

    def refitted(n_causes, left, polished=None, fails=False):
        def model(name, left):
            equations = SimpleNamespace(rows=np.array([60.0, 40.0]))
            return SimpleNamespace(name=name, hypotheses=("cause",) * n_causes, left=left, equations=equations)

        def refine(setting, begun):
            if fails:
                raise FFGymError("no such machine")
            return begun

        monkeypatch.setattr(module, "renew_tangents", lambda setting, fit: model(f"renewed {fit.name}", fit.left))
        monkeypatch.setattr(module, "refine", refine)
        monkeypatch.setattr(module, "polish", lambda setting, fit: model(f"finer {fit.name}", 0.0) if polished else fit)
        monkeypatch.setattr(module, "score", lambda setting, fit: SimpleNamespace(fit=fit))
        adopted = SimpleNamespace(fit=model("fit", left))
        found = module.refit(SETTING, adopted)
        return found.fit.name, found is adopted

    return refitted


def test_all_causes_are_fitted_with_tangents_of_their_own_and_more_finely_if_anything_is_left(finer):
    noise = 100.0 * settings().search.finer_from
    assert finer(1, noise - 1, polished=True) == ("fit", True)
    assert finer(1, noise, polished=True) == ("finer fit", False)
    assert finer(1, noise + 1, polished=False) == ("fit", True)
    assert finer(2, noise - 1, polished=True) == ("renewed fit", False)
    assert finer(2, noise + 1, polished=True) == ("finer renewed fit", False)
    assert finer(2, noise + 1, polished=True, fails=True) == ("fit", True)


def test_a_fit_is_scored_by_both_splits_alike_or_by_halves_alone_of_a_single_motion(monkeypatch):
    left = {"halves": np.array([1.0, 2.0]), "motions": np.array([3.0, 6.0])}
    monkeypatch.setattr(module, "compute_block_rss", lambda equations, folds, columns, priors: left[folds[0]])
    monkeypatch.setattr(module, "make_half_folds", lambda blocks: ["halves"])
    fit = SimpleNamespace(equations=None, fold_columns=None, priors=None)
    for folds, expected in ((["motions"], [2.0, 4.0]), ([], [1.0, 2.0])):
        monkeypatch.setattr(module, "make_motion_folds", lambda blocks, folds=folds: folds)
        scored = module.score(SimpleNamespace(blocks=None), fit)
        np.testing.assert_array_equal(scored.rss_by_block, expected)
        assert scored.rss == sum(expected)


def test_a_round_tells_the_first_fit_of_a_cause_whatever_its_values():
    first, other = tried(warm(), 1.0), tried(warm().scale(0.5), 2.0)
    one = module.SearchRound(before=None, ranking=None, tried=(first, other), adopted=True)
    assert one.of([warm().scale(0.1)]) is first
    assert one.of([]) is None
