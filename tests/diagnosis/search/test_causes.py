"""Causes that others make up for are dropped; where slopes say that they come nowhere near, nothing is replayed."""

from types import SimpleNamespace

import pytest

from ffgym.diagnosis.search import found as module

SETTING = SimpleNamespace(nominal=None)


@pytest.fixture
def search(monkeypatch):
    """A search in which fits of some causes leave so much, by slopes and by replaying."""
    replayed = []

    def make(by_slopes, by_replaying):
        def tried(causes, left):
            return SimpleNamespace(total=left["".join(causes)], fit=SimpleNamespace(hypotheses=tuple(causes)))

        def refined(setting, begun, like, *, roughly):
            replayed.append("".join(begun.fit.hypotheses))
            return tried(begun.fit.hypotheses, by_replaying)

        monkeypatch.setattr(module, "machine_with", lambda nominal, causes: causes)
        monkeypatch.setattr(module, "evaluated", lambda setting, causes, like: tried(causes, by_slopes))
        monkeypatch.setattr(module, "scored", lambda setting, fit: fit)
        monkeypatch.setattr(module, "refined", refined)
        monkeypatch.setattr(module, "judged_with", lambda setting, causes, like, begun: tried(causes, by_replaying))
        return module.without_needless(SETTING, tried("abc", by_replaying)).fit.hypotheses, replayed

    return make


def test_a_cause_that_others_make_up_for_by_replaying_is_dropped(search):
    slopes = {"bc": 1.4, "ac": 9.0, "c": 9.0}
    assert search(slopes, {"abc": 1.0, "bc": 1.04, "c": 9.0}) == (("b", "c"), ["bc"])


def test_a_cause_is_kept_that_others_come_near_to_but_do_not_make_up_for(search):
    assert search({"bc": 1.4, "ac": 1.2}, {"abc": 1.0, "bc": 1.06, "ac": 1.06}) == (("a", "b", "c"), ["bc", "ac"])


def test_a_cause_without_which_slopes_leave_much_is_kept_unreplayed(search):
    assert search({"bc": 2.1, "ac": 2.1}, {"abc": 1.0}) == (("a", "b", "c"), [])
