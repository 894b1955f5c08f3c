"""A release of the engine answers if it moves robots and environments as its record says; a second engine judges."""

import json
from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.registration import ENVIRONMENTS
from ffgym.robot import builtin_parameters, builtin_robots, load_robot
from ffgym.robot.model import spec
from scripts.engine.__main__ import run
from scripts.engine.record import RECORD, difference, read_record, write_record
from scripts.engine.trajectories import STEP, move_by_second_engine, move_robot, recorded_things

FEW = ("two_link", "one_axis", "ffgym/OneAxis-v0")


def ask(record, *names, **options):
    more = [word for name, value in options.items() for word in (f"--{name}", str(value))]
    return run([*more, "--record", str(record), *(["--names", *names] if names else [])])


@pytest.fixture
def own_record(tmp_path):
    """Record of a few that was made here, so that it is the same to the bit on any processor."""
    path = tmp_path / "record.npz"
    write_record(path, {name: recorded_things()[name]() for name in FEW})
    return path


def test_the_record_has_every_robot_and_environment_that_ships():
    known = read_record(RECORD).trajectories
    assert set(known) == set(recorded_things()) == {*builtin_robots(), *builtin_parameters(), *ENVIRONMENTS}


@pytest.mark.parametrize("name", recorded_things())
def test_robots_and_environments_move_as_in_the_record(name):
    found = difference(read_record(RECORD).trajectories[name], recorded_things()[name]())
    assert found is None or found.largest < 1e-7  # other processors round otherwise


OFTEN = {*builtin_robots(), "irb4600_60_205_arm_drives"}
LONG = [
    pytest.param(name, marks=[] if name in OFTEN else pytest.mark.slow)
    for name in (*builtin_robots(), *builtin_parameters())
]
"""Robots that ship; those that differ from others in a few numbers are left to make test-all."""


@pytest.mark.parametrize("name", LONG)
def test_the_second_engine_comes_to_the_same_places_by_itself(name):
    found = difference(move_by_second_engine(name), move_robot(name))
    assert found is None or found.largest < (1e-11 if load_robot(name).drive.is_rigid.all() else 1e-8)


def test_what_is_the_same_to_the_bit_is_told_and_the_exit_code_is_0(own_record, capsys):
    assert ask(own_record, *FEW) == 0
    assert "3 of 3 are the same to the bit" in capsys.readouterr().out


def test_another_engine_is_told_with_size_and_time_and_the_second_engine_stands_by_the_record(
    own_record, capsys, monkeypatch, tmp_path
):
    inertial = spec._set_inertial
    monkeypatch.setattr(spec, "_set_inertial", lambda body, mass, *more: inertial(body, mass * (1 + 1e-6), *more))
    assert ask(own_record, "two_link", "one_axis", json=tmp_path / "found.json") == 1
    found = {row["name"]: row for row in json.loads((tmp_path / "found.json").read_text())["verdicts"]}
    assert found["two_link"]["answer"] == "differs"
    assert 1e-8 < found["two_link"]["differs_by"] < 1e-5
    assert found["two_link"]["since"] == pytest.approx(64 * STEP)
    assert found["two_link"]["record_from_second"] < 0.1 * found["two_link"]["now_from_second"]
    assert "differs by" in (told := capsys.readouterr().out)
    assert "nearer to the second engine is the record" in told


def test_a_record_that_was_wrong_is_told_and_the_second_engine_stands_by_what_is_installed(own_record, capsys):
    known = read_record(own_record).trajectories
    wrong = known["two_link"].values.copy()
    wrong[10:] += 1e-7
    write_record(own_record, {**known, "two_link": replace(known["two_link"], values=wrong)})
    assert ask(own_record, *FEW) == 1
    told = capsys.readouterr().out
    assert "nearer to the second engine is now" in told
    assert "since 0.022 s" in told
    assert "2 of 3 are the same to the bit" in told


def test_a_record_of_an_environment_that_differs_refers_to_its_robot(tmp_path, capsys):
    name = "ffgym/OneAxis-v1"
    now = recorded_things()[name]()
    write_record(tmp_path / "record.npz", {name: replace(now, values=now.values * (1 + 1e-9))})
    assert ask(tmp_path / "record.npz", name) == 1
    assert "for the second engine see one_axis_drives" in capsys.readouterr().out


def test_one_that_is_not_recorded_or_has_other_coordinates_is_told(own_record, capsys):
    known = read_record(own_record).trajectories
    more = replace(known["one_axis"], values=np.tile(known["one_axis"].values, 2))
    write_record(own_record, {"one_axis": more})
    assert ask(own_record, *FEW) == 1
    told = capsys.readouterr().out
    assert "has other coordinates" in told
    assert told.count("not recorded") == 2


def test_bad_input_is_one_line(tmp_path, capsys):
    (tmp_path / "damaged.npz").write_bytes(b"no archive")
    for record, names in ((tmp_path / "none.npz", FEW), (tmp_path / "damaged.npz", FEW), (RECORD, ("three_link",))):
        assert ask(record, *names) == 2
        assert capsys.readouterr().err.count("\n") == 1
