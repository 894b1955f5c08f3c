"""Numbers of a description that is changed in Python are checked as those of a file are, and are its own."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.robot import load_robot

SIX = load_robot("irb4600_60_205")
ENTRIES = {
    "links.mass": "bodies",
    "links.com": "bodies",
    "links.inertia": "bodies",
    "drive.gear_ratio": "drive",
    "drive.rotor_inertia": "drive",
    "drive.joint_stiffness": "drive",
    "drive.joint_damping": "drive",
    "drive.peak_torque": "drive",
    "servo.position_gain": "servo",
    "servo.velocity_gain": "servo",
    "servo.integral_gain": "servo",
    "kinematics.axis": "kinematics",
    "kinematics.range": "kinematics",
    "kinematics.max_speed": "kinematics",
    "work_area.home": "work_area",
}
NOT_NEGATIVE = [path for path in ENTRIES if path.split(".")[1] not in ("com", "gear_ratio", "axis", "range", "home")]


def changed(path, change):
    part, name = ENTRIES[path], path.split(".")[1]
    values = np.array(getattr(getattr(SIX, part), name))
    return replace(SIX, **{part: replace(getattr(SIX, part), **{name: change(values)})})


@pytest.mark.parametrize("path", ENTRIES)
@pytest.mark.parametrize(
    "change",
    [
        lambda x: x * np.nan,
        lambda x: x[:-1],
        lambda x: np.append(x, x[-1:], axis=0),
        lambda x: float(x.flat[0]),
        lambda x: None,
        lambda x: x.astype(str),
        lambda x: np.ma.masked_array(x, mask=np.arange(x.size).reshape(x.shape) == 2),
    ],
    ids=["no_number", "short", "long", "one_number", "none", "text", "masked"],
)
def test_numbers_that_are_not_one_for_each_joint_are_refused_by_name(path, change):
    table = path.split(".")[0]
    with pytest.raises(FFGymError, match=rf"^{path} |^{table}\.\w+ has shape|^{table} of robot .* is of [57] joints"):
        changed(path, change)


@pytest.mark.parametrize("path", NOT_NEGATIVE)
def test_negative_numbers_of_a_positive_quantity_are_refused(path):
    with pytest.raises(FFGymError, match=rf"{path}\b.* must be "):
        changed(path, lambda x: -x)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"physics_dt": 1e-9}, r"simulation.physics_dt = 1e-09 must be >= 1e-06"),
        ({"physics_dt": np.nan}, "simulation.physics_dt must be finite"),
        ({"gravity": [0.0, -9.81]}, r"simulation.gravity has shape \(2,\)"),
        ({"base_mass": -1.0}, "base.mass = -1.0 must be >= 0"),
        ({"servo": replace(SIX.servo, control_dt=np.nan)}, "servo.control_dt must be finite"),
        ({"drive": replace(load_robot("two_link").drive)}, "drive of robot 'irb4600_60_205' is of 2 joints"),
    ],
)
def test_a_number_of_the_robot_itself_is_refused_by_name(fields, message):
    with pytest.raises(FFGymError, match=message):
        replace(SIX, **fields)


def test_a_gear_ratio_of_0_and_a_tool_that_is_not_turned_but_stretched_are_refused():
    with pytest.raises(FFGymError, match=r"drive.gear_ratio = .* must not be 0"):
        changed("drive.gear_ratio", lambda x: 0 * x)
    with pytest.raises(FFGymError, match=r"flange.rotation = .* is not a rotation matrix"):
        replace(SIX.tool, rotation=2 * np.eye(3))


def test_numbers_may_be_given_as_lists_and_stay_when_an_array_that_was_given_changes():
    ratios = SIX.drive.gear_ratio.copy()
    robots = [changed("drive.gear_ratio", lambda x: ratios), changed("drive.gear_ratio", lambda x: x.tolist())]
    ratios[0] = np.nan
    for robot in robots:
        np.testing.assert_array_equal(robot.drive.gear_ratio, SIX.drive.gear_ratio)
