"""One slip in a description is one error that names the file and the entry, and nothing else ever goes wrong."""

import copy
import re
import tomllib
from dataclasses import replace
from importlib import resources

import numpy as np
import pytest
import tomlkit
from hypothesis import given, settings
from hypothesis import strategies as st

from ffgym.core.errors import FFGymError
from ffgym.robot import RobotDescription, builtin_robots, parse_robot
from ffgym.robot.model.spec import ModelOptions, compile_model

TEXTS = {
    name: (resources.files("ffgym.robot") / "data" / f"{name}.toml").read_text(encoding="utf-8")
    for name in builtin_robots()
}
TREES = {name: tomllib.loads(text) for name, text in TEXTS.items()}
IRB = "irb4600_60_205"
NAN, INF = np.nan, np.inf


def paths(tree, path=()):
    """Every place in a tree of tables and lists."""
    entries = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in entries:
        yield (*path, key)
        yield from paths(value, (*path, key))


def changed(name, path, value):
    """TOML text of a built-in robot with one place set to `value`, or removed if that is None."""
    tree = copy.deepcopy(TREES[name])
    inner = tree
    for key in path[:-1]:
        inner = inner[key]
    if value is None:
        del inner[path[-1]]
    else:
        inner[path[-1]] = value
    return tomlkit.dumps(tree)


def robot_or_refusal(text):
    """Parse; anything but a robot that compiles or an FFGymError of one line is a failure."""
    try:
        robot = parse_robot(text, where="mine.toml")
    except FFGymError as error:
        assert str(error).startswith("mine.toml")  # noqa: PT017
        assert "\n" not in str(error)  # noqa: PT017
        return None
    assert isinstance(robot, RobotDescription)
    return robot


