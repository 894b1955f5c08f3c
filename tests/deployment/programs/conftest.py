"""A plan of a short motion: a line, half a circle and a rest, under elastic feed-forward."""

import pytest

from ffgym import elastic_feedforward
from ffgym.control import invert_servo
from ffgym.deployment import SetpointPlan
from ffgym.paths import load_motion

PROGRAM = r"""MODULE short
CONST robtarget p := [[1300, -200, 600], [0, 0, 1, 0], [-1, 0, -1, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
PROC main()
MoveJ p, v100, fine, tRobot;
MoveL Offs(p, 10, 0, 0), v50, fine, tRobot;
WaitTime 0.6;
MoveC Offs(p, 15, 5, 0), Offs(p, 20, 0, 0), v20, fine, tRobot;
ENDPROC
ENDMODULE
"""


@pytest.fixture(scope="session")
def plan(arm, tmp_path_factory) -> SetpointPlan:
    """Plan of the motion for the six-axis robot."""
    path = tmp_path_factory.mktemp("plan") / "short.mod"
    path.write_text(PROGRAM)
    robot, reference = arm.robot, load_motion(arm, path).reference
    law = elastic_feedforward(robot)
    torque = law.torque(reference)
    correction = robot.drive.joint_angle(invert_servo(robot.servo, torque))
    return SetpointPlan(
        name="short",
        robot=robot.name,
        law=law.name,
        joints=tuple(robot.joints),
        units=tuple(robot.kinematics.units),
        dt=robot.servo.control_dt,
        program=reference.q,
        correction=correction - correction[0],
        torque=torque,
    )
