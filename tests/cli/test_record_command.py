"""`ffgym record`: protocols in, a folder of recordings out, which can be interrupted and goes on."""

import json
import re

import numpy as np
import pytest

import ffgym.simulation.protocols.recording_folder as recording_folder
from ffgym.cli.main import main
from ffgym.effects import EFFECTS
from ffgym.recordings import read_folder, read_recording
from ffgym.simulation.plant import Machine, save_machine
from ffgym.simulation.protocols import PROTOCOLS
from tests.cli.errors import read_error

STEPS = """
[[step]]
protocol = "slow_triangles"
sizes = [2.0]
period = 1.0
periods = 1

[[step]]
motion = "sine"
"""
COULOMB = '[friction.coulomb]\nvalue = [{}]\nunit = "N m"\nside = "motor"\norigin = "chosen"\nsource = "test"\n'
NAMES = ["slow_triangles.j1.bristles_x2", "slow_triangles.j1.sliding", "motion.sine"]


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "day.toml").write_text(STEPS)
    return tmp_path


def run(*arguments):
    return main(["record", *arguments])


def record(*options):
    return run("one_axis", "day.toml", "--out", "day", *options)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_session_is_a_folder_of_recordings_and_an_index_that_says_where_they_come_from(here, capsys):
    assert record("--seed", "4", "--json", "day.json") == 0
    assert {path.stem for path in (here / "day").glob("*.npz")} == {*NAMES}
    recordings = read_folder("day")
    assert [r.header.segment for r in recordings] == NAMES
    index = json.loads((here / "day" / "protocol.json").read_text())
    assert (index["command"], index["robot"], index["seed"]) == ("ffgym record", "one_axis", 4)
    assert index["config"]["protocols"] == ["day.toml"]
    assert index["versions"].keys() == {"ffgym", "mujoco", "numpy", "scipy", "gymnasium", "python"}
    for entry, recording in zip(index["motions"], recordings, strict=True):
        header = recording.header
        assert entry["session_start"] == header.meta["session_start"]
        assert entry["duration"] == pytest.approx(recording.t[-1], abs=1e-9)
        assert header.provenance["session"] == index["session"]
        assert header.provenance["physics_fingerprint"] == index["physics_fingerprint"]
        assert not recording.has("friction.effort")
    numbers = json.loads((here / "day.json").read_text())
    assert (numbers["made"], numbers["kept"], numbers["folder"]) == (3, 0, "day")
    printed = capsys.readouterr().out
    assert "3 recordings of 3 made" in printed
    assert "protocol.json" in printed


def test_what_is_complete_is_not_made_again_and_what_is_missing_comes_out_the_same(here, capsys):
    assert record() == 0
    first = contents(here / "day")
    stamps = {path.name: path.stat().st_mtime_ns for path in (here / "day").glob("*.npz")}
    (here / "day" / "motion.sine.npz").unlink()
    (here / "day" / f"{NAMES[0]}.npz").write_bytes(b"damaged")
    assert record("--threads", "1") == 0
    assert "2 recordings of 3 made, 1 were complete before" in capsys.readouterr().out
    assert contents(here / "day") == first
    kept = here / "day" / f"{NAMES[1]}.npz"
    assert kept.stat().st_mtime_ns == stamps[kept.name]


def test_an_interrupted_session_leaves_complete_files_and_goes_on(here, capsys, monkeypatch):
    write, written = recording_folder.write_recording, []

    def interrupted(recording, path):
        if written:
            raise KeyboardInterrupt
        written.append(path)
        write(recording, path)

    with monkeypatch.context() as patched:
        patched.setattr(recording_folder, "write_recording", interrupted)
        assert record() == 130
    assert {path.name for path in (here / "day").iterdir()} == {"protocol.json", f"{NAMES[0]}.npz"}
    assert record() == 0
    assert "2 recordings of 3 made, 1 were complete before" in capsys.readouterr().out
    assert len(read_folder("day")) == 3


def test_a_folder_of_another_session_is_refused_unless_it_may_be_written_over(here, capsys):
    assert record() == 0
    before = contents(here / "day")
    for options in (["--seed", "1"], ["--record-dt-ms", "4"], ["--feedforward", "lugre_static"], ["--exact"]):
        assert record(*options) == 1
        assert "day: holds a session of other motions, options or versions" in read_error(capsys)
    assert contents(here / "day") == before
    assert record("--seed", "1", "--force") == 0
    assert read_folder("day")[0].header.provenance["seed"] == 1


