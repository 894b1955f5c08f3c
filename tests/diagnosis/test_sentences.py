"""The verdict in one sentence: what is sure, what cannot be told apart, and what is left."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from ffgym.diagnosis.result import Pattern
from ffgym.diagnosis.verdict import Judged, sentence_of
from tests.diagnosis.result_samples import full_diagnosis


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


def sentence(verdict, *, tied=True, stretched=(), patterns=PATTERNS):
    sample = full_diagnosis()
    judged = Judged(verdict=verdict, gains=(0.9,), removed=0.8, stretched=stretched)
    rivals = [rival for rival in sample.rivals if tied or not rival.tied]
    return sentence_of(judged, sample.causes, rivals, patterns, SimpleNamespace(name="arm"))


def test_beside_sure_causes_those_that_tie_are_told_and_what_each_of_some_components_depends_on():
    found = sentence("partly")
    assert found.startswith("Partly explained by Friction that grows with load of j2: that removes 80 %")
    assert "; beyond that, payload would explain more; what is left then depends on: first of j1; of x; of j2." in found
    assert "second of j1" not in found
    assert "of j3" not in found


def test_nothing_is_said_to_be_left_where_those_that_tie_would_leave_nothing():
    assert sentence("partly", patterns=()).endswith("; beyond that, payload would explain more.")
    assert sentence("partly", patterns=(), tied=False).endswith(", and something is left.")


def test_a_rival_that_the_log_cannot_tell_from_a_cause_is_told_beside_it():
    sample = full_diagnosis()
    (cause,), (payload, *_) = sample.causes, sample.rivals
    judged = Judged(verdict="partly", gains=(0.9,), removed=0.8, stretched=())
    found = sentence_of(judged, [cause], [replace(payload, against=cause.label)], (), SimpleNamespace(name="arm"))
    assert "Friction that grows with load of j2 (these logs cannot tell it from payload): that removes 80 %" in found
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
    judged = Judged(verdict="ambiguous", gains=(0.9, 0.8), removed=0.8, stretched=())
    found = sentence_of(judged, [cause, cause], [tied, tied], (), SimpleNamespace(name="arm"))
    assert found.startswith("Consistent with Friction that grows with load of j2 in 2 waves; but payload would explain")


def test_patterns_of_one_component_that_explain_as_much_stand_together():
    patterns = (
        pattern("torque", "j1", "first"),
        pattern("torque", "j1", "near", share=0.48),
        pattern("torque", "j1", "weak", share=0.2),
    )
    assert sentence("unknown", patterns=patterns).endswith("what is left depends on: first; near.")
