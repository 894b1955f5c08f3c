"""Motions by name and by file, on every robot that ships."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.paths import cartesian_reference, circle_test
from ffgym.paths.motions import list_motions, load_motion
from ffgym.robot import RigidArm, builtin_robots, load_robot

IN_JOINT_SPACE = ("ladder", "multisine", "sine", "triangle")


def test_the_built_in_motions_are_there():
    beyond = {"rounded_square", "spiral", "tilted_circles", "low_circles"}
    assert set(list_motions()) == {
        "circles",
        "square",
        *beyond,
        *IN_JOINT_SPACE,
        "cut_bracket",
        "laser_plate",
        "thesis_circles",
    }


def test_the_built_in_circles_are_the_circle_test_bit_for_bit(arm, irb4600):
    made = load_motion(arm, "circles").reference
    plain = cartesian_reference(arm, circle_test(irb4600.work_area.positions["p1"], 0.04))
    for name in ("t", "q", "dq", "ddq"):
        np.testing.assert_array_equal(getattr(made, name), getattr(plain, name))
    assert made.phases == plain.phases


@pytest.mark.parametrize("robot", builtin_robots())
@pytest.mark.parametrize("motion", IN_JOINT_SPACE)
def test_every_robot_can_make_the_built_in_joint_motions(robot, motion):
    made = load_motion(RigidArm(load_robot(robot)), motion)
    assert made.reference.name == motion
    assert made.notes == ()
    np.testing.assert_allclose(made.reference.q[-1], made.reference.q[0], atol=1e-3)


def test_the_square_is_a_square_with_round_corners(arm):
    made = load_motion(arm, "square")
    tcp = arm.tcp_position(made.reference.q)
    np.testing.assert_allclose(np.ptp(tcp, axis=0), [0.1, 0.1, 0], atol=1e-9)
    assert made.notes == ()


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("loops", "Unknown motion 'loops'. Available: circles"),
        ("job.xlsx", "must end in .toml, .csv"),
        ("folder/circles", "must end in"),
        ("no_such.toml", "no_such.toml: cannot be read"),
        ("no_such.csv", "no_such.csv: cannot be read"),
        ("", "Unknown motion ''"),
    ],
)
def test_what_is_no_motion_is_one_error(arm, source, message):
    with pytest.raises(FFGymError, match=message):
        load_motion(arm, source)


def test_files_that_are_no_text_are_one_error(arm, tmp_path):
    for name in ("job.toml", "job.csv"):
        (tmp_path / name).write_bytes(b"\xff\xfe\x00")
        with pytest.raises(FFGymError, match=f"{name}: is not UTF-8"):
            load_motion(arm, tmp_path / name)
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(FFGymError, match="cannot be read"):
        load_motion(arm, tmp_path / "folder.toml")


def test_a_procedure_of_a_program_is_run_alone(arm):
    hole = load_motion(arm, "cut_bracket", entry="CutHole").reference
    assert [phase.kind for phase in hole.phases].count("circle") == 1
    assert hole.duration < load_motion(arm, "cut_bracket").reference.duration / 2
    with pytest.raises(FFGymError, match=r"cut_bracket.mod: has no procedure cut; choose one as entry: main, pierce"):
        load_motion(arm, "cut_bracket", entry="cut")


@pytest.mark.parametrize("source", ["circles", "points.csv", "cut.toml"])
def test_only_programs_have_procedures(arm, source):
    with pytest.raises(FFGymError, match=r"entry = 'main' is for a program \(.mod, .prg, .pgf\), which .* is not"):
        load_motion(arm, source, entry="main")
