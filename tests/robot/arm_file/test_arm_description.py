"""A robot description may name an arm file; what it says itself counts more, and is checked as ever."""

import copy
import pickle
import re
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from ffgym.control import StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.paths import joint_reference, joint_sine
from ffgym.robot import ModelOptions, compile_model, load_draft, load_robot, parse_robot, physics_fingerprint
from ffgym.robot.arm_file import JointHints, read_arm
from ffgym.robot.reading.parse import parse_draft
from ffgym.simulation import Run, simulate
from tests.robot.arm_file.arm_file_samples import (
    ARMS,
    FILES,
    UR_JOINTS,
    described,
    description_text,
    entry,
)

SIX = ("hinge",) * 6
HEAD = "[robot]\nname = 'mine'\ntitle = 'My arm'\nmodel = 'kr_like.urdf'\n"


def parse(text):
    return parse_robot(text, where="mine.toml", folder=FILES)


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_from_a_file_runs_with_a_drive_table(name):
    robot = described(FILES / name, *ARMS[name])
    n = robot.n_joints
    path = joint_sine([0.02] * n, 1.0, 0.5, centre=robot.kinematics.range.mean(axis=1), dt=0.004)
    (recording,) = simulate([Run(reference=joint_reference(robot, path), law=StaticLuGre(robot.friction))])
    assert recording.header.joints == robot.joints
    assert recording.header.joint_types == robot.kinematics.types
    error = recording.joint_array("reference.position") - recording.joint_array("motor.position")
    assert np.abs(error).max() < 0.05 * 100


def test_joints_links_and_types_come_from_the_file():
    robot = described(FILES / "scara.xml")
    assert robot.joints == ("j1", "j2", "z", "j4")
    assert robot.links == ("inner_arm", "outer_arm", "spindle", "flange")
    assert robot.kinematics.types == ("hinge", "hinge", "slide", "hinge")
    assert robot.kinematics.range[2].tolist() == [0.0, 0.2]


def test_joints_and_bodies_without_names_are_numbered():
    robot = described(FILES / "seven_axes.xml")
    assert robot.joints == tuple(f"joint{i}" for i in range(1, 8))
    assert robot.links == tuple(f"link{i}" for i in range(1, 8))


def test_numbers_of_the_file_say_so():
    robot = described(FILES / "kr_like.urdf", frame="tool0")
    quantity = robot.quantities["links.inertia"]
    assert (quantity.origin, quantity.source) == (("sourced",), "kr_like.urdf")
    assert (quantity.unit, quantity.side, quantity.value.flags.writeable) == ("kg m^2", "link", False)
    assert robot.quantities["tool.tcp"].origin == ("chosen",)
    assert robot.quantities["flange.rotation"].source == "kr_like.urdf, frame tool0"
    assert robot.quantities["simulation.gravity"].origin == ("chosen",)
    assert described(FILES / "kr_like.xml").quantities["simulation.gravity"].value.tolist() == [0.0, 0.0, -9.80665]
    assert described(FILES / "scara.xml").quantities["kinematics.range"].unit == "rad, rad, m, rad"


def test_hinges_without_limits_may_turn_once_to_both_sides_and_say_so():
    quantity = described(FILES / "kr_like.xml").quantities["kinematics.range"]
    assert quantity.origin == ("sourced",) * 3 + ("chosen",) + ("sourced",) * 2
    assert quantity.value[3].tolist() == [-2 * np.pi, 2 * np.pi]
    assert quantity.value[0].tolist() == pytest.approx(np.radians([-170, 170]))
    assert "one turn to both sides" in quantity.source


