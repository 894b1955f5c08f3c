"""A log that is refused is left out with its reason, the others are used; a check that is overruled is told."""

import gzip
import os
from pathlib import Path

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.logs import read_logs
from ffgym.logs.quality import check_quality, condition, judge_logs
from tests.logs.quality.conditioning.troubles import bad_row, clean, jittered, thin
from tests.logs.quality.quality_logs import described

EFFORT = "motor.effort.elbow"


def robot():
    return described("two_link", "multisine")


def coarse():
    torque = clean()[EFFORT]
    step = np.ptp(torque) / 100
    return clean().with_columns({EFFORT: np.round(torque / step) * step}).rename("coarse")


def test_a_refused_log_is_left_out_with_its_reason_and_the_others_are_used():
    spiky = bad_row(clean(), EFFORT, 4000).rename("spiky")
    found = judge_logs([clean(), coarse(), spiky], robot(), ("diagnosis",))
    assert [recording.header.segment for recording in found.recordings] == ["multisine", "spiky"]
    assert found.recordings[0] is not None
    assert np.flatnonzero(~found.recordings[1].valid[:, 1]).tolist() == [4000]
    (sentence,) = found.left_out
    assert sentence.startswith("coarse was left out: For diagnosis: motor.effort.elbow has ")
    assert "must have at least 300" in sentence
    assert found.flagged[0] == sentence
    assert any(text.startswith("spiky: Single rows that stick out") for text in found.flagged)


def test_an_overruled_check_leaves_the_log_in_and_is_told():
    found = judge_logs([coarse()], robot(), ("diagnosis",), accept=("coarse",))
    assert [recording.header.segment for recording in found.recordings] == ["coarse"]
    assert not found.left_out
    assert any("motor.effort.elbow has" in text for text in found.flagged)


def test_what_a_check_refuses_is_flagged_where_it_is_overruled_and_stops_no_other():
    torque = clean()[EFFORT]
    half = 0.2 * np.ptp(torque)
    middle = 0.5 * (torque.max() + torque.min())
    cut = clean().with_columns({EFFORT: np.clip(torque, middle - half, middle + half)})
    assert check_quality(cut, robot()).of("clipped")[0].verdict == "refused"
    report = check_quality(cut, robot(), accept=("clipped",))
    (finding,) = report.of("clipped")
    assert finding.verdict == "flagged"
    assert finding.message.startswith("Accepted, though refused by clipped: motor.effort.elbow stays at")
    assert not any("'values' is refused" in finding.message for finding in report.findings)


def test_an_unknown_check_is_one_error():
    with pytest.raises(FFGymError, match="Unknown check 'cores'"):
        judge_logs([clean()], robot(), accept=("cores",))


def test_uneven_logs_come_to_the_period_of_the_others():
    """Two of them have median intervals of 10 and 12 ms; the third is even."""
    logs = [jittered(clean(), (10, 10, 12)), jittered(clean(), (12, 12, 10)).rename("b"), thin(clean()).rename("c")]
    assert [round(condition(log).dt, 4) for log in logs] == [0.01, 0.012, 0.01]
    assert {round(log.dt, 6) for log in judge_logs(logs, robot()).recordings} == {0.01}


MAP = """
[log]
robot = "six_axes"
joints = ["j1", "j2", "j3", "j4", "j5", "j6"]
gear_ratio = [101.0, 101.0, 101.0, 101.0, 101.0, 101.0]
position_side = "link"
torque_semantics = "link_side"
hold = "sampled"
[file]
names_row = 0
[columns.timestamp]
source = "1"
unit = "s"
[columns."motor.position"]
source = ["2", "3", "4", "5", "6", "7"]
unit = "rad"
[columns."motor.velocity"]
source = ["8", "9", "10", "11", "12", "13"]
unit = "rad/s"
[columns."motor.effort"]
source = ["14", "15", "16", "17", "18", "19"]
scale = [14.87, 13.26, 11.13, 10.62, 11.03, 11.47]
unit = "N m"
[columns."command.effort"]
source = ["20", "21", "22", "23", "24", "25"]
scale = [14.87, 13.26, 11.13, 10.62, 11.03, 11.47]
unit = "N m"
"""
"""Clock, positions, speeds, currents and target currents, as the files of the data set hold them."""


@pytest.mark.skipif(not os.environ.get("FFGYM_DATA"), reason="set FFGYM_DATA to the folder with published recordings")
def test_logs_of_a_real_robot_pass_as_they_were_recorded(tmp_path):
    """Rows every 10 or 12 ms, missing and doubled ones, stops, a file without a final newline."""
    (tmp_path / "map.toml").write_text(MAP, encoding="utf-8")
    files = sorted(Path(os.environ["FFGYM_DATA"], "ur10e").glob("*.csv.gz"))
    assert len(files) == 12
    assert sum(not gzip.decompress(file.read_bytes()).endswith(b"\n") for file in files) == 1
    raw = [recording for file in files for recording in read_logs(file, tmp_path / "map.toml")]
    assert [one.header.segment for one in raw] == [file.name.removesuffix(".csv.gz") for file in files]
    assert all(np.ptp(np.diff(one.t)) > 0.1 * one.dt for one in raw)
    found = judge_logs(raw, None, ("diagnosis",))
    assert not found.left_out
    assert len(found.recordings) == 12
    for one in found.recordings:
        assert one.dt == pytest.approx(0.01)
        assert np.ptp(np.diff(one.t)) < 1e-6
        assert one.valid.mean() > 0.99
        assert condition(one) is one
