"""What a round of the search tries."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.search import search as module
from ffgym.effects import EFFECTS


def cogging(joint, cycles):
    values = {"amplitude": np.array(0.01), "cycles": np.array(cycles), "phase": np.array(0.0)}
    return Hypothesis(kind=EFFECTS["cogging"], joint=joint, source=None, values=values)


@pytest.fixture
def candidates(monkeypatch):
    """Candidates of a ranking, which may be tried beside causes that are there and such that were not needed."""

    def tried(found, there=(), needless=()):
        ranking = SimpleNamespace(order=range(len(found)), score=np.ones(len(found)), is_significant=lambda i: True)
        known = SimpleNamespace(groups=range(len(found)), first=lambda i: found[i], nuisance_places=None)
        monkeypatch.setattr(module, "find_changed_components", lambda *_: {})
        monkeypatch.setattr(module, "propose_start", lambda evidence, candidates, i, *_: found[i])
        monkeypatch.setattr(module, "_shrink_to_possible", lambda setting, others, start: start)
        monkeypatch.setattr(
            module, "fit_and_score", lambda setting, all_of, like: SimpleNamespace(hypothesis=all_of[-1], rss=1.0)
        )
        now = SimpleNamespace(fit=SimpleNamespace(hypotheses=tuple(there)), rss=2.0)
        setting = SimpleNamespace(log=SimpleNamespace(robot=None))
        report = lambda what, share: None  # noqa: E731
        return [one.hypothesis for one in module._fit_best(setting, known, ranking, None, now, needless, (), report)]

    return tried


def test_a_cause_that_is_there_or_that_others_made_up_for_is_not_tried_again(candidates):
    """Else it would come, be dropped beside the next, and come again."""
    one, other, third = cogging("j1", 3.0), cogging("j2", 1.0), cogging("j3", 3.0)
    assert candidates([one, other, third]) == [one, other, third]
    assert candidates([one, other, third], there=[third]) == [one, other]
    assert candidates([one, other, third], needless=[cogging("j1", 3.05)]) == [other, third]
    assert candidates([one, other, third], needless=[cogging("j1", 6.0)]) == [one, other, third]


def test_what_ties_with_a_rival_is_explained_all_the_same(monkeypatch):
    """A quiet cause beside a loud one that ties: alone it would seem to leave nearly all where both act."""
    loud, quiet = cogging("j1", 3.0), cogging("j1", 7.0)
    model = lambda setting, kept: SimpleNamespace(fit=SimpleNamespace(hypotheses=tuple(kept)))  # noqa: E731
    monkeypatch.setattr(module, "explains_most", lambda setting, nominal, now: loud in now.fit.hypotheses)
    monkeypatch.setattr(module, "fit_and_score", model)
    monkeypatch.setattr(module, "correct_bias", lambda setting, fit: fit)
    monkeypatch.setattr(module, "score", lambda setting, fit: SimpleNamespace(fit=fit))
    nominal = model(None, ())

    def kept_of(all_of, kept):
        return module._conclude(None, nominal, model(None, all_of), kept, lambda what, share: None).fit.hypotheses

    assert kept_of([loud, quiet], [quiet]) == (quiet,)
    assert kept_of([loud, quiet], [loud, quiet]) == (loud, quiet)
    assert kept_of([quiet], [quiet]) == ()
    assert kept_of([], []) == ()


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