def test_a_slide_without_limits_has_no_range_until_the_description_gives_one(tmp_path):
    text = (FILES / "scara.xml").read_text().replace('range="0 0.2"', "")
    (tmp_path / "scara.xml").write_text(text)
    types = ("hinge", "hinge", "slide", "hinge")
    with pytest.raises(FFGymError, match=r"Missing entries: kinematics\.range"):
        parse_robot(description_text("scara.xml", types), folder=tmp_path)
    limits = entry("kinematics.range", [[-1.0, 1.0]] * 4, ["rad", "rad", "m", "rad"], "link")
    robot = parse_robot(description_text("scara.xml", types, more=limits), folder=tmp_path)
    assert robot.kinematics.range[2].tolist() == [-1.0, 1.0]


def test_what_the_description_says_counts_more_than_the_file():
    limits = entry("kinematics.range", [[-10.0, 10.0]] * 6, "deg", "link")
    robot = parse(description_text("kr_like.urdf", SIX, more=limits, looks="none"))
    assert robot.kinematics.range == pytest.approx(np.radians([[-10.0, 10.0]] * 6))
    assert robot.quantities["kinematics.range"].source == "test"
    assert robot.kinematics.max_speed.tolist() == [3.0] * 6  # of the table, not of the file


def test_speed_limits_of_the_file_serve_where_the_table_has_none():
    text = re.sub(r"\[kinematics.max_speed\]\n(.+\n){5}", "", description_text("ur_like.urdf", SIX, looks="none"))
    assert "max_speed" not in text
    assert parse(text).kinematics.max_speed.tolist() == [3.14159] * 6
    with pytest.raises(FFGymError, match=r"Missing entries: kinematics\.max_speed"):
        parse(text.replace("ur_like.urdf", "kr_like.xml"))


def test_a_tool_frame_puts_tool0_where_the_file_has_it():
    robot = described(FILES / "kr_like.urdf", frame="tool0")
    assert robot.tool is not None
    np.testing.assert_allclose(robot.tool.rotation, [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], atol=1e-11)
    np.testing.assert_allclose(robot.tool.position, 0, atol=1e-15)
    np.testing.assert_array_equal(robot.tool.tcp, 0)
    robot = parse(
        description_text(
            "kr_like.urdf", SIX, looks="none", tool_frame="tool0", more=entry("tool.tcp", [0.0, 0.0, 120.0], "mm")
        )
    )
    assert robot.tool.tcp.tolist() == [0.0, 0.0, 0.12]


def test_frames_are_all_that_is_part_of_the_last_link():
    assert set(read_arm(FILES / "ur_like.urdf", looks=False).frames) == {"wrist_3_link", "flange", "tool0"}


def test_the_path_of_the_file_starts_at_the_description(tmp_path, monkeypatch):
    (tmp_path / "arms").mkdir()
    (tmp_path / "arms" / "arm.urdf").write_text((FILES / "kr_like.urdf").read_text())
    text = description_text("arms/arm.urdf", SIX, looks="none")
    (tmp_path / "mine.toml").write_text(text)
    monkeypatch.chdir(FILES)
    robot = load_robot(tmp_path / "mine.toml")
    assert robot.links[0] == "link_1"
    monkeypatch.chdir(tmp_path)
    assert parse_robot(text).links == robot.links


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEAD + "types = ['hinge']\n", "[robot] must have exactly name, title, joints and links"),
        (
            HEAD + "links = ['a']\n",
            "or name, title and model, and may have joints, tool_frame and looks. Got ['links', ",
        ),
        (HEAD.replace("'kr_like.urdf'", "3"), "[robot] model must be names, non-empty text, got [3]"),
        (HEAD.replace("kr_like", "no_arm"), "no_arm.urdf: no such file."),
        (HEAD + "joints = 'joint_a1'\n", "[robot] joints must be names, non-empty text, got 'joint_a1'"),
        (HEAD + "looks = 'none'\njoints = ['joint_a7']\n", "Unknown joint 'joint_a7'. Available: joint_a1, joint_a2"),
        (HEAD + "looks = 'nice'\n", "Unknown [robot] looks 'nice'. Available: file, none"),
        (HEAD + "looks = false\n", "[robot] looks must be names"),
        (HEAD + "looks = 'none'\ntool_frame = 'tcp'\n", "Unknown frame on 'link_6' in "),
        (HEAD + "looks = 'none'\ntool_frame = 'tcp'\n", "'tcp'. Available: link_6, tool0"),
        (HEAD, "The mesh 'meshes/base.stl' of link 'base_link' visual is missing"),
        (
            HEAD + "looks = 'none'\n" + entry("drive.gear_ratio", [100.0] * 5, "1"),
            "drive.gear_ratio has shape (5,), must be (6)",
        ),
        (
            HEAD + "looks = 'none'\n" + entry("drive.rotor_inertia", [1e-3] * 6, "kg", "motor"),
            "drive.rotor_inertia: unit is 'kg', must be 'kg m^2'",
        ),
        (
            HEAD + "looks = 'none'\n" + entry("links.mass", [1.0] * 6, "g", "link"),
            "links.mass: unit is 'g', must be 'kg'",
        ),
        (
            HEAD + "looks = 'none'\n" + entry("joint_a7.gear_ratio", 100.0, "1"),
            "Unknown entries ['joint_a7.gear_ratio']",
        ),
        (HEAD + "looks = 'none'\n", "mine.toml: Missing entries: drive.gear_ratio, drive.joint_damping"),
    ],
)
def test_a_slip_in_a_description_with_a_file_is_one_clear_error(text, message):
    with pytest.raises(FFGymError, match=re.escape(message)) as caught:
        parse(text)
    assert str(caught.value).startswith("mine.toml: ")
    assert "\n" not in str(caught.value)


