"""Only causes that tie get a motion that separates them, beside all others that are known."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis import separation as module
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.search.rounds import SearchRound
from ffgym.diagnosis.separation import propose_next_motion
from ffgym.robot import load_robot
from ffgym.simulation.plant import Machine
from tests.diagnosis.result_samples import neutral_hypothesis

ROBOT = load_robot("two_link")


SURE = neutral_hypothesis("coulomb_level", ROBOT.joints[0])
BEST, SAME, WORSE = (neutral_hypothesis(name, ROBOT.joints[1]) for name in ("cogging", "torque_ripple", "asymmetry"))


def found(*, tied=(), unsure=()):
    """Two causes in two rounds; the second has two rivals."""
    rivals = [
        SimpleNamespace(effect=r.kind.name, joint=r.joint, tied=r in tied, against=BEST.label) for r in (SAME, WORSE)
    ]
    tried = [[SURE], [BEST, SAME, WORSE]]
    rounds = [
        SearchRound(
            adopted=True, before=None, ranking=None, tried=tuple(SimpleNamespace(hypothesis=h) for h in hypotheses)
        )
        for hypotheses in tried
    ]
    stayed = [h for h in (SURE, BEST) if h not in unsure]
    fit = SimpleNamespace(hypotheses=stayed)
    return SimpleNamespace(final=SimpleNamespace(fit=fit), unsure=unsure, rounds=rounds, rivals=rivals)


@pytest.fixture
def asked(monkeypatch):
    """What a motion was asked for: the model, and the causes to separate."""
    asked = []

    def separating_motion(arm, known, causes, noise, *, prior):
        asked.append((known, causes, noise))
        return "a motion"

    monkeypatch.setattr(module, "design_separating_motion", separating_motion)
    return asked


def motion_for(what):
    floor = {"torque": np.array([[3.0, 1.0], [4.0, 1.0]])}
    return propose_next_motion(what, Machine(robot=ROBOT), floor, ParameterPrior())


def test_without_ties_no_motion_is_looked_for(asked):
    assert motion_for(found()) is None
    assert asked == []


@pytest.mark.parametrize("unsure", [(), (BEST,)])
def test_a_cause_and_those_that_tie_with_it_are_to_be_separated_beside_the_causes_that_are_sure(asked, unsure):
    assert motion_for(found(tied=(SAME,), unsure=unsure)) == "a motion"
    ((known, causes, noise),) = asked
    assert list(causes) == [BEST, SAME]
    assert [effect.name for effect in known.effects] == ["coulomb_level"]
    assert noise["torque"] == pytest.approx([np.sqrt(12.5), 1.0])


def test_where_no_session_is_sure_to_separate_them_there_is_none(monkeypatch):
    monkeypatch.setattr(module, "design_separating_motion", lambda *given, **known: None)
    assert motion_for(found(tied=(SAME,))) is None
