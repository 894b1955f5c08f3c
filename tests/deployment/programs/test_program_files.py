"""Files of corrected programs hold the plan in the language and units of their controller."""

import csv
import re
from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.deployment import ServoProgram, choose_points, plan_probe, write_program
from ffgym.deployment.programs import folder
from ffgym.deployment.programs.krl import write_krl
from ffgym.deployment.programs.names import program_name
from ffgym.deployment.programs.rapid import write_rapid
from ffgym.paths import load_motion, load_program
from ffgym.robot import RigidArm
from tests.robot.arm_samples import ARMS


def written(plan, arm, tmp_path, form, **how):
    """What was written, and the text of each file by its suffix."""
    result = write_program(plan, arm, tmp_path / "out", form, **how)
    return result, {name.split(".")[-1]: (tmp_path / "out" / name).read_text() for name in result.files}


def test_a_rapid_module_leads_through_the_points_within_the_tolerance(plan, arm, tmp_path):
    result, texts = written(plan, arm, tmp_path, "rapid", tolerance=1e-5)
    points = choose_points(plan, arm, tolerance=1e-5)
    execution = load_program(tmp_path / "out" / "short.mod").execute(arm.robot)
    assert execution.robot is arm.robot  # the tool of the module is that of the robot
    moves = [move for move in execution.moves if hasattr(move, "to")]
    np.testing.assert_allclose(moves[0].to, plan.setpoints[0], atol=2e-6)
    np.testing.assert_allclose(moves[-1].to, plan.setpoints[-1], atol=2e-6)
    assert 0 < result.deviation.distance < 1e-5
    assert result.points == len(points.t)
    assert "z0" not in texts["mod"]
    assert texts["mod"].count("MoveAbsJ") <= len(points.t)


def test_speeds_of_a_rapid_module_give_the_time_of_the_plan(plan, arm, tmp_path):
    """Lengths over speeds, summed over the moves, are the time that the plan moves."""
    _, texts = written(plan, arm, tmp_path, "rapid")
    points = choose_points(plan, arm)
    speeds = re.findall(r"NoEOffs,\[([\d.e+-]+),([\d.e+-]+),", texts["mod"])
    takes = [
        max(1e3 * length / float(v), np.rad2deg(turn) / float(w))
        for (v, w), length, turn in zip(speeds, points.lengths, points.turns, strict=True)
    ]
    steps = np.diff(points.t)
    moving = (points.speeds[1:] > 1e-4) & ~points.rests[:-1]
    assert moving.sum() > 20
    np.testing.assert_allclose(np.array(takes[1:])[moving], steps[moving], rtol=1e-4)


def test_where_the_tool_turns_on_the_spot_its_turn_has_the_time_of_the_plan(plan, arm):
    points = choose_points(plan, arm)
    turning = replace(points, lengths=np.zeros(len(points.t)), turns=np.full(len(points.t), 0.01))
    (text,) = write_rapid(turning, arm).values()
    speeds = re.findall(r"NoEOffs,\[([\d.e+-]+),([\d.e+-]+),", text)
    k = next(k for k in range(5, len(points.t)) if not points.rests[k - 1])
    assert float(speeds[k][0]) == 7000
    assert float(speeds[k][1]) == pytest.approx(np.rad2deg(0.01) / (points.t[k] - points.t[k - 1]), rel=1e-4)


def test_more_axes_than_a_controller_has_are_refused(plan, arm):
    seven = replace(choose_points(plan, arm), joints=tuple("abcdefg"))
    with pytest.raises(FFGymError, match=r"KRL has axes A1 to A6, .* has 7 joints"):
        write_krl(seven)
    with pytest.raises(FFGymError, match=r"jointtargets of 6 joints, .* has 7"):
        write_rapid(seven, arm)


def test_a_krl_program_has_axes_in_degrees_and_the_times_of_the_plan(plan, arm, tmp_path):
    result, texts = written(plan, arm, tmp_path, "krl")
    points = choose_points(plan, arm)
    rows = [[float(x) for x in re.findall(r"A\d ([-\d.e]+)", line)] for line in texts["dat"].splitlines()]
    np.testing.assert_allclose([row for row in rows if row], np.rad2deg(points.q), atol=1e-5)
    parts = [float(x) for x in re.findall(r"PART=([\d.]+)", texts["src"])]
    assert sum(parts) / 1e3 + sum(np.diff(points.t)[points.rests[:-1]]) == pytest.approx(plan.t[-1], abs=1e-3)
    assert texts["src"].count("TIME_BLOCK START") == texts["src"].count("TIME_BLOCK END")
    assert "$ADVANCE=3" in texts["src"]
    assert all(text.startswith("&ACCESS RVP\nDEF") for text in texts.values())
    assert "Set $TOOL and $LOAD here" in texts["src"]
    assert result.deviation.duration == pytest.approx(plan.t[-1], abs=0.01)


def test_a_urscript_sends_every_set_point_in_radians(plan, arm, tmp_path):
    _, texts = written(plan, arm, tmp_path, "urscript", servo=ServoProgram(lookahead_time=0.05, gain=500))
    text = texts["script"]
    rows = [
        [float(x) for x in row.split(",")]
        for row in re.findall(r"servoj\(\[(.*?)\], t=0.004, lookahead_time=0.05, gain=500\)", text)
    ]
    np.testing.assert_allclose(rows, plan.setpoints[1:], atol=1e-7)
    assert text.startswith("def short():")
    assert re.search(r"^  movej\(\[.*\], a=0.5, v=0.2\)$", text, flags=re.M)  # slowly, from wherever the robot is
    assert text.index("movej") < text.index("servoj")


