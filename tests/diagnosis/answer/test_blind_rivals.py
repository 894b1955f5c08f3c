"""Causes that vary over a session, beside effects of which the log does not show what they vary with."""

import numpy as np
import pytest

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.result import Unjudged
from ffgym.diagnosis.verdict import Judged, beside_blind, blind_rivals, told
from ffgym.effects import EFFECTS

NO_TEMPERATURE = Unjudged(effect="temperature_friction", joint="", reason="the log has no temperature")
NO_TOOL = Unjudged(effect="joint_zeros", joint="", reason="the log has no tracked tool position")


def cause(name, joint="j2"):
    values = {n: np.array(p.neutral if p.default is None else p.default) for n, p in EFFECTS[name].parameters().items()}
    return Hypothesis(kind=EFFECTS[name], joint=joint, source=None, values=values)


@pytest.mark.parametrize("name", ["viscous_drift", "coulomb_drift"])
def test_a_drift_may_be_one_of_temperature_where_nobody_measured_it(name):
    (rival,) = blind_rivals([cause(name), cause("coulomb_level")], [NO_TOOL, NO_TEMPERATURE])
    assert (rival.effect, rival.joint, rival.tied) == ("temperature_friction", "j2", True)
    assert rival.against == cause(name).label
    assert "no temperature" in rival.reason


def test_where_all_is_measured_or_nothing_drifts_there_is_no_such_rival():
    assert not blind_rivals([cause("viscous_drift")], [NO_TOOL])
    assert not blind_rivals([cause("coulomb_level")], [NO_TEMPERATURE])


@pytest.mark.parametrize(
    ("verdict", "drifts", "becomes"),
    [("named", True, "ambiguous"), ("named", False, "named"), ("partly", True, "partly")],
)
def test_nothing_that_may_be_temperature_is_named_without_reserve(verdict, drifts, becomes):
    judged = Judged(verdict=verdict, gains=(1.0,), removed=1.0, stretched=())
    rivals = blind_rivals([cause("viscous_drift")], [NO_TEMPERATURE] if drifts else [])
    assert beside_blind(judged, rivals).verdict == becomes


@pytest.mark.parametrize(
    ("verdict", "is_told"), [("ambiguous", True), ("partly", True), ("unknown", False), ("none", False)]
)
def test_such_rivals_are_told_beside_causes_and_nowhere_else(verdict, is_told):
    judged = Judged(verdict=verdict, gains=(1.0,), removed=1.0, stretched=())
    rivals = blind_rivals([cause("viscous_drift")], [NO_TEMPERATURE])
    assert bool(told(judged, rivals)) == is_told
