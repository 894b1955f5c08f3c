"""The gate: verdicts, stages, needs, figures of coverage, and its documentation."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.logs.quality import CHECKS, NEEDS, check_quality
from ffgym.recordings import Header, Recording
from tests.logs.quality.defects import DEFECTS
from tests.logs.quality.quality_logs import clean_log, described

DOCS = Path(__file__).parents[3] / "docs" / "quality.md"


def one_joint(position: np.ndarray, **columns: np.ndarray) -> Recording:
    t = 0.001 * np.arange(len(position))
    header = Header(robot="bench", joints=("j1",), gear_ratio=(1.0,), torque_semantics="motor_side", hold="sampled")
    named = {name.replace("__", "."): values for name, values in columns.items()}
    return Recording({"timestamp": t, "motor.position.j1": position, **named}, header)


def test_a_check_that_has_no_answer_says_why():
    report = check_quality(one_joint(np.sin(np.arange(4000) / 500)))
    (finding,) = report.of("torque_units")
    assert finding.verdict == "not judged"
    assert "needs the robot" in finding.message


def test_what_is_refused_stops_later_stages():
    position = np.sin(np.arange(4000) / 500)
    position[1700:] += 1.0
    report = check_quality(one_joint(position))
    assert [finding.check for finding in report.problems] == ["jump"]
    assert all(finding.verdict == "not judged" for finding in report.of("torque_lag"))
    assert "'values'" in report.of("torque_lag")[0].message


@pytest.mark.parametrize(("step", "checks"), [(1e-11, []), (1e-6, ["jump"])])
def test_rounding_of_a_set_point_that_stands_is_no_jump(step, checks):
    height = np.full(4000, 1.2345)
    height[::3] += 1e-16  # of its last digits
    height[1700:] += step
    position = np.sin(np.arange(4000) / 500)
    report = check_quality(one_joint(position, **{f"tcp_reference__position__{axis}": height for axis in "xyz"}))
    assert sorted({finding.check for finding in report.problems if "tcp_reference" in finding.message}) == checks


def test_worst_findings_come_first_and_every_check_is_named():
    report = check_quality(clean_log("two_link", "multisine"), described("two_link", "multisine"))
    assert report.verdict == "good"
    assert {finding.check for finding in report.findings} == {check.name for check in CHECKS}


def test_coverage_counts_what_was_put_in():
    t = 0.001 * np.arange(12000)
    strokes = np.concatenate([np.linspace(0, 1, 2000), np.ones(2000), np.linspace(1, 0, 4000), np.linspace(0, 1, 4000)])
    report = check_quality(one_joint(strokes[: len(t)]))
    figures = {finding.check: finding.value for finding in report.findings if finding.joint == "j1"}
    assert figures["reversals"] == 2
    assert figures["top_speed"] == pytest.approx(0.5, rel=0.01)
    assert figures["speed_ratio"] == pytest.approx(2.0, rel=0.01)
    assert figures["longest_rest"] == pytest.approx(2.0, rel=0.02)
    assert figures["both_ways"] == pytest.approx(0.4, abs=0.01)
    assert figures["travel"] == pytest.approx(1.0, rel=0.01)


@pytest.mark.parametrize("need", NEEDS)
def test_a_need_that_no_column_serves_is_refused(need):
    recording = one_joint(np.zeros(2000))
    header = replace(recording.header, torque_semantics="unspecified")
    columns = {"timestamp": recording.t, "reference.velocity.j1": recording["motor.position.j1"]}
    report = check_quality(Recording(columns, header), needs=[need])
    assert [f.verdict for f in report.of(f"need_{need}")] == ["refused"]


def test_a_need_that_some_joints_serve_is_flagged_for_the_others():
    recording = clean_log("two_link", "ladder")
    assert [f.verdict for f in check_quality(recording, needs=["friction"]).of("need_friction")] == ["ok"]
    name = "motor.position.elbow"
    still = recording.with_columns(**{name: np.full(len(recording), recording[name][0])})
    (finding,) = check_quality(still, needs=["friction"]).of("need_friction")
    assert (finding.verdict, finding.joint) == ("flagged", "elbow")


def test_a_use_that_bears_less_than_others_refuses_what_is_flagged():
    recording = clean_log("two_link", "multisine")
    columns = {name: np.r_[x[:3000], x[2999:-1]] for name, x in recording.columns.items() if name != "timestamp"}
    twice = recording.with_columns(columns)
    assert [(f.check, f.verdict) for f in check_quality(twice).problems] == [("repeated_rows", "flagged")]
    (finding,) = check_quality(twice, needs=["diagnosis"]).of("need_diagnosis")
    assert finding.verdict == "ok"  # the copy is dropped before
    torque = recording["motor.effort.elbow"]
    step = np.ptp(torque) / 200
    coarse = recording.with_columns(**{"motor.effort.elbow": np.round(torque / step) * step})
    assert [(f.check, f.verdict) for f in check_quality(coarse).problems] == [("coarse", "flagged")]
    assert [f.verdict for f in check_quality(coarse, needs=["friction"]).of("need_friction")] != ["refused"]
    (finding,) = check_quality(coarse, needs=["diagnosis"]).of("need_diagnosis")
    assert finding.verdict == "refused"
    assert finding.message.startswith("For diagnosis: motor.effort.elbow has 2")
    (finding,) = check_quality(coarse, needs=["diagnosis"], accept=["coarse"]).of("need_diagnosis")
    assert finding.verdict == "ok"


def test_unknown_needs_and_things_that_are_no_recordings_are_refused():
    with pytest.raises(FFGymError, match="Unknown need 'luck'"):
        check_quality(one_joint(np.zeros(100)), needs=["luck"])
    with pytest.raises(FFGymError, match="read_recording"):
        check_quality("log.npz")  # type: ignore[arg-type]


@pytest.mark.parametrize("rows", [2, 3, 10, 30, 70])
def test_short_logs_are_judged_without_complaint_of_numpy(rows):
    position = np.linspace(0, 1, rows)
    report = check_quality(one_joint(position, motor__velocity__j1=np.ones(rows), motor__effort__j1=position))
    assert report.n_rows == rows


def test_every_check_has_a_defect_or_is_a_figure():
    named = {check for defect in DEFECTS for check in defect.checks}
    others = {  # tested where their machines are: other robots, mountings, rates; or figures only
        *(
            "size",
            "joint_count",
            "robot_name",
            "payload",
            "gravity_direction",
            "torque_model",
            "saturation",
            "joint_speed",
            "masked",
            "nothing_left",
        ),
        *("tracker_frame", "tracker_clock", "reference_lag", "phases", "rate_for_resonance", "rate_for_motion"),
    }
    figures = {check.name for check in CHECKS if check.flag is None}
    assert {check.name for check in CHECKS} <= named | others | figures


def test_the_page_says_how_many_defects_are_listed():
    page = DOCS.read_text(encoding="utf-8")
    assert re.search(rf"on {len(DEFECTS)} listed defects", page)