def test_a_session_of_which_nothing_was_recorded_keeps_no_other_out(here, capsys):
    assert record("--record-dt-ms", "0.3") == 1
    assert not (here / "day").exists()
    (here / "day").mkdir()
    (here / "day" / "protocol.json").write_text('{"session": "stopped before its first recording"}')
    assert record() == 0
    assert len(read_folder("day")) == 3


def test_what_cannot_be_run_costs_no_recording_that_was_to_be_written_over(here, capsys):
    assert record() == 0
    before = contents(here / "day")
    assert record("--record-dt-ms", "0.3", "--force") == 1
    assert contents(here / "day") == before


def test_a_damaged_index_is_refused_unless_the_folder_may_be_written_over(here, capsys):
    assert record() == 0
    (here / "day" / "protocol.json").write_bytes(b"\xff")
    capsys.readouterr()
    assert record() == 1
    assert "day: its protocol.json is damaged" in read_error(capsys)
    assert record("--force") == 0
    assert len(read_folder("day")) == 3


def test_a_place_that_cannot_be_written_over_is_named(here, capsys):
    (here / "day" / "motion.sine.npz").mkdir(parents=True)
    assert record("--force") == 1
    assert "motion.sine.npz: cannot be removed: " in read_error(capsys)


def test_the_index_is_no_place_for_the_numbers(here, capsys):
    assert record() == 0
    before = contents(here / "day")
    assert record("--json", "day/protocol.json") == 1
    assert "--json and the index of the recordings are both day/protocol.json" in capsys.readouterr().err
    assert contents(here / "day") == before


def test_a_law_whose_numbers_have_changed_makes_another_session(here, capsys):
    law = ["--feedforward", "lugre_static", "--parameters", "small.toml"]
    (here / "small.toml").write_text(COULOMB.format(0.1))
    assert record(*law) == 0
    (here / "small.toml").write_text(COULOMB.format(0.2))
    assert record(*law) == 1
    assert "holds a session of other motions" in read_error(capsys)


def test_a_folder_with_recordings_of_ones_own_is_left_alone(here, capsys):
    (here / "day").mkdir()
    (here / "day" / "mine.csv").write_text("precious")
    assert record() == 1
    assert "holds recordings, but no protocol.json" in read_error(capsys)
    assert contents(here / "day") == {"mine.csv": b"precious"}


def test_a_recording_of_another_session_under_one_of_the_names_is_not_written_over(here, capsys):
    assert record() == 0
    assert run("one_axis", "day.toml", "--out", "other", "--seed", "1") == 0
    capsys.readouterr()
    (here / "other" / "motion.sine.npz").replace(here / "day" / "motion.sine.npz")
    assert record() == 1
    assert "motion.sine.npz: is not of this session" in read_error(capsys)


def test_exact_recordings_hold_the_truth_and_csv_is_a_choice(here):
    assert record("--exact", "--format", "csv", "--record-dt-ms", "4") == 0
    recording = read_recording("day/motion.sine.csv")
    assert recording.has("friction.effort")
    assert recording.has("link.position")
    assert recording.dt == pytest.approx(0.004)


def test_the_law_and_its_model_are_those_that_are_named(here):
    (here / "small.toml").write_text(COULOMB.format(0.1))
    assert record("--feedforward", "lugre_static", "--parameters", "small.toml") == 0
    recording = read_recording("day/motion.sine.npz")
    assert recording.header.meta["feedforward_law"] == "lugre_static"
    assert run("one_axis", "day.toml", "--out", "own", "--feedforward", "lugre_static") == 0
    own = read_recording("own/motion.sine.npz")
    weaker = np.abs(recording["compensation.effort.j1"]).max(), np.abs(own["compensation.effort.j1"]).max()
    assert weaker[0] < weaker[1]


def test_a_session_may_begin_later_in_the_day(here):
    assert record("--later-min", "30", "--record-dt-ms", "4") == 0
    assert read_folder("day")[0].header.meta["session_start"] == 1800.0


def test_measured_torque_may_be_noisy(here):
    assert record("--torque-noise-percent", "1") == 0
    recording = read_recording("day/motion.sine.npz")
    off = recording["motor.effort.j1"] - recording["command.effort.j1"]
    assert np.std(off) == pytest.approx(0.01 * 25.0, rel=0.05)


