"""Logs with anything that logs are known to suffer from: insufficient, or one clear error, never a name."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis import diagnose
from ffgym.logs.quality import check_quality
from ffgym.recordings import Recording
from tests.logs.quality.defects import DEFECTS
from tests.logs.quality.quality_logs import clean_log, described
from tests.logs.quality.test_defects import applicable

ROBOT, MOTION = "two_link", "multisine"

MENDED = (*("clock_step", "dropped_samples", "jitter"), *("duplicate_rows", "stuck_position", "a_spike", "noise_burst"))
"""Defects that conditioning mends or leaves out."""

BRIDGED = "stuck_position"
"""Mended, but friction after a reversal that is not known may stay unexplained: `unknown` is right, a name is not."""

HARMLESS = ("a_column_shifted_by_rows", "filtered_speed_called_raw", "truncated_in_motion")
"""Defects of what a diagnosis does not use: it differentiates positions itself, and takes any part of a motion."""


def damaged(defect, seed=11):
    """A log with the defect; None if no recording can be made of it, or the robot has nothing to do it to."""
    clean = clean_log(ROBOT, MOTION)
    if not applicable(defect, clean):
        return None
    broken = defect.inject(clean, np.random.default_rng(seed))
    try:
        return Recording(broken.columns, broken.header)
    except FFGymError:
        return None


WIRED = {
    "time_in_milliseconds": "clock",
    "degrees_for_radians": "unit",
    "revolutions_per_minute": "unit",
    "link_side_for_motor_side": "side",
    "swapped_sign_of_a_position": "sign",
    "permuted_positions": "swap",
    "all_torques_100_ms_late": "delay",
    "all_torques_with_the_opposite_sign": "sign",
    "all_torques_in_millinewton_metres": "unit",
    "permuted_torques": "swap",
    "tracker_in_millimetres": "unit",
}
"""Defects that the gate refuses, and a fit of the wiring names and mends."""


def verdict_of(recording):
    """Verdict of a diagnosis of this log alone; an error that says what is wrong counts as insufficient."""
    try:
        return diagnose(described(ROBOT, MOTION), [recording]).verdict
    except FFGymError:
        return "insufficient"


@pytest.mark.parametrize("defect", DEFECTS, ids=lambda defect: defect.name)
def test_what_the_quality_gate_refuses_is_insufficient_and_nothing_is_ever_named(defect):
    recording = damaged(defect)
    if recording is None:
        pytest.skip("no recording of two_link can have this")
    findings = check_quality(recording, described(ROBOT, MOTION), ("diagnosis",)).findings
    refused = [finding.message for finding in findings if finding.verdict == "refused"]
    found = diagnose(described(ROBOT, MOTION), [recording])
    assert found.causes == ()
    if not refused:
        assert defect.name in (*HARMLESS, *MENDED)
        assert found.verdict == "none" or (defect.name == BRIDGED and found.verdict == "unknown")
        return
    if defect.name in WIRED:
        assert (found.verdict, [mistake.kind for mistake in found.wiring]) == ("wiring", [WIRED[defect.name]])
        return
    assert found.verdict == "insufficient"
    assert any(message in found.sentence for message in refused)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [11, 12])
@pytest.mark.parametrize("defect", DEFECTS, ids=lambda defect: defect.name)
def test_no_defect_of_a_log_is_taken_for_a_fault_of_the_machine(defect, seed):
    recording = damaged(defect, seed)
    if recording is None:
        pytest.skip("no recording of two_link can have this")
    allowed = ("insufficient", "none") if defect.name in (*HARMLESS, *MENDED) else ("insufficient", "wiring")
    allowed += ("unknown",) if defect.name == BRIDGED else ()
    assert verdict_of(recording) in allowed
