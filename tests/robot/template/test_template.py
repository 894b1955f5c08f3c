"""A table to fill in: complete, explained, silent about what is not known, and filled by rules that say their names."""

import re
import tomllib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ffgym.robot import RigidArm, RobotDraft, load_draft
from ffgym.robot.arm_file import read_arm
from ffgym.robot.reading.parse import parse_draft
from ffgym.robot.reading.rules import REQUIRED, RULES
from ffgym.robot.template import fill_text, propose, template
from ffgym.robot.template.proposals import BRISTLE_TIME, DAMPING_TIME, PRESLIDING, STATIC_SHARE, STRIBECK_VELOCITY
from tests.robot.template.arm_xml import ARM, NUMBERS, entry

HINTED = """<robot name="r">
  <link name="base"><inertial><mass value="9"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="a"><inertial><origin xyz="0.1 0 0"/><mass value="5"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="b"><inertial><origin xyz="0.1 0 0"/><mass value="2"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="j1" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="150" velocity="2"/><dynamics damping="3" friction="4"/></joint>
  <joint name="j2" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="28" velocity="3"/></joint>
</robot>
"""  # noqa: E501


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "arm.xml").write_text(ARM)
    (tmp_path / "arm.urdf").write_text(HINTED)
    return tmp_path


def new(folder, arm="arm.xml", **options):
    return template("mine", read_arm(folder / arm), arm, **options)


def drafted(folder, text) -> RobotDraft:
    return parse_draft(text, where="mine.toml", folder=folder)


def filled(folder, text):
    draft = drafted(folder, text)
    return fill_text(text, propose(draft), draft.types)


def uncommented(text, path):
    """The waiting lines of an entry without their mark, and numbers for the question marks."""
    lines = text.splitlines()
    start = lines.index(f"#? [{path}]")
    stop = next(k for k in range(start, len(lines)) if not lines[k].startswith("#? "))
    entry = [line.removeprefix("#? ").replace('"?"', '"me"').replace("?", "2.0") for line in lines[start:stop]]
    return "\n".join(entry)


def test_every_entry_says_where_its_numbers_are_found_and_which_are_proposed():
    assert all(rule.where for rule in RULES.values())
    for path, proposed in {
        "drive.joint_damping": f"{DAMPING_TIME:g} s x stiffness",
        "friction.static": f"{STATIC_SHARE:g} x coulomb",
        "friction.stribeck_velocity": f"{STRIBECK_VELOCITY:g} rad/s",
        "friction.bristle_stiffness": f"coulomb / {PRESLIDING * 1e3:g} mrad",
        "friction.bristle_damping": f"{BRISTLE_TIME * 1e3:g} ms x bristle stiffness",
    }.items():
        assert RULES[path].where.endswith(f"`ffgym robot fill` proposes {proposed}")


def test_a_new_table_is_a_draft_that_lacks_what_the_arm_file_does_not_say(folder):
    draft = drafted(folder, new(folder))
    assert draft.can("link_torque")
    arm = read_arm(folder / "arm.xml")
    assert set(draft.missing) == set(REQUIRED) - set(arm.quantities)


def test_every_entry_has_its_place_with_meaning_and_advice_and_nothing_is_said_twice(folder):
    text = new(folder)
    given = read_arm(folder / "arm.xml").quantities.keys() | {"flange.position", "flange.rotation", "tool.tcp"}
    for path, rule in RULES.items():
        tables = re.findall(rf"^(?:#\? )?\[{re.escape(path)}\]$", text, flags=re.M)
        assert len(tables) == (path not in given), path
        flat = text.replace("\n# ", " ")
        if path not in given:
            assert f"--- {path}: {rule.meaning}" in flat
            assert rule.where in flat


@pytest.mark.parametrize("path", REQUIRED)
def test_an_entry_whose_marks_are_taken_away_is_valid(folder, path):
    text = new(folder)
    if f"#? [{path}]" in text:
        draft = drafted(folder, text + uncommented(text, path))
        assert path in draft.quantities
        assert draft.quantities[path].source == "me"


SCARA = """<mujoco><worldbody><body name="a"><joint name="j" axis="0 0 1" range="-90 90"/><geom size="0.1" mass="2"/>
  <body name="b" pos="0.4 0 0"><joint name="z" type="slide" axis="0 0 1" range="0 0.2"/><geom size="0.1" mass="1"/>
  </body></body></worldbody></mujoco>"""


