"""Causes of a search when one more was adopted, and sizes that nobody asks for."""

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
        monkeypatch.setattr(module, "fit_and_score", lambda setting, causes, like, begun: tried(causes, by_replaying))
        return module.drop_needless(SETTING, tried("abc", by_replaying)).fit.hypotheses, replayed

    return make


def test_a_cause_that_others_make_up_for_by_replaying_is_dropped(search):
    slopes = {"bc": 1.4, "ac": 9.0, "c": 9.0}
    assert search(slopes, {"abc": 1.0, "bc": 1.04, "c": 9.0}) == (("b", "c"), ["bc"])


def test_a_cause_is_kept_that_others_come_near_to_but_do_not_make_up_for(search):
    assert search({"bc": 1.4, "ac": 1.2}, {"abc": 1.0, "bc": 1.06, "ac": 1.06}) == (("a", "b", "c"), ["bc", "ac"])


def test_a_cause_without_which_slopes_leave_much_is_kept_unreplayed(search):
    assert search({"bc": 2.1, "ac": 2.1}, {"abc": 1.0}) == (("a", "b", "c"), [])


def test_causes_that_are_left_out_of_a_result_take_their_rivals_along(monkeypatch):
    """The others are fitted again without them; without all of them nothing was found."""

    def model(*names):
        causes = tuple(SimpleNamespace(label=name) for name in names)
        return SimpleNamespace(fit=SimpleNamespace(hypotheses=causes))

    monkeypatch.setattr(module, "fit_and_score", lambda setting, causes, begun: model(*(one.label for one in causes)))
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