def test_a_table_has_units_in_its_titles_and_every_set_point(plan, arm, tmp_path):
    _, texts = written(plan, arm, tmp_path, "csv")
    titles, *rows = list(csv.reader(texts["csv"].splitlines()))
    assert titles == ["t_s", *(f"{joint}_deg" for joint in plan.joints)]
    numbers = np.array(rows, dtype=float)
    np.testing.assert_allclose(numbers[:, 0], plan.t, atol=1e-6)
    np.testing.assert_allclose(numbers[:, 1:], np.rad2deg(plan.setpoints), atol=1e-5)
    # ffgym reads it as a motion, between rests
    q = load_motion(arm, tmp_path / "out" / "short.csv").reference.q
    np.testing.assert_allclose(q[[0, -1]], plan.setpoints[[0, -1]], atol=1e-6)


@pytest.mark.parametrize("form", ["rapid", "krl", "urscript", "csv"])
def test_a_program_that_leaves_the_plan_is_not_written(plan, arm, tmp_path, form, monkeypatch):
    """One point that is 0.05 deg off on its way into the file."""
    original = folder._texts

    def spoilt(*args):
        files, points = original(*args)
        changed = {name: _shift_one_number(text) for name, text in files.items()}
        assert changed != files
        return changed, points

    monkeypatch.setattr(folder, "_texts", spoilt)
    with pytest.raises(
        FFGymError,
        match=rf"The {form} program is \d+\.\d+ mm from the plan at .* Allow more \(tolerance, --tolerance-mm\)\.$",
    ):
        write_program(plan, arm, tmp_path / "out", form)
    assert not (tmp_path / "out").exists()


def _shift_one_number(text):
    """Add 0.05 to the third joint of a row in the middle."""
    rows = list(
        re.finditer(
            r"(A3 |MoveAbsJ \[\[[^,]*,[^,]*,|servoj\(\[[^,]*,[^,]*,|^[\d.]+,[^,]*,[^,]*,)(-?[\d.]+)", text, flags=re.M
        )
    )
    if not rows:
        return text
    row = rows[len(rows) // 2]
    return f"{text[: row.start(2)]}{float(row[2]) + 0.05}{text[row.end(2) :]}"


def test_the_report_tells_the_largest_changes_and_where_they_are(plan, arm, tmp_path):
    result, _ = written(plan, arm, tmp_path, "csv", report={"command": "test"})
    for j, one in enumerate(result.changes.joints):
        assert one.size == np.abs(plan.correction[:, j]).max()
        row = round(one.t / plan.dt)
        np.testing.assert_allclose(one.position, arm.tcp_position(plan.program[row : row + 1])[0])
    moved = np.linalg.norm(arm.tcp_position(plan.setpoints) - arm.tcp_position(plan.program), axis=1)
    assert result.changes.tool.size == pytest.approx(moved.max(), rel=1e-3)
    assert result.changes.share == pytest.approx(np.mean(moved > 0.1 * moved.max()), abs=0.01)
    page = (tmp_path / "out" / "changes.html").read_text(encoding="utf-8")
    assert f"{1e3 * moved.max():.3f} mm at most" in page
    assert "outputs and waits of the original program" in page
    assert (tmp_path / "out" / "changes.json").exists()


def test_controllers_get_only_robots_that_they_can_have(plan, arm, one_axis, tmp_path):
    with pytest.raises(FFGymError, match=r"is for joints j1, .* robot 'one_axis' has"):
        write_program(plan, RigidArm(one_axis), tmp_path / "out", "csv")
    single = replace(
        plan,
        joints=tuple(one_axis.joints),
        units=tuple(one_axis.kinematics.units),
        **{name: getattr(plan, name)[:, :1] for name in ("program", "correction", "torque")},
    )
    with pytest.raises(FFGymError, match="Robot 'one_axis' has no tool, so deviations cannot be told in mm"):
        write_program(single, RigidArm(one_axis), tmp_path / "out", "csv")
    with pytest.raises(FFGymError, match=r"Unknown format of program 'gcode'\. Available: csv, krl, rapid, urscript"):
        write_program(plan, arm, tmp_path / "out", "gcode")
    assert not (tmp_path / "out").exists()


def test_a_rapid_module_of_an_arm_that_cannot_turn_its_tool_is_read_back(tmp_path):
    gantry = RigidArm(ARMS["gantry"]())
    plan = plan_probe(gantry, np.random.default_rng(1), duration=1.2)
    result, texts = written(plan, gantry, tmp_path, "rapid", tolerance=1e-4)
    assert result.deviation.distance < 1e-4
    assert "MoveAbsJ [[100,0,200,0,0,0]," in texts["mod"]  # millimetres


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("holes", "holes"),
        ("hole 3, left", "hole_3_left"),
        ("test", "p_test"),  # TEST ... ENDTEST in RAPID
        ("main", "p_main"),  # the routine of the module itself
        ("part2", "p_part2"),
        ("Spline", "p_Spline"),
        ("movej", "p_movej"),
        ("3 circles", "p_3_circles"),
        ("ü", "p_"),
        ("a" * 60, "a" * 24),
    ],
)
def test_programs_have_names_that_controllers_take(name, expected):
    assert program_name(name) == expected