@pytest.mark.parametrize("path", REQUIRED)
def test_units_of_sliding_joints_are_those_that_are_read(folder, path):
    (folder / "scara.xml").write_text(SCARA)
    text = new(folder, "scara.xml")
    if f"#? [{path}]" in text:
        assert path in drafted(folder, text + uncommented(text, path)).quantities


def test_usual_sizes_are_those_of_the_joints_there_are(folder):
    def usual(xml, path):
        (folder / "any.xml").write_text(xml)
        said = " ".join(new(folder, "any.xml").split(f"# --- {path}:")[1].split("#?")[0].replace("#", "").split())
        return said.split("Usual: ")[1].split(". Where")[0] if "Usual: " in said else None

    screw, hinge = "a screw of 10 mm a turn has 628 rad/m", "50 to 250, direct drives 1"
    slides = SCARA.replace('range="-90 90"', 'type="slide" range="0 1"')
    found = [usual(xml, "drive.gear_ratio") for xml in (ARM, SCARA, slides)]
    assert found == [hinge, f"{hinge}; {screw}", screw]
    assert [usual(xml, "kinematics.max_speed") for xml in (ARM, slides)] == ["100 to 400 deg/s", None]
    assert [usual(xml, "drive.peak_torque") for xml in (ARM, slides)] == ["1 to 60 N m"] * 2


def test_an_entry_that_was_forgotten_is_no_toml_and_says_so(folder):
    text = new(folder).replace("#? [drive.gear_ratio]\n#? value", "[drive.gear_ratio]\nvalue")
    with pytest.raises(ValueError, match=r"^mine\.toml is not valid TOML"):
        drafted(folder, text)


def test_frames_with_usual_names_become_the_tool_frame_and_others_can_be_asked_for(folder):
    assert 'tool_frame = "tcp"' in new(folder)
    assert drafted(folder, new(folder)).can("kinematics", "tool.tcp")
    assert 'tool_frame = "flange"' in new(folder, tool_frame="flange")
    with pytest.raises(ValueError, match=r"hand.*Available: .*tcp"):
        new(folder, tool_frame="hand")
    assert "tool_frame =" not in new(folder, "arm.urdf")


def test_hints_of_the_arm_file_are_numbers_that_wait_for_the_gear_ratio(folder):
    text = new(folder, "arm.urdf")
    draft = drafted(folder, text)
    assert draft.waiting == ("drive.peak_torque",)
    assert "drive.gear_ratio" in draft.missing
    assert "drive.peak_torque" not in draft.missing
    whole = drafted(folder, text + entry("drive.gear_ratio", [100, 50], "1"))
    np.testing.assert_allclose(whole.quantities["drive.peak_torque"].value, [1.5, 0.56])
    assert "arm.urdf" in whole.quantities["drive.peak_torque"].source
    assert "#? value = [4.0, ?]" in text  # friction of one joint only


def test_names_with_quotes_and_backslashes_survive(folder):
    (folder / 'a "b".xml').write_text(ARM)
    text = template('na"me\\', read_arm(folder / 'a "b".xml'), 'a "b".xml')
    assert tomllib.loads(text)["robot"]["name"] == 'na"me\\'
    assert drafted(folder, text).can("kinematics")


def test_filling_in_leaves_every_other_line_as_it_was(folder):
    text = new(folder) + "".join(NUMBERS.values()) + "\n# my own remark\n"
    after = filled(folder, text)
    kept = [line for line in text.splitlines() if not line.startswith("#? ")]
    remaining = iter(after.splitlines())
    assert all(line in remaining for line in kept)  # in this order
    assert "#? [friction.static]" not in after
    assert "#? [work_area.home]" in after
    bare = text.replace("#? ", "# ")
    assert "\n# my own remark\n\n[drive.joint_damping]\n" in filled(folder, bare)  # no line waits for it


