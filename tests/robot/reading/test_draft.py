"""Descriptions that lack entries: what is missing, what works without it, and that nothing is invented."""

import copy
import re
import tomllib
from importlib import resources

import numpy as np
import pytest
import tomlkit

from ffgym.core.errors import FFGymError
from ffgym.robot import RigidArm, load_robot, parse_robot, resonances
from ffgym.robot.reading import draft
from ffgym.robot.reading.load import load_draft
from ffgym.robot.reading.parse import parse_draft
from ffgym.robot.reading.rules import CAPABILITIES, REQUIRED, RULES, capability, list_capabilities_needing

NAME = "irb4600_60_205"
TREE = tomllib.loads((resources.files("ffgym.robot") / "data" / f"{NAME}.toml").read_text(encoding="utf-8"))
GEOMETRY = {"kinematics.position", "kinematics.axis", "kinematics.range"}


def text_without(*paths, **changes):
    """TOML text of the built-in robot without some entries; `changes` are sides by entry, with _ for the dot."""
    tree = copy.deepcopy(TREE)
    for path in paths:
        group, entry = path.split(".")
        del tree[group][entry]
    for path, side in changes.items():
        group, entry = path.split("_", 1)
        tree[group][entry]["side"] = side
    return tomlkit.dumps(tree)


def draft_without(*paths, **changes):
    return parse_draft(text_without(*paths, **changes), where="mine.toml")


def test_a_whole_description_lacks_nothing_and_allows_everything():
    whole = load_draft(NAME)
    assert whole.missing == ()
    assert all(whole.can(entry.name) for entry in CAPABILITIES)
    robot = whole.complete()
    assert robot.quantities.keys() == load_robot(NAME).quantities.keys()


@pytest.mark.parametrize("path", REQUIRED)
def test_without_an_entry_exactly_those_functions_are_lost_that_need_it(path):
    lacking = draft_without(path)
    assert lacking.missing == (path,)
    lost = {entry.name for entry in CAPABILITIES if not lacking.can(entry.name)}
    assert lost == {entry.name for entry in list_capabilities_needing(path)}
    assert lost >= {"simulation", "circles"}
    for name in lost:
        assert lacking.lacks(name) == (path,)


@pytest.mark.parametrize("path", REQUIRED)
def test_loading_says_what_is_missing_what_is_lost_and_which_command_helps(path):
    with pytest.raises(FFGymError, match=rf"^mine\.toml: Missing entries: {re.escape(path)}\. ") as caught:
        parse_robot(text_without(path), where="mine.toml")
    assert "ffgym robot check mine.toml" in str(caught.value)
    assert capability("simulation").title in str(caught.value)


def test_a_function_that_lacks_entries_is_refused_with_their_names():
    lacking = draft_without("links.mass", "drive.gear_ratio")
    with pytest.raises(FFGymError, match=r"mine\.toml: motor torque .* there is no links\.mass, drive\.gear_ratio\."):
        lacking.description_for("motor_torque")
    with pytest.raises(FFGymError, match=r"there is no drive\.gear_ratio\."):
        lacking.description_for("kinematics", "drive.gear_ratio")
    assert lacking.description_for("kinematics").n_joints == 6


def test_an_unknown_capability_is_refused_with_those_there_are():
    with pytest.raises(FFGymError, match=r"Unknown capability 'flying'\. Available: kinematics, "):
        draft_without().can("flying")


