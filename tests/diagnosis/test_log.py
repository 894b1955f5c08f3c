"""Rows that a mask leaves out, and parts of a motion."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis import diagnose
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.residual_rows import find_counting_rows, find_valid_rows
from ffgym.recordings import Recording
from tests.logs.quality.quality_logs import clean_log, described

SHOULDER, ELBOW = 0, 1
FIRST, LAST = 4000, 4010


def log_with(shoulder: bool, elbow: bool):
    recording = clean_log("two_link", "multisine")
    mask = np.ones(len(recording))
    mask[FIRST:LAST] = 0.0
    whole = np.ones(len(recording))
    masks = {"valid.shoulder": mask if shoulder else whole, "valid.elbow": mask if elbow else whole}
    return assemble_log(described("two_link", "multisine"), [recording.with_columns(masks)])


def within_reach(log) -> np.ndarray:
    """Rows whose low-pass reaches the samples that are left out, shape (R, 1)."""
    sampling = log.sampling
    near = (sampling.at + sampling.half_length >= FIRST) & (sampling.at - sampling.half_length < LAST)
    return near[:, None]


@pytest.fixture(scope="module")
def whole():
    return assemble_log(described("two_link", "multisine"), [clean_log("two_link", "multisine")])


def test_a_mask_of_one_joint_takes_out_its_torque_alone(whole):
    log = log_with(shoulder=False, elbow=True)
    before, after = find_counting_rows(whole), find_counting_rows(log)
    assert within_reach(log).sum() > 3
    assert np.array_equal(after["torque", ELBOW], before["torque", ELBOW] & ~within_reach(log))
    assert before["torque", ELBOW][within_reach(log)].any()
    for key in before:
        if key != ("torque", ELBOW):
            assert np.array_equal(after[key], before[key])
    assert np.array_equal(find_valid_rows(log), find_valid_rows(whole))


def test_a_mask_of_all_joints_takes_the_rows_out_of_everything(whole):
    log = log_with(shoulder=True, elbow=True)
    assert np.array_equal(find_valid_rows(log), find_valid_rows(whole) & ~within_reach(log))
    for key, rows in find_counting_rows(log).items():
        assert np.array_equal(rows, find_counting_rows(whole)[key] & ~within_reach(log))


def test_without_a_mask_all_rows_count(whole):
    log = log_with(shoulder=False, elbow=False)
    log = assemble_log(
        log.robot, [log.recordings[0].with_columns({f"valid.{j}": np.ones(whole.lengths[0]) for j in log.robot.joints})]
    )
    for key, rows in find_counting_rows(whole).items():
        assert np.array_equal(rows, find_counting_rows(log)[key])


ROBOT, MOTION = "one_axis", "multisine"


def on_a_later_clock(recording, seconds):
    phases = tuple(replace(p, start=p.start + seconds, end=p.end + seconds) for p in recording.header.phases)
    columns = dict(recording.columns) | {"timestamp": recording.t + seconds}
    return Recording(columns, replace(recording.header, phases=phases))


@pytest.mark.parametrize(
    "part",
    [
        lambda whole: on_a_later_clock(whole, 1000.0),
        lambda whole: whole.slice(end=6.7263),
        lambda whole: whole.slice(start=2.0),
    ],
    ids=["later clock", "cut short", "begun late"],
)
def test_nothing_is_found_in_any_part_of_a_clean_log(part):
    recording = part(clean_log(ROBOT, MOTION))
    assert recording.header.phases
    assert diagnose(described(ROBOT, MOTION), [recording]).verdict == "none"