def test_a_moving_link_that_is_called_as_a_part_of_every_model_is_refused(tmp_path):
    text = (FILES / "kr_like.urdf").read_text().replace('"link_6"', '"tool"')
    (tmp_path / "arm.urdf").write_text(text)
    with pytest.raises(FFGymError, match="clash with the bodies world, base, tool"):
        parse_robot(description_text("arm.urdf", SIX, looks="none"), folder=tmp_path)


def test_a_draft_may_have_a_file_and_nothing_else(tmp_path):
    (tmp_path / "arm.urdf").write_text((FILES / "kr_like.urdf").read_text())
    (tmp_path / "mine.toml").write_text(HEAD.replace("kr_like", "arm") + "looks = 'none'\n")
    draft = load_draft(tmp_path / "mine.toml")
    assert draft.can("kinematics")
    assert "drive.gear_ratio" in draft.missing


def test_a_urdf_without_any_mass_is_geometry_alone(tmp_path):
    """As vendors publish industrial robots; a link without mass among others with mass is an error."""
    root = ET.parse(FILES / "kr_like.urdf").getroot()
    for link in root.findall("link"):
        for inertial in link.findall("inertial"):
            link.remove(inertial)
    path = tmp_path / "light.urdf"
    path.write_bytes(ET.tostring(root))
    bare, whole = (read_arm(file, looks=False) for file in (path, FILES / "kr_like.urdf"))
    assert set(whole.quantities) - set(bare.quantities) == {"links.mass", "links.com", "links.inertia"}
    for name in ("kinematics.position", "kinematics.axis", "kinematics.range"):
        np.testing.assert_array_equal(bare.quantities[name].value, whole.quantities[name].value)
    assert bare.quantities["base.mass"].value == 0
    assert bare.quantities["base.mass"].origin == ("chosen",)
    assert any("no masses" in note for note in bare.notes)
    assert not any("no masses" in note for note in whole.notes)
    draft = parse_draft(description_text(path, whole.types, looks="none"))
    assert draft.missing == ("links.mass", "links.com", "links.inertia")
    masses = "".join(
        entry(name, whole.quantities[name].value.tolist(), unit, "link")
        for name, unit in (("links.mass", "kg"), ("links.com", "m"), ("links.inertia", "kg m^2"))
    )
    robot = parse_robot(description_text(path, whole.types, looks="none", more=masses))
    np.testing.assert_array_equal(robot.bodies.mass, whole.quantities["links.mass"].value)


