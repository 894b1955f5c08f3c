"""Wrongly wired logs: the command names the mistake, and with the map that it writes ends as for right logs."""

from ffgym.cli.main import main
from ffgym.diagnosis.diagnosis_file import read_diagnosis
from ffgym.recordings import write_recording
from ffgym.robot import load_robot
from tests.logs.quality.wiring.wiring_samples import clean, mistakes

ROBOT = "two_link"


def test_wiring_is_named_mended_by_the_map_and_then_the_logs_are_diagnosed(tmp_path, capsys):
    made = mistakes(load_robot(ROBOT))["sign of channels, one"]
    (tmp_path / "logs").mkdir()
    for i, log in enumerate(made.to(clean(ROBOT))):
        write_recording(log, tmp_path / "logs" / f"{i}.npz")
    folder = str(tmp_path / "out")
    assert main(["diagnose", str(tmp_path / "logs"), "--robot", ROBOT, "--out", folder]) == 0
    told = capsys.readouterr().out
    assert told.startswith("wiring: ")
    assert "All channels of elbow: wrong sign" in told
    found = read_diagnosis(tmp_path / "out" / "diagnosis.json")
    assert (found.verdict, found.causes, [m.kind for m in found.wiring]) == ("wiring", (), ["sign"])
    mended = ["--columns", str(tmp_path / "out" / "columns.toml")]
    assert main(["diagnose", str(tmp_path / "logs"), "--robot", ROBOT, *mended]) == 0
    assert capsys.readouterr().out.startswith("none: ")
    assert main(["log", "check", str(tmp_path / "logs"), "--robot", ROBOT]) != 0
    assert "wiring of all logs: All channels of elbow: wrong sign" in capsys.readouterr().out
