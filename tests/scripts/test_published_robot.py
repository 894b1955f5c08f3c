"""The page on the published robot: what it says follows from the result file, and its machines from the fits there."""

import json

import numpy as np
import pytest

from ffgym.cli.main import main as command
from ffgym.core.files import read_text
from ffgym.robot import load_robot
from ffgym.simulation.plant import load_machine
from scripts.published_machines import Config, main
from scripts.tables.page import DOCS
from scripts.tables.published_robot import (
    RESULT,
    TRIANGLE,
    describe_signs,
    describe_structures,
    fitted_machine,
    simulate_lost_motion,
    structure_candidate,
)


@pytest.fixture(scope="module")
def result():
    return json.loads(read_text(RESULT))


def fit_of(result, name):
    (found,) = (each for each in result["structures"] if each["name"] == name)
    return found


def test_tables_of_the_page_are_those_of_the_result(result):
    page = read_text(DOCS / "published_robot.md")
    for part in (describe_structures(result), describe_signs(result)):
        assert f"\n{part}\n" in page


def test_positions_that_one_step_left_out_are_marked(result):
    first = result["structures"][0]
    kinds = {
        "refit": f"| {first['left_out_within_1_5']} |",
        "one step": f"| {first['left_out_within_1_5']} (one step) |",
    }
    for kind, words in kinds.items():
        assert words in describe_structures(result | {"structures": [first | {"left_out_by": kind}]})


def test_numbers_of_the_text_are_those_of_the_result(result):
    page = read_text(DOCS / "published_robot.md")
    backlash, arm, wrong = (fit_of(result, name) for name in ("backlash", "arm_friction", "wrong_friction"))
    for each in (backlash, arm):
        assert f"{each['fitted_within_1_5']} of 72 fitted and" in page
        assert f"{each['held_out_within_1_5']} of 48 held-out" in page
    assert f"{wrong['fitted_within_1_5']} of 72 fitted errors" in page
    assert (backlash["sign_right"], arm["sign_right"], arm["sign_cells"]) == (0, 4, 4)
    (share,) = (n["value"] for n in arm["numbers"] if n["name"].startswith("share"))
    (gap,) = (n["value"] for n in backlash["numbers"] if n["name"] == "half gap")
    assert f"{share:.0%}".replace("%", " %") in page
    assert f"{gap * 1e6:.0f} µrad" in page


def test_structures_are_judged_on_all_rows_with_at_most_fourteen_numbers(result):
    assert sum(row["use"] == "fitted" and row["statistic"] == "rms" for row in result["rows"]) == 72
    assert sum(row["use"] == "held_out" and row["statistic"] == "rms" for row in result["rows"]) == 48
    names = {each["name"] for each in result["structures"]}
    assert {"numbers", "wrong_friction", "delay", "backlash", "base_flexibility", "torsional_hysteresis"} <= names
    assert {"arm_friction", "third_mass", "drive"} <= names
    assert any("+" in name for name in names)
    assert all(each["free_parameters"] <= 14 for each in result["structures"])


def test_machines_that_ship_are_those_of_the_fits(result, tmp_path):
    main(Config(parameters=tmp_path / "parameters.toml", backlash=tmp_path / "backlash.toml"))
    shipped = load_robot("irb4600_60_205_arm_losses")
    again = load_robot(tmp_path / "parameters.toml")
    fitted = fitted_machine(load_robot("irb4600_60_205"), fit_of(result, "arm_friction")).robot
    for robot in (shipped, again):
        np.testing.assert_allclose(robot.friction.arm_share, fitted.friction.arm_share, rtol=1e-3)
        np.testing.assert_allclose(robot.servo.position_gain, fitted.servo.position_gain, rtol=1e-3)
        np.testing.assert_allclose(robot.drive.joint_stiffness, fitted.drive.joint_stiffness, rtol=1e-3)
    fitted = structure_candidate(load_robot("irb4600_60_205"), fit_of(result, "backlash")).machine
    shipped = load_machine(DOCS / "backlash.toml")
    gaps = [next(effect.half_gap for effect in each.effects if effect.name == "backlash") for each in (shipped, fitted)]
    np.testing.assert_allclose(gaps[0], gaps[1], rtol=1e-9)
    for group, name in (("drive", "joint_stiffness"), ("servo", "velocity_gain"), ("friction", "coulomb")):
        ours, theirs = (getattr(getattr(each.physical, group), name) for each in (shipped, fitted))
        np.testing.assert_allclose(ours, theirs, rtol=1e-9)


def test_the_slow_triangle_shows_a_loop_with_friction_behind_the_elasticity_alone(result):
    robot, widths = load_robot("irb4600_60_205"), {}
    for name in ("numbers", "arm_friction"):
        way, lost = simulate_lost_motion(fitted_machine(robot, fit_of(result, name)))
        middle = np.abs(way) < 1.0  # mrad, far from the ends where the joint turns
        speed = np.gradient(way)
        forwards, backwards = (lost[middle & (sign * speed > 1e-3)] for sign in (1, -1))
        widths[name] = abs(np.median(forwards) - np.median(backwards))
    assert widths["arm_friction"] > 100.0  # um
    assert widths["numbers"] < 10.0


@pytest.mark.parametrize(
    ("machine", "low", "high"),
    [
        ("irb4600_60_205_arm_losses", 0.5, 0.6),
        pytest.param("irb4600_60_205", 0.0, 0.02, marks=pytest.mark.slow),
        pytest.param(str(DOCS / "backlash.toml"), 0.0, 0.12, marks=pytest.mark.slow),
    ],
)
def test_the_slow_triangle_tells_the_share(machine, low, high, tmp_path):
    logs, numbers = tmp_path / "logs", tmp_path / "numbers.json"
    assert command(["record", machine, str(TRIANGLE), "--out", str(logs)]) == 0
    model = ["--robot", "irb4600_60_205", "--stiffness-spread", "0.1", "--resamples", "10"]
    assert command(["identify", str(logs), *model, "--json", str(numbers)]) == 0
    share = json.loads(numbers.read_text())["joints"][0]["arm_share"]
    assert share["status"] == "identified"
    assert low <= share["value"] <= high