def test_hints_say_what_the_file_knows_of_the_drives():
    urdf = read_arm(FILES / "ur_like.urdf", looks=False).hints
    assert urdf[0] == JointHints(effort=150.0, speed=3.14159, gear_ratio=101.0)
    assert urdf[5] == JointHints(effort=28.0, speed=3.14159)
    assert read_arm(FILES / "kr_like.urdf", looks=False).hints[0] == JointHints(speed=6.283185307)
    servo = read_arm(FILES / "ur_like.xml", UR_JOINTS, looks=False).hints
    assert servo[2] == JointHints(effort=150.0, armature=0.1, position_gain=2000.0, velocity_gain=400.0)
    geared = read_arm(FILES / "kr_like.xml").hints
    assert geared[0] == JointHints(
        effort=200.0, damping=1.5, friction=8.0, armature=3.2 + 100**2 * 1e-3, gear_ratio=-100.0,
        position_gain=40 * 100.0**2, velocity_gain=3 * 100.0**2,
    )  # fmt: skip
    assert geared[1].gear_ratio == 120.0
    assert geared[1].effort is None
    assert geared[2].effort == 90.0


def test_speeds_of_some_joints_are_hints_and_no_limits_of_the_arm(tmp_path):
    text = (FILES / "ur_like.urdf").read_text().replace('velocity="3.14159"', 'velocity="0"', 1)
    (tmp_path / "arm.urdf").write_text(text)
    arm = read_arm(tmp_path / "arm.urdf", looks=False)
    assert [hint.speed for hint in arm.hints] == [None] + [3.14159] * 5
    assert "kinematics.max_speed" not in arm.quantities


def test_two_motors_of_a_joint_are_no_gear_ratio(tmp_path):
    text = (FILES / "kr_like.xml").read_text()
    (tmp_path / "arm.xml").write_text(text.replace("</actuator>", "<motor joint='joint_a2' gear='60'/></actuator>"))
    assert read_arm(tmp_path / "arm.xml").hints[1].gear_ratio is None


def test_notes_say_what_is_left_out(tmp_path):
    text = (FILES / "kr_like.xml").read_text()
    assert read_arm(FILES / "kr_like.xml").notes == ()
    text = text.replace('frictionloss="8"', 'frictionloss="8" stiffness="3"').replace(
        "<option", '<option density="1.2"'
    )
    text = text.replace('<body name="weight"', '<body name="weight" gravcomp="1"')
    (tmp_path / "arm.xml").write_text(text)
    joints, gravity, medium = read_arm(tmp_path / "arm.xml").notes
    assert joints == "springs in its joints are left out"
    assert gravity.startswith("compensated gravity")
    assert medium.startswith("forces of the air")
    tendon = "<tendon><spatial stiffness='9'><site site='tool0'/><site site='tip'/></spatial></tendon><actuator>"
    (tmp_path / "arm.xml").write_text((FILES / "kr_like.xml").read_text().replace("<actuator>", tendon))
    (note,) = read_arm(tmp_path / "arm.xml").notes
    assert "of its tendons (counterbalances are entries of [springs])" in note


def test_a_robot_from_a_file_can_be_copied_and_pickled():
    robot = described(FILES / "seven_axes.xml", looks="file")
    expected = physics_fingerprint(compile_model(robot))
    for other in (copy.deepcopy(robot), pickle.loads(pickle.dumps(robot))):
        assert physics_fingerprint(compile_model(other)) == expected


def test_physics_do_not_depend_on_looks_or_on_where_the_file_is(tmp_path):
    (tmp_path / "moved.xml").write_text((FILES / "seven_axes.xml").read_text())
    robots = [
        described(FILES / "seven_axes.xml"),
        described(FILES / "seven_axes.xml", looks="file"),
        described(tmp_path / "moved.xml"),
    ]
    assert len(robots[1].geoms) == 7
    assert len({physics_fingerprint(compile_model(robot, ModelOptions(looks=False))) for robot in robots}) == 1
