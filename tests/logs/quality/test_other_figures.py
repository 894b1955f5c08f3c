"""Checks that no listed defect is about: payload, rates, frames, phases, saturation, set-points ahead of motors."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.logs.quality import check_quality
from ffgym.recordings import Phase, Recording
from ffgym.robot import load_robot
from tests.diagnosis.identification.rigid_body.recorded_arms import recorded, rigid, swing
from tests.logs.quality.quality_logs import clean_log, described

ROBOT, MOTION = "irb4600_60_205", "multisine"


@pytest.fixture(scope="module")
def clean() -> Recording:
    return clean_log(ROBOT, MOTION)


def flagged(recording: Recording, robot=None) -> set[str]:
    return {finding.check for finding in check_quality(recording, robot).problems}


def test_another_payload_in_the_header(clean):
    payload = {"mass": 40.0}
    assert flagged(Recording(clean.columns, replace(clean.header, payload=payload)), described(ROBOT, MOTION)) == {
        "payload"
    }


def test_a_rate_too_low_for_the_arm(clean):
    thin = {name: values[::40] for name, values in clean.columns.items()}
    found = flagged(Recording(thin, replace(clean.header, phases=())), described(ROBOT, MOTION))
    assert "rate_for_resonance" in found


def test_a_tracker_in_its_own_frame(clean):
    x, y = clean["tcp.position.x"], clean["tcp.position.y"]
    turned = clean.with_columns({"tcp.position.x": -y, "tcp.position.y": x})
    assert flagged(turned) == {"tracker_frame"}


def test_a_tracker_whose_clock_counts_milliseconds(clean):
    slow = clean.with_columns({"tcp.timestamp": 1000 * clean["tcp.timestamp"]})
    assert flagged(slow) == {"tracker_clock"}


def test_a_phase_of_rest_in_which_joints_move(clean):
    phases = (Phase(label="wait", kind="standstill", start=2.0, end=4.0),)
    assert flagged(Recording(clean.columns, replace(clean.header, phases=phases))) == {"phases"}


def test_motors_that_give_all_they_have(clean):
    robot = described(ROBOT, MOTION)
    weak = replace(robot, drive=replace(robot.drive, peak_torque=robot.drive.peak_torque / 10))
    assert "saturation" in flagged(clean, weak)


def test_motors_ahead_of_their_set_points():
    clean = clean_log("one_axis", "ladder")
    rows = 40
    late = {}
    for name in ("reference.position.j1", "reference.velocity.j1"):
        late[name] = np.concatenate([clean[name][:1].repeat(rows), clean[name][:-rows]])
    assert "reference_lag" in flagged(clean.with_columns(late))


def test_torques_of_one_joint_that_are_late_beside_those_of_the_others(clean):
    """All of them may be a row behind the command; one alone is not of the same rows."""
    late = {name: np.r_[x[:1], x[:-1]] for name, x in clean.columns.items() if name.startswith("motor.effort.")}
    assert flagged(clean.with_columns(late)) == {"lag"}
    one = {"motor.effort.j3": late["motor.effort.j3"]}
    report = check_quality(clean.with_columns(one), needs=["diagnosis"])
    assert {finding.check for finding in report.problems} == {"lag", "torque_lag_apart", "need_diagnosis"}
    assert {finding.columns[0] for finding in report.of("torque_lag_apart")} == {"motor.effort.j3"}


def test_which_of_two_joints_has_the_late_torque_is_not_known():
    clean = clean_log("two_link", MOTION)
    late = clean.with_columns(
        {"motor.effort.elbow": np.r_[clean["motor.effort.elbow"][:1], clean["motor.effort.elbow"][:-1]]}
    )
    (finding, *_) = check_quality(late, needs=["diagnosis"]).of("torque_lag_apart")
    assert finding.verdict == "flagged"
    assert {"motor.effort.elbow", "motor.effort.shoulder"} <= set(finding.columns)


def test_numbers_that_no_machine_gives(clean):
    values = clean["motor.effort.j2"].copy()
    values[0] = 1e40
    assert flagged(clean.with_columns({"motor.effort.j2": values})) == {"size"}


@pytest.mark.parametrize("side", ["motor_side", "link_side"])
def test_a_motor_that_turns_the_other_way_has_its_friction_the_other_way(side):
    """A negative gear ratio: torque at the motor opposes the motor, torque behind the gearbox the joint."""
    two_link = rigid(load_robot("two_link"))
    ratio = two_link.drive.gear_ratio * np.array([-1.0, 1.0])
    robot = replace(two_link, drive=replace(two_link.drive, gear_ratio=ratio), logs=replace(two_link.logs, torque=side))
    log = recorded(robot, swing(robot, 0), noise=0.005, segment="swing")
    assert check_quality(log, robot).verdict == "good"
    assert not flagged(log)
    turned = log.with_columns({"motor.effort.shoulder": -log["motor.effort.shoulder"]})
    assert "torque_sign" in flagged(turned)
