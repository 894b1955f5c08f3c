"""Headers of a robot's own logs say what its description says."""

from dataclasses import replace

import numpy as np

from ffgym.recordings import Recording
from ffgym.robot import load_robot, log_header


def test_a_log_has_the_sides_and_gears_of_the_description():
    robot = load_robot("ball_screw")
    header = log_header(robot, segment="lap 1")
    assert (header.robot, header.joints, header.segment) == ("ball_screw", ("x",), "lap 1")
    assert (header.position_side, header.torque_semantics) == ("link", "link_side")
    assert header.joint_types == ("slide",)
    assert header.gear_ratio == tuple(robot.drive.gear_ratio)
    assert header.payload is None


def test_motors_that_turn_with_other_joints_are_told(irb4600):
    coupling = np.zeros((6, 6))
    coupling[4, 3] = 2.0
    header = log_header(replace(irb4600, drive=replace(irb4600.drive, coupling=coupling)))
    assert header.coupling[4][3] == 2.0
    assert header.payload == {"mass": 8.0, "com": [0.045, 0.0, 0.1229]}


def test_a_log_with_such_a_header_is_a_recording(one_axis):
    columns = {"timestamp": np.arange(3.0), "motor.position.j1": np.zeros(3), "motor.effort.j1": np.ones(3)}
    header = log_header(one_axis, hold="zoh")
    assert Recording(columns, header).header.hold == "zoh"
