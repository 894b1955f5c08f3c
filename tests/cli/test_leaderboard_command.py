import json
import subprocess
import sys
import time

import pytest

from ffgym.cli.main import main
from ffgym.leaderboard.plants import find_plant

SMALL = ["--plants", "nominal", "--splits", "speeds", "--jobs", "1"]


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A small leaderboard: folder with results, page and numbers, and what was printed."""
    folder = tmp_path_factory.mktemp("board")
    command = [sys.executable, "-m", "ffgym", "leaderboard", "--agents", "elastic", "oracle", *SMALL]
    command += ["--out", str(folder / "rows"), "--page", str(folder / "page.html"), "--json", str(folder / "all.json")]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return folder, done.stdout


def test_it_prints_the_standings_and_what_the_bare_engine_takes(finished):
    _, printed = finished
    assert "elastic" in printed
    assert "none" in printed  # it always takes part
    assert "times what the bare engine takes for it on all cores" in printed


def test_the_numbers_have_a_row_for_every_circle_as_those_of_the_demo(finished):
    folder, _ = finished
    numbers = json.loads((folder / "all.json").read_text())
    assert numbers["physics_fingerprint"] == find_plant("nominal").fingerprint
    assert numbers["versions"]["mujoco"]
    rows = numbers["rows"]
    assert len(rows) == 3 * 6
    row = next(row for row in rows if row["agent"] == "elastic")
    assert row["seed"] == 0
    assert row["plant_draw"] is None
    assert row["split"] == "speeds"
    assert row["track"] == "causal, nominal parameters"
    assert row["robot_seconds"] == 0.0
    assert row["inference_us"] > 0
    as_demo = {"agent", "plant", "position", "radius_mm", "speed_mm_s", "rms_mm", "max_mm", "rms_3d_mm", "max_3d_mm"}
    assert as_demo | {"motor_rms_rad"} <= set(row)
    assert numbers["times"]["wall_s"] > 0


def test_the_page_is_one_file_that_asks_nobody(finished):
    folder, _ = finished
    text = (folder / "page.html").read_text()
    assert "elastic feed-forward" in text
    assert "http://" not in text.replace("http://www.w3.org", "")


def test_a_second_run_runs_nothing(finished, capsys):
    folder, _ = finished
    assert main(["leaderboard", "--agents", "elastic", "oracle", *SMALL, "--out", str(folder / "rows")]) == 0
    printed = capsys.readouterr().out
    assert "elastic" in printed
    assert "bare engine" not in printed


def test_every_selection_that_was_run_is_printed_and_the_page_names_all_plants(tmp_path, capsys):
    command = ["leaderboard", "--agents", "none", "--jobs", "1", "--out", str(tmp_path / "rows")]
    assert main([*command, "--plants", "draw:3", "--splits", "radii", "speeds"]) == 0
    printed = capsys.readouterr().out
    assert "drawn robots; held-out radii" in printed
    assert "drawn robots; held-out speeds" in printed
    assert main([*command, "--plants", "nominal", "--splits", "speeds", "--page", str(tmp_path / "page.html")]) == 0
    page = (tmp_path / "page.html").read_text()
    assert find_plant("draw:3").fingerprint in page
    assert find_plant("nominal").fingerprint in page


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--agents", "best"], "Unknown agent 'best'"),
        (["--plants", "moon"], "Unknown plant 'moon'"),
        (["--plants", "draw:00"], "Unknown plant 'draw:00'"),
        (["--plants", "draw:" + "9" * 5000], "Unknown plant 'draw:999"),
        (["--out", ".", "--json", "none.json"], "lies among the result files of --out"),
        (["--splits", "all-of-it"], "Unknown split 'all-of-it'"),
        (["--seeds", "0"], "--seeds = 0"),
        (["--draws", "-1"], "--draws = -1"),
        (["--jobs", "-2"], "jobs = -2"),
        (["--address", "auto"], "choose the executor 'ray'"),
        (["--page", "nowhere/page.html"], "does not exist"),
        (["--json", "numbers.txt"], "must end in .json"),
        (["--adaptation", "curve.json", "--json", "curve.json"], "is read by this command and would be lost"),
    ],
)
def test_bad_input_ends_with_one_line_that_names_it(arguments, reason, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["leaderboard", *arguments]) == 1
    error = capsys.readouterr().err
    assert reason in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_page_that_is_not_html_is_refused(tmp_path, capsys):
    assert main(["leaderboard", "--page", str(tmp_path / "machine.toml")]) == 1
    assert "must end in .html" in capsys.readouterr().err


def test_killed_while_it_builds_the_page_it_leaves_a_whole_one_or_none(finished, tmp_path):
    folder, _ = finished
    page = tmp_path / "page.html"
    command = [sys.executable, "-m", "ffgym", "leaderboard", "--agents", "elastic", "oracle", *SMALL]
    command += ["--out", str(folder / "rows"), "--page", str(page)]
    for wait in (0.5, 1.5, 2.0, 2.5):
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(wait)
        process.kill()
        process.wait()
        assert not page.exists() or page.read_text().rstrip().endswith("</html>")
        page.unlink(missing_ok=True)
    subprocess.run(command, check=True, capture_output=True)
    assert tables(page.read_text()) == tables((folder / "page.html").read_text())


def tables(page):
    """The page without the lines that say what was written where."""
    places = tuple(f'<tr><th class="l">{name}' for name in ("json", "page", "command line"))
    return [line for line in page.splitlines() if not line.startswith(places)]