def test_what_a_user_must_know_and_rules_of_thumb_make_a_whole_robot(folder):
    text = filled(folder, new(folder) + "".join(NUMBERS.values()))
    robot = drafted(folder, text).complete()
    chosen = {path for path, quantity in robot.quantities.items() if quantity.origin == ("chosen",)}
    assert chosen >= {"friction.static", "friction.bristle_stiffness", "servo.velocity_gain", "drive.joint_damping"}
    assert filled(folder, text) == text  # nothing is left to propose


def test_a_number_that_is_there_is_never_replaced(folder):
    own = entry("friction.static", [0.9] * 6, "N m", "motor")
    draft = drafted(folder, filled(folder, new(folder) + "".join(NUMBERS.values()) + own))
    np.testing.assert_array_equal(draft.quantities["friction.static"].value, 0.9)
    assert draft.quantities["friction.static"].source == "data sheet"


@pytest.mark.parametrize(
    ("path", "needs"),
    [
        ("friction.bristle_stiffness", "friction.coulomb"),
        ("drive.joint_damping", "drive.joint_stiffness"),
        ("servo.velocity_gain", "drive.rotor_inertia"),
    ],
)
def test_nothing_is_proposed_without_what_it_follows_from(folder, path, needs):
    numbers = [number for name, number in NUMBERS.items() if name != needs]
    draft = drafted(folder, filled(folder, new(folder) + "".join(numbers)))
    assert {path, needs} <= set(draft.missing)


def test_proposals_for_the_built_in_robot_follow_their_rules_and_the_thesis(irb4600):
    whole = load_draft(irb4600.name)
    removed = ("friction.static", "friction.bristle_stiffness", "friction.bristle_damping", "servo.velocity_gain")
    kept = {path: quantity for path, quantity in whole.quantities.items() if path not in removed}
    draft = RobotDraft(
        where="x", name="x", title="x", joints=whole.joints, links=whole.links, types=whole.types, quantities=kept,
        logs=whole.logs,
    )  # fmt: skip
    proposals = {proposal.path: proposal.value for proposal in propose(draft)}
    assert proposals.keys() == set(removed)
    for path in removed[:3]:  # joint 1 is the thesis'; the others are scaled from it
        np.testing.assert_allclose(proposals[path], whole.quantities[path].value, rtol=2e-3)
    mass = np.diag(RigidArm(irb4600).mass_matrix(irb4600.work_area.home[None])[0])
    inertia = irb4600.drive.rotor_inertia + mass / irb4600.drive.gear_ratio**2
    np.testing.assert_allclose(proposals["servo.velocity_gain"], 90 * inertia)


def test_rigid_joints_get_no_damping(folder):
    numbers = NUMBERS | {
        "drive.joint_stiffness": entry("drive.joint_stiffness", "[inf, inf, inf, 4e4, 4e4, 3e4]", "N m/rad", "link")
    }
    draft = drafted(folder, filled(folder, new(folder) + "".join(numbers.values())))
    np.testing.assert_allclose(draft.quantities["drive.joint_damping"].value, [0, 0, 0, 32, 32, 24])


@settings(max_examples=40)
@given(control_dt=st.floats(1e-4, 0.02))
def test_the_proposed_physics_step_divides_any_control_step_and_is_short(control_dt):
    text = '[robot]\nname = "x"\ntitle = "x"\njoints = ["a"]\nlinks = ["b"]\n' + entry(
        "servo.control_dt", control_dt, "s"
    )
    draft = parse_draft(text)
    step = float(parse_draft(fill_text(text, propose(draft), draft.types)).quantities["simulation.physics_dt"].value)
    assert abs(control_dt / step - round(control_dt / step)) < 1e-9
    assert 0 < step <= 2.5e-4 * (1 + 1e-9)


def test_what_the_arm_file_could_say_is_asked_with_the_way_to_let_it(folder):
    text = template("mine", read_arm(folder / "arm.xml"), "arm.xml", tool_frame="flange")
    assert "[flange.rotation]" not in text
    no_frame = ARM.replace('name="tcp"', 'name="nozzle"').replace('name="flange"', 'name="last"')
    (folder / "plain.xml").write_text(no_frame)
    text = template("mine", read_arm(folder / "plain.xml"), "plain.xml")
    where = text.split("# --- flange.rotation")[1].split("#? [flange.rotation]")[0]
    assert "tool_frame in [robot] instead of this table" in " ".join(where.replace("#", "").split())
