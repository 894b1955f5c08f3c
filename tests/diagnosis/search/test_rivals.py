"""Who rivals a cause: what explains the same; who ties, and what is named then."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.result import Rival
from ffgym.diagnosis.search import rivals as module
from ffgym.diagnosis.search.rivals import as_rivals, rivals_of, tied_among
from ffgym.effects import EFFECTS

BLOCKS = 100


def hypothesis(name, joint):
    values = {p.name: np.array(p.high) for p in EFFECTS[name].parameters().values()}
    return Hypothesis(kind=EFFECTS[name], joint=joint, source=None, values=values)


def tried(name, joint, left, removes):
    """A fitted candidate: energy left per block, and what it removes of each component."""
    one = hypothesis(name, joint)
    fit = SimpleNamespace(hypotheses=(one,), columns=[{}] * len(one.free()), removes=removes)
    rows = np.full(BLOCKS, left)
    return SimpleNamespace(hypothesis=one, fit=fit, left=rows, total=float(rows.sum()))


@pytest.fixture
def judge(monkeypatch):
    """Loudness, components and gains are those that candidates were made with; further fits are as told."""
    monkeypatch.setattr(module, "without_calibration", lambda setting, fit: fit)
    monkeypatch.setattr(module, "loudness", lambda setting, fit: {k: 11.0 - fit.removes.get(k, 0.0) for k in "ab"})
    monkeypatch.setattr(module, "touched", lambda setting, columns: {"a"})
    monkeypatch.setattr(module, "removed_by", lambda *found: SimpleNamespace(of_excess=0.5))
    again = {}
    monkeypatch.setattr(module, "judged_with", lambda setting, hypotheses: again[hypotheses[-1].kind.name])
    return again


def judged(best, others, fitted=None):
    before = SimpleNamespace(left=np.full(BLOCKS, 100.0), total=100.0 * BLOCKS, fit=SimpleNamespace(removes={}))
    one = SimpleNamespace(adopted=True, before=before, tried=(best, *others))
    fitted = fitted or best
    return rivals_of(None, before, fitted, [one], np.random.default_rng(0)), one


def test_what_explains_as_much_of_the_same_ties(judge):
    best, other = tried("stribeck_peak", "j1", 10.0, {"a": 9.0}), tried("dwell_stiction", "j1", 10.0, {"a": 9.0})
    (rival,), one = judged(best, [other])
    assert rival.tied
    assert rival.against == "stribeck_peak on j1"
    assert tied_among([best.hypothesis], [rival]) == [best.hypothesis]
    (mirrored,) = as_rivals([best.hypothesis], [rival], [one])
    assert (mirrored.effect, mirrored.joint, mirrored.against) == ("stribeck_peak", "j1", "dwell_stiction on j1")
    assert mirrored.held_out_gain == pytest.approx(0.9)


def test_what_explains_as_much_of_something_else_is_no_tie(judge):
    best, other = tried("stribeck_peak", "j1", 10.0, {"a": 9.0}), tried("stribeck_peak", "j2", 10.0, {"b": 9.0})
    (rival,), _ = judged(best, [other])
    assert not rival.tied
    assert rival.reason == "explains little of what stribeck_peak on j1 does"


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
    assert tied_among([hypothesis("viscous_level", "j1")], [rival]) == []
