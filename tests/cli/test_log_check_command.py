"""`ffgym log check`: what it prints, writes and returns."""

import json
import re
from importlib import resources

import numpy as np
import pytest

from ffgym.cli.main import main
from ffgym.recordings import write_recording
from tests.logs.quality.quality_logs import clean_log


@pytest.fixture
def logs(tmp_path):
    recording = clean_log("two_link", "multisine")
    good, bad = tmp_path / "good.npz", tmp_path / "bad.npz"
    write_recording(recording, good)
    degrees = recording.with_columns({"motor.position.elbow": np.degrees(recording["motor.position.elbow"])})
    write_recording(degrees, bad)
    return good, bad


def test_good_logs_succeed(logs, capsys):
    assert main(["log", "check", str(logs[0]), "--robot", "two_link", "--figures"]) == 0
    out = capsys.readouterr().out
    assert "Good: every check that could be judged passed." in out
    assert "torque_model" in out


def test_a_good_log_has_one_line(logs, capsys):
    assert main(["log", "check", str(logs[0]), "--robot", "two_link"]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    assert line.startswith(f"{logs[0]}: two_link, ")
    assert re.search(r"Good: every check that could be judged passed. \d+ checks not judged.$", line)


def test_a_folder_is_all_its_logs(logs, capsys):
    assert main(["log", "check", str(logs[0].parent)]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in lines if "rows," in line] == sorted(map(str, logs))
    assert lines[-1] == "2 logs: 1 good, 0 usable, 1 insufficient."


def test_an_insufficient_log_fails_after_all_are_told_and_written(logs, tmp_path, capsys):
    place = tmp_path / "quality.json"
    assert main(["log", "check", *map(str, logs), "--json", str(place)]) == 1
    printed = capsys.readouterr()
    assert "refused: [units] motor.position.elbow is 57.29" in " ".join(printed.out.split())
    assert printed.err.count("\n") == 1
    assert "bad.npz" in printed.err
    assert "good.npz" not in printed.err
    written = json.loads(place.read_text())
    assert [log["verdict"] for log in written["logs"]] == ["good", "insufficient"]
    assert written["versions"]


def test_what_conditioning_does_is_told_and_written(logs, tmp_path, capsys):
    recording = clean_log("two_link", "multisine")
    torque = recording["motor.effort.elbow"].copy()
    torque[4000] += 2 * np.ptp(torque)
    write_recording(recording.with_columns({"motor.effort.elbow": torque}), logs[1])
    place, page = tmp_path / "quality.json", tmp_path / "quality.html"
    options = ["--needs", "diagnosis", "--json", str(place), "--report", str(page)]
    assert main(["log", "check", str(logs[1]), "--robot", "two_link", *options]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "conditioned: Single rows that stick out were replaced" in out
    assert "flagged: [spike] Mended or left out: motor.effort.elbow: " in out
    (written,) = json.loads(place.read_text())["logs"]
    assert written["verdict"] == "usable"
    assert written["conditioning"][0].startswith("Single rows that stick out")
    assert "Conditioned: Single rows that stick out" in page.read_text()


def test_needs_are_judged(logs, capsys):
    assert main(["log", "check", str(logs[0]), "--needs", "temperature"]) == 1
    assert "temperature is missing" in capsys.readouterr().out


def test_the_page_holds_verdict_figures_and_picture(logs, tmp_path):
    place = tmp_path / "quality.html"
    assert main(["log", "check", *map(str, logs), "--report", str(place)]) == 1
    page = place.read_text()
    assert page.count("data:image/svg+xml") == 2
    assert "degrees for radians" in page
    assert "<p>2 logs: 1 <b>good</b>, 1 <b>insufficient</b>.</p>" in page
    assert page.index("How to read this page") < page.index("2 logs:")
    row = f'<td class="l">{logs[1]}</td><td class="l">multisine</td><td>8.6</td><td class="l refused">insufficient</td>'
    assert f'{row}<td class="wrap">units</td><td class="wrap">encoder_steps</td>' in page
    good, bad = page.index('id="limits-1"'), page.index('id="limits-2"')

    assert "<summary>Every figure</summary>" in page[:good]
    assert page[page.index(f"<h2>{logs[1]}") : bad].count("<details>") == 0


def test_bad_input_is_one_line(tmp_path, capsys):
    for arguments in (["nothing.npz"], [str(tmp_path)], [str(tmp_path / "x.npz"), "--robot", "nobody"]):
        assert main(["log", "check", *arguments]) == 1
        assert capsys.readouterr().err.count("\n") == 1


def test_a_description_that_lacks_entries_judges_what_does_not_hang_on_them(logs, tmp_path, capsys):
    text = (resources.files("ffgym.robot") / "data" / "two_link.toml").read_text(encoding="utf-8")
    description = tmp_path / "mine.toml"
    description.write_text("\n[".join(part for part in text.split("\n[") if not part.startswith("friction.")))
    assert main(["log", "check", str(logs[0]), "--robot", str(description), "--needs", "position"]) == 0
    out = capsys.readouterr().out
    assert f"note: {description} lacks friction.coulomb and 5 more; nothing is judged that hangs on masses" in out
    assert "Good: every check that could be judged passed." in out