@pytest.mark.parametrize(
    ("name", "compute"),
    [
        ("kinematics", lambda robot, q: RigidArm(robot).tcp_position(q)),
        ("kinematics", lambda robot, q: RigidArm(robot).jacobian(q)),
        ("link_torque", lambda robot, q: RigidArm(robot).gravity_torque(q)),
        ("link_torque", lambda robot, q: RigidArm(robot).inverse_dynamics(q, q, q)),
        ("motor_torque", lambda robot, q: robot.drive.motor_torque(RigidArm(robot).gravity_torque(q))),
        ("motor_torque", lambda robot, q: robot.drive.rotor_inertia * robot.drive.motor_angle(q)),
        ("locked_resonances", lambda robot, q: resonances(RigidArm(robot), q[0])),
        ("resonances", lambda robot, q: resonances(RigidArm(robot), q[0], "free")),
        ("lugre_static", lambda robot, q: robot.friction.steady_torque(robot.drive.motor_angle(q))),
    ],
)
def test_results_of_an_incomplete_robot_do_not_depend_on_the_stand_ins(name, compute, monkeypatch, irb4600):
    needs = capability(name).needs
    lacking = draft_without(*(path for path in REQUIRED if path not in needs))
    q = np.array([[0.1, 0.2, -0.3, 0.4, 0.5, -0.6], [0.0, 0.5, 0.5, 0.1, -0.2, 1.0]])
    usual = compute(lacking.description_for(name), q)
    given = draft.stand_ins
    monkeypatch.setattr(draft, "stand_ins", lambda values, n: given(values, n, size=3.7))
    for same in (compute(lacking.description_for(name), q), compute(irb4600, q)):
        np.testing.assert_allclose(same, usual, rtol=1e-11, atol=1e-11)  # the mass of the base rounds the engine's sums


def test_circles_need_a_place():
    tree = copy.deepcopy(TREE)
    del tree["work_area"]["positions"]
    nowhere = parse_draft(tomlkit.dumps(tree))
    assert nowhere.missing == ()
    assert nowhere.lacks("circles") == ("work_area.positions",)
    assert nowhere.can("simulation")
    assert nowhere.complete().work_area.positions == {}


def test_stand_ins_are_no_quantities():
    lacking = draft_without("links.mass")
    assert "links.mass" not in lacking.description_for("kinematics").quantities


def test_a_wrong_entry_is_an_error_even_where_others_are_missing():
    tree = copy.deepcopy(TREE)
    del tree["servo"], tree["links"]["mass"]
    tree["friction"]["static"]["value"][2] = 0.1
    with pytest.raises(FFGymError, match=r"^mine\.toml: friction static"):
        parse_draft(tomlkit.dumps(tree), where="mine.toml")


def test_a_number_of_the_other_side_waits_for_the_gear_ratio():
    waiting = draft_without("drive.gear_ratio", friction_coulomb="link")
    assert waiting.waiting == ("friction.coulomb",)
    assert waiting.missing == ("drive.gear_ratio",)
    assert waiting.lacks("lugre_static") == ("drive.gear_ratio",)
    known = draft_without(friction_coulomb="link", friction_static="link")
    assert known.waiting == ()
    ratio = known.quantities["drive.gear_ratio"].value
    np.testing.assert_allclose(known.quantities["friction.coulomb"].value * ratio, TREE["friction"]["coulomb"]["value"])


@pytest.mark.parametrize(
    ("path", "lost", "kept"),
    [
        ("tool.mass", "link_torque", "kinematics"),
        ("tool.tcp", "tool_paths", "kinematics"),
        ("flange.rotation", "circles", "kinematics"),
        ("work_area.home", "tool_paths", "kinematics"),
    ],
)
def test_a_group_that_was_begun_must_be_finished(path, lost, kept):
    begun = draft_without(path)
    assert begun.missing == (path,)
    assert path in begun.lacks(lost)
    assert begun.can(kept)
    assert begun.description_for(kept).quantities.keys() >= GEOMETRY
    with pytest.raises(FFGymError, match=f"{re.escape(path)} is missing"):
        begun.complete()


def test_every_entry_of_a_description_serves_some_function():
    optional = {path for path, rule in RULES.items() if rule.optional}
    used = {path for entry in CAPABILITIES for path in entry.needs}
    assert used >= set(REQUIRED)
    assert optional - used == {
        "flange.position", "tool.mass", "tool.com", "tool.inertia", "drive.coupling",
        "drive.torque_lag", "drive.torque_delay", "drive.torque_rate", "drive.resolver_period",
        "friction.arm_share", "drive.torque_per_current", "drive.rated_torque",  # for logs
        "sensors.tracker_noise", "sensors.tracker_period", "work_area.tool_rotation", "work_area.normal",
    }  # fmt: skip


def test_a_home_far_from_zero_fits_a_draft_without_joint_ranges():
    tree = copy.deepcopy(TREE)
    del tree["kinematics"]["range"]
    tree["work_area"]["home"]["value"] = [170.0, -80.0, 10.0, 0.0, 90.0, -300.0]
    parse_draft(tomlkit.dumps(tree)).check()
