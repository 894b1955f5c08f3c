"""`ffgym identify --what rigid_body`: from logs to masses, rotors and friction that every agent and plant accepts."""

import json
import re
from dataclasses import replace
from importlib import resources

import numpy as np
import pytest

from ffgym.cli.main import main
from ffgym.recordings import Recording, read_recording, write_recording
from ffgym.robot import load_draft, load_robot, with_parameters
from ffgym.simulation.plant import load_machine
from tests.diagnosis.identification.rigid_body.recorded_arms import recorded, rigid, swing


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """Two motions of two links that are heavier than described."""
    robot, folder = rigid(load_robot("two_link")), tmp_path_factory.mktemp("logs")
    bodies = replace(robot.bodies, mass=1.2 * robot.bodies.mass, inertia=1.2 * robot.bodies.inertia)
    robot = replace(robot, bodies=bodies, friction=robot.friction.scale(coulomb=1.3, static=1.3))
    paths = []
    for i in range(3):
        recording = recorded(robot, swing(robot, i), noise=0.005, seed=i, segment=f"motion_{i}")
        paths.append(str(folder / f"{i}.npz"))
        write_recording(recording, paths[-1])
    return paths


def command(logs, *arguments):
    return ["identify", *logs, "--robot", "two_link", "--what", "rigid_body", "--resamples", "10", *arguments]


def test_file_numbers_page_and_words_say_the_same(logs, tmp_path, capsys):
    out, numbers, page = (tmp_path / name for name in ("parameters.toml", "numbers.json", "page.html"))
    written = ["--out", str(out), "--json", str(numbers), "--report", str(page)]
    assert main(command(logs, "--validate", logs[2], *written)) == 0
    text = capsys.readouterr().out
    assert max(len(line) for line in text.splitlines() if "parameters:" not in line and "page" not in line) <= 120
    robot = with_parameters(load_robot("two_link"), out)
    np.testing.assert_allclose(robot.friction.coulomb, 1.3 * load_robot("two_link").friction.coulomb, rtol=0.03)
    found = json.loads(numbers.read_text(encoding="utf-8"))
    assert found["logs"] == ["motion_0", "motion_1"]
    assert found["seed"] == 0
    errors = found["errors_nm"]["motion_2"]
    assert np.all(np.array(errors["in_file"]) < 0.2 * np.array(errors["described"]))
    coulomb = next(entry for entry in found["parameters"] if entry["name"] == "coulomb.elbow")
    assert coulomb["low"] <= coulomb["value"] <= coulomb["high"]
    assert f"{coulomb['value']:.4g}" in text
    html = page.read_text(encoding="utf-8")
    assert html.count("<img") == 1
    assert f"{coulomb['value']:.4g}" in html
    assert "rotor_inertia.elbow" in html


def test_a_description_without_masses_is_enough(logs, tmp_path, capsys):
    """A table as `ffgym robot new` writes it: geometry, gears and gravity, and no more."""
    robot = load_robot("two_link")
    kinematics, drive = robot.kinematics, robot.drive

    def entry(path, value, unit, side=""):
        sides = f'side = "{side}"\n' if side else ""
        numbers = np.asarray(value).tolist()
        return f'[{path}]\nvalue = {numbers}\nunit = "{unit}"\n{sides}origin = "sourced"\nsource = "drawing"\n'

    description = tmp_path / "two_link.toml"
    description.write_text(
        '[robot]\nname = "two_link"\ntitle = "Two links"\njoints = ["shoulder", "elbow"]\n'
        'links = ["upper_arm", "forearm"]\n'
        + entry("kinematics.position", kinematics.position, "m")
        + entry("kinematics.axis", kinematics.axis, "1")
        + entry("kinematics.range", kinematics.range, "rad", "link")
        + entry("drive.gear_ratio", drive.gear_ratio, "1")
        + entry("simulation.gravity", robot.gravity, "m/s^2"),
        encoding="utf-8",
    )
    out = tmp_path / "parameters.toml"
    arguments = command(logs, "--validate", logs[2], "--out", str(out))
    arguments[arguments.index("two_link")] = str(description)
    assert main(arguments) == 0
    assert "rule of thumb" in out.read_text(encoding="utf-8")
    assert "Two links" in capsys.readouterr().out
    assert load_draft(out).quantities["links.mass"].origin == ("fitted",)  # it finds the description by its path


def test_what_is_written_for_a_robot_of_the_user_s_own_is_a_robot_for_every_command(logs, tmp_path):
    text = (resources.files("ffgym.robot") / "data" / "two_link.toml").read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(text.replace('name = "two_link"', 'name = "mine"'), encoding="utf-8")
    (tmp_path / "fits").mkdir()
    (tmp_path / "logs").mkdir()
    own = [str(tmp_path / "logs" / f"{i}.npz") for i in range(2)]
    for path, log in zip(own, logs, strict=False):
        recording = read_recording(log)
        write_recording(Recording(recording.columns, replace(recording.header, robot="mine")), path)
    first, second = (str(tmp_path / "fits" / name) for name in ("first.toml", "second.toml"))
    arguments = command(own, "--out", first)
    arguments[arguments.index("two_link")] = str(tmp_path / "mine.toml")
    assert main(arguments) == 0
    assert load_robot(first).name == "mine"
    (tmp_path / "machine.toml").write_text('[machine]\ntitle = "fitted"\nrobot = "fits/first.toml"\n')
    assert load_machine(tmp_path / "machine.toml").robot.friction.coulomb == pytest.approx(
        load_robot(first).friction.coulomb
    )
    arguments[arguments.index(first)], arguments[arguments.index(str(tmp_path / "mine.toml"))] = second, first
    assert main(arguments) == 0  # and identification goes on from it
    assert "first.toml" in (tmp_path / "fits" / "second.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--joints", "elbow"], "--joints has no effect on --what rigid_body"),
        (["--stribeck-velocity", "1.0"], "--stribeck-velocity has no effect"),
        (["--terms", "mass"], "Unknown term 'mass'"),
        (["--spread", "0"], "spread"),
        (["--cutoff-hz", "400"], "low-pass at 400 Hz"),
        (["--cutoff-hz", "-1"], "--cutoff-hz"),
    ],
)
def test_what_cannot_be_done_is_one_line(logs, capsys, arguments, message):
    assert main(command(logs[:1], *arguments)) == 1
    error = capsys.readouterr().err
    assert len(error.splitlines()) == 1
    assert re.search(message, error), error


def test_options_of_a_rigid_body_do_nothing_for_friction(logs, capsys):
    assert main(["identify", logs[0], "--robot", "two_link", "--spread", "0.1"]) == 1
    assert "--spread has no effect on --what friction" in capsys.readouterr().err