def test_only_the_named_joints_move(here):
    options = ["--joints", "elbow", "--record-dt-ms", "4", "--out", "arm"]
    assert run("two_link", "dwell_restart", *options) == 0
    (recording,) = read_folder("arm")
    assert not np.ptp(recording["reference.position.shoulder"])
    assert np.ptp(recording["reference.position.elbow"]) > 1.0


def test_the_list_tells_every_protocol_how_long_it_takes_and_why_one_cannot_be_run(here, capsys):
    assert run("two_link", "--list") == 0
    printed = capsys.readouterr().out
    for name in PROTOCOLS:
        assert f"\n{name}: " in printed
    assert re.search(r"^diagnosis: 8 motions, 8\d s", printed, flags=re.M)
    assert run("one_axis", "--list") == 0
    assert "circles: cannot be run: it has no work area" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "Name a robot and what to record"),
        (["one_axis"], "Name a robot and what to record"),
        (["one_axis", "diagnosis"], "--out FOLDER"),
        (["two_axis", "diagnosis", "--out", "x"], "two_axis"),
        (["one_axis", "ladder", "--out", "x"], "Unknown protocol 'ladder'"),
        (["one_axis", "circles", "--out", "x"], "Protocol circles on 'one_axis': it has no work area"),
        (["irb4600_60_205", "circles", "--joints", "j1", "--out", "x"], "--joints has no effect on circles"),
        (["one_axis", "diagnosis", "--joints", "j2", "--out", "x"], "Unknown joint 'j2'"),
        (["one_axis", "day.toml", "--exact", "--seed", "1", "--out", "x"], "--seed has no effect with --exact"),
        (["one_axis", "day.toml", "--parameters", "p.toml", "--out", "x"], "--parameters has no effect without"),
        (["one_axis", "day.toml", "--feedforward", "magic", "--out", "x"], "magic"),
        (["one_axis", "day.toml", "--later-min", "-1", "--out", "x"], "--later-min = -1"),
        (["one_axis", "day.toml", "--torque-noise-percent", "-1", "--out", "x"], "--torque-noise-percent = -1"),
        (["one_axis", "day.toml", "--record-dt-ms", "0.3", "--out", "x"], "record_dt = 0.0003"),
        (["one_axis", "day.toml", "--out", "day.toml"], "--out day.toml: is a file, must be a folder"),
        (["one_axis", "day.toml", "--out", "x", "--json", "day.toml"], "--json day.toml"),
        (["one_axis", "day.toml", "--out", "x/y/day.toml/z", "--seed", "-1"], "seed = -1"),
    ],
)
def test_a_request_that_cannot_be_met_is_one_line(here, capsys, arguments, message):
    assert run(*arguments) == 1
    assert message in read_error(capsys)
    assert not list(here.glob("**/*.npz"))


def test_a_machine_file_is_recorded_with_its_effects_under_the_controller_of_its_robot(here, one_axis):
    machine = Machine(robot=one_axis, effects=(EFFECTS["torque_offset"].on(one_axis, offset=0.2),))
    save_machine(machine, here / "worn.toml", title="worn", source="a test")
    for robot, out in (("worn.toml", "worn"), ("one_axis", "new")):
        assert run(robot, "day.toml", "--out", out, "--record-dt-ms", "4") == 0
    worn, new = (read_recording(f"{out}/motion.sine.npz") for out in ("worn", "new"))
    assert worn.header.robot == new.header.robot == "one_axis"
    assert worn.header.provenance["physics_fingerprint"] != new.header.provenance["physics_fingerprint"]
    assert abs(np.mean(worn["motor.effort.j1"] - new["motor.effort.j1"])) == pytest.approx(0.2, abs=0.05)


def test_a_workcell_is_recorded_by_its_own_sensors_and_gives_no_truth_away(here, capsys):
    steps = '[[step]]\nprotocol = "holds"\nposes = 1\nrest = 0.1\napproach = 0.4\n'
    (here / "hold.toml").write_text(steps)
    cell = ("workcell:cold", "hold.toml")
    assert run(*cell, "--record-dt-ms", "4", "--out", "cell") == 0
    (first,) = read_folder("cell")
    assert not any(first.has(family) for family in ("friction.effort", "link.position", "link.velocity"))
    assert first.has("temperature")
    assert first.header.robot == "irb4600_60_205"
    capsys.readouterr()
    assert run(*cell, "--exact", "--out", "x") == 1
    assert "--exact is not for workcell:cold" in read_error(capsys)