SLIPS = [
    (("drive", "gear_ratio", "unit"), "rad", "drive.gear_ratio: unit is 'rad', must be '1'"),
    (("kinematics", "range", "unit"), "m", "kinematics.range: unit is 'm', must be 'rad' or 'deg'"),
    (("kinematics", "max_speed", "unit"), "deg", "kinematics.max_speed: unit is 'deg', must be 'rad/s' or 'deg/s'"),
    (("friction", "coulomb", "side"), "arm", "friction.coulomb: side is 'arm', must be 'motor' or 'link'"),
    (("kinematics", "range", "side"), "motor", "kinematics.range: side is 'motor', must be 'link'"),
    (("friction", "coulomb", "side"), None, "friction.coulomb: side is None"),
    (("tool", "mass", "side"), "motor", "tool.mass: side is 'motor', must be None"),
    (("drive", "gear_ratio", "value"), [120.0] * 5, "drive.gear_ratio has shape (5,), must be (6)"),
    (("links", "com", "value", 2), [0.0, 0.0], "links.com must be numbers"),
    (("links", "mass", "value", 1), NAN, "links.mass must be finite"),
    (("links", "mass", "value", 1), 0.0, "links.mass = "),
    (("links", "mass", "value", 1), -1.0, "must be > 0.0 kg"),
    (("drive", "gear_ratio", "value", 1), INF, "drive.gear_ratio must be finite"),
    (("drive", "joint_stiffness", "value", 1), -INF, "drive.joint_stiffness must be finite"),
    (("drive", "joint_stiffness", "value", 1), "stiff", "drive.joint_stiffness must be numbers"),
    (("drive", "joint_damping", "value", 1), -0.1, "drive.joint_damping = "),
    (("servo", "control_dt", "value"), "0.004", "servo.control_dt must be numbers, got '0.004'"),
    (("servo", "control_dt", "value"), True, "servo.control_dt must be numbers"),
    (("servo", "control_dt", "value"), 0.0041, "must be a whole multiple of simulation.physics_dt"),
    (("servo", "control_dt", "value"), 0.0001, "must be a whole multiple of simulation.physics_dt"),
    (("servo", "control_dt", "value"), 10**400, "servo.control_dt must be numbers"),
    (("sensors", "encoder_bits", "value"), 16.5, "sensors.encoder_bits = 16.5 must be a whole number"),
    (("base", "mass", "origin"), "guessed", "base.mass: origin is 'guessed', must be one of"),
    (("base", "mass", "origin"), 3, "base.mass: origin is 3"),
    (("links", "mass", "origin"), ["derived"] * 5, "links.mass: origin is"),
    (("base", "mass", "source"), "", "base.mass: source is ''"),
    (("base", "mass", "source"), "  ", "base.mass: source is"),
    (("base", "mass", "source"), None, "base.mass lacks ['source']"),
    (("base", "mass", "note"), "heavy", "base.mass lacks [] and has unknown keys ['note']"),
    (("base", "mass", "unit"), ["kg"], "base.mass: unit is ['kg']"),
    (("base", "height"), {"value": 1}, "Unknown entries ['base.height']"),
    (("base", "mass"), None, "Missing entries: base.mass"),
    (("base", "mass"), 57.2, "base.mass must be a table"),
    (("base",), 57.2, "[base] must be a table"),
    (("friction",), None, "Missing entries: friction.bristle_damping, friction.bristle_stiffness"),
    (("friction", "static", "value", 0), 0.1, "friction static"),
    (("servo", "position_gain", "prior", 0), -1.0, "servo.position_gain.prior = "),
    (("servo", "position_gain", "prior"), None, "servo.position_gain: prior and prior_source belong to origin"),
    (("servo", "position_gain", "prior_source"), None, "servo.position_gain: prior and prior_source belong to"),
    (("servo", "position_gain", "prior_source"), " ", "servo.position_gain: prior_source is ' '"),
    (("servo", "position_gain", "origin"), "chosen", "servo.position_gain: prior and prior_source belong to"),
    (("tool", "mass", "prior"), 8.0, "tool.mass: prior and prior_source belong to origin 'fitted'"),
    (("robot", "joints", 0), "j2", "must be unique"),
    (("robot", "joints"), [], "[robot] joints must be names"),
    (("robot", "joints"), "abcdef", "[robot] joints must be names, non-empty text"),
    (("robot", "name"), 7, "[robot] name and title must be names, non-empty text"),
    (("robot", "maker"), "me", "[robot] must have exactly name, title, joints and links"),
    (("robot",), None, "[robot] must have exactly"),
    (("kinematics", "axis", "value", 0), [0.0, 0.0, 0.0], "kinematics.axis"),
    (("kinematics", "axis", "value", 0), [0.0, 0.0, 1e300], "kinematics.axis"),
    (("kinematics", "range", "value", 0), [90.0, -90.0], "kinematics.range"),
    (("links", "inertia", "value", 0, 0), -5.8, "links.inertia[0]"),
    (("links", "inertia", "value", 0, 0), 58.2, "links.inertia[0] = "),
    (("links", "inertia", "value", 5), [0.0, 1.0, 1.0, 0.0, 0.0, 0.0], "links.inertia[5] = "),
    (("tool", "inertia", "value", 3), 1.0, "tool.inertia = "),
    (("tool", "tcp"), None, "tool.tcp is missing"),
    (("flange",), None, "flange.rotation is missing"),
    (("flange", "rotation", "value", 0), [0.0, 0.0, -1.0], "flange.rotation = "),
    (("work_area", "tool_rotation", "value", 0), [1.0, 0.0, 0.5], "work_area.tool_rotation = "),
    (("work_area", "positions", "p1", "value"), [1.0, 2.0], "work_area.positions.p1 has shape (2,)"),
    (("work_area", "positions"), 3, "[work_area.positions] must be a table"),
    (("work_area", "home"), None, "work_area.home is missing"),
    (("work_area", "home", "value", 1), 900.0, "work_area.home of j2 = 15.708 is outside its range, ["),
    (("drive", "gear_ratio", "value", 0), 1e300, "gives rotors of [inf, "),
    (("simulation", "physics_dt", "value"), 1e-9, "simulation.physics_dt = 1e-09 must be >= 1e-06 s"),
    (("look", "geoms", 0, "body"), "leg", "Unknown look.geoms[0] body 'leg'"),
    (("look", "geoms", 0, "colour"), "pink", "Unknown look.geoms[0] colour 'pink'"),
    (("look", "geoms", 0, "type"), "cone", "Unknown look.geoms[0] type 'cone'"),
    (("look", "geoms", 0, "centre"), None, "lacks 'centre'"),
    (("look", "geoms", 0, "centre"), [0.0, 1.0], "look.geoms[0] centre has shape (2,)"),
    (("look", "geoms", 1, "radius"), "wide", "look.geoms[1] radius must be a number"),
    (("look", "geoms", 1, "radius"), -0.1, "sizes and lengths must be > 0"),
    (("look", "colours", "paint"), "red", "look.colours.paint must be numbers"),
    (("look", "sky"), 1, "[look] has unknown entries ['sky']"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("path", "value", "message"), SLIPS, ids=[f"{i}-{'.'.join(map(str, s[0]))}" for i, s in enumerate(SLIPS)]
)
def test_a_slip_is_refused_with_file_and_entry(path, value, message):
    with pytest.raises(FFGymError, match=re.escape(message)) as caught:
        parse_robot(changed(IRB, path, value), where="mine.toml")
    assert str(caught.value).startswith("mine.toml: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kept", ["tool_rotation", "positions"])
def test_a_work_area_needs_a_home(kept):
    tree = copy.deepcopy(TREES[IRB])
    tree["work_area"] = {kept: tree["work_area"][kept]}
    with pytest.raises(FFGymError, match=rf"work_area\.{kept}\S* needs work_area\.home|work_area\.home is missing"):
        parse_robot(tomlkit.dumps(tree))


def test_a_work_area_may_leave_the_orientation_of_the_tool_free():
    tree = copy.deepcopy(TREES[IRB])
    del tree["work_area"]["tool_rotation"]
    area = parse_robot(tomlkit.dumps(tree)).work_area
    assert area.tool_rotation is None
    assert set(area.positions) == {"p1", "p2", "p3", "p4"}


@pytest.mark.parametrize(("link", "message"), [("wrist", "unique"), ("tool", "clash"), ("wrist_rotor", "clash")])
def test_two_bodies_of_one_name_are_refused(irb4600, link, message):
    with pytest.raises(FFGymError, match=message):
        replace(irb4600, links=(link, *irb4600.links[1:]))


def test_a_robot_has_one_link_per_joint(irb4600):
    with pytest.raises(FFGymError, match="5 joints and 6 links"):
        replace(irb4600, joints=irb4600.joints[1:])


PLACES = [(name, path) for name, tree in TREES.items() for path in paths(tree)]
ODD_NUMBERS = [NAN, INF, -INF, 0, -1.0, 1e300, 10**400, True]
ODD = [*ODD_NUMBERS, "x", "", "1.0", [], [1.0], [[1.0]], [1, "a"], [[1], [2, 3]], {}, {"a": 1}, None]


@settings(max_examples=80)
@given(st.sampled_from(PLACES), st.sampled_from(ODD))
def test_any_value_in_any_place_is_a_robot_or_a_refusal(place, odd):
    if odd != 1e300:  # a robot of 1e300 kg may well be refused by the engine
        robot = robot_or_refusal(changed(*place, odd))
        if robot is not None:
            compile_model(robot, ModelOptions())


@settings(max_examples=60)
@given(st.sampled_from(sorted(TEXTS)), st.data())
def test_a_text_without_some_of_its_lines_is_a_robot_or_a_refusal(name, data):
    lines = TEXTS[name].splitlines()
    first = data.draw(st.integers(0, len(lines) - 1))
    count = data.draw(st.integers(1, 8))
    robot_or_refusal("\n".join(lines[:first] + lines[first + count :]))


@settings(max_examples=60)
@given(st.sampled_from(sorted(TEXTS)), st.data())
def test_a_text_that_is_cut_off_or_overwritten_is_a_robot_or_a_refusal(name, data):
    text = TEXTS[name]
    start = data.draw(st.integers(0, len(text)))
    junk = data.draw(st.text('[]{}="\n.,#0123e-+ainf_\\\0é\ud800', max_size=12))
    end = data.draw(st.sampled_from([len(text), start, start + len(junk)]))
    robot_or_refusal(text[:start] + junk + text[end:])


@settings(max_examples=100)
@given(st.binary(max_size=60).map(lambda b: b.decode("latin-1")) | st.just("a=" + "[" * 5000))
def test_random_text_is_refused(text):
    assert robot_or_refusal(text) is None
