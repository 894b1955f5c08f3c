"""Logs with anything that logs are known to suffer from: insufficient, or one clear error, never a name."""

import numpy as np
import pytest

from ffgym.diagnosis import diagnose
from ffgym.errors import FFGymError
from ffgym.quality import check_quality
from ffgym.recordings import Recording
from tests.quality.defects import DEFECTS
from tests.quality.quality_logs import clean_log, described
from tests.quality.test_defects import applicable

ROBOT, MOTION = "two_link", "multisine"

OPEN = {
    "all_torques_100_ms_late": "the gate only flags the lag; servo gains, which are not wrong, tie beside the clock",
    "tracker_late": "the gate only flags the lag; the clock of the tracker is named, which is true of the log",
    "duplicate_rows": "the gate only flags them; what they leave is unknown",
    "quantised_to_8_bits": "the gate only flags it; what it leaves is unknown",
}
"""Defects that are not insufficient yet, with what is said instead."""


def damaged(defect):
    """A log with the defect; None if no recording can be made of it, or the robot has nothing to do it to."""
    clean = clean_log(ROBOT, MOTION)
    if not applicable(defect, clean):
        return None
    broken = defect.inject(clean, np.random.default_rng(11))
    try:
        return Recording(broken.columns, broken.header)
    except FFGymError:
        return None


def verdict_of(recording):
    """Verdict of a diagnosis of this log alone; an error that says what is wrong counts as insufficient."""
    try:
        return diagnose(described(ROBOT, MOTION), [recording]).verdict
    except FFGymError:
        return "insufficient"


@pytest.mark.parametrize("defect", DEFECTS, ids=lambda defect: defect.name)
def test_what_the_quality_gate_refuses_is_insufficient(defect):
    recording = damaged(defect)
    if recording is None:
        pytest.skip("no recording of two_link can have this")
    findings = check_quality(recording, described(ROBOT, MOTION)).findings
    if all(finding.verdict != "refused" for finding in findings):
        pytest.skip("the gate lets it pass with a remark; see the slow test")
    found = diagnose(described(ROBOT, MOTION), [recording])
    assert found.verdict == "insufficient"
    assert found.causes == ()
    assert any(finding.message in found.sentence for finding in findings)


def listed():
    """Every defect; those that are open are expected to fail."""
    for defect in DEFECTS:
        marks = [pytest.mark.xfail(reason=OPEN[defect.name])] if defect.name in OPEN else []
        yield pytest.param(defect, marks=marks, id=defect.name)


@pytest.mark.slow
@pytest.mark.parametrize("defect", [*listed()])
def test_no_defect_of_a_log_is_taken_for_a_fault_of_the_machine(defect):
    recording = damaged(defect)
    if recording is None:
        pytest.skip("no recording of two_link can have this")
    assert verdict_of(recording) in ("none", "insufficient")
