"""Points of corrected programs at which the robot stops."""

import numpy as np

from ffgym.deployment import SetpointPlan
from ffgym.deployment.programs.points import choose_points
from ffgym.deployment.programs.rapid import write_rapid
from ffgym.robot import RigidArm, RobotDescription


def plan_of(robot: RobotDescription, pause: bool) -> SetpointPlan:
    """Move the first joint, then the second, with a stop between them or a blend of both."""
    t = np.linspace(0.0, 1.0, 76)
    rise = t**3 * (10 - 15 * t + 6 * t**2)
    shift = 75 if pause else 37
    first = np.concatenate([rise, np.ones(shift)])
    second = np.concatenate([np.zeros(shift), rise])
    program = np.tile(np.asarray(robot.work_area.home), (len(first), 1))
    program[:, 0] += 0.05 * first
    program[:, 1] += 0.05 * second
    nothing = np.zeros_like(program)
    return SetpointPlan(
        name="corner",
        robot=robot.name,
        law="none",
        joints=robot.joints,
        units=robot.kinematics.units,
        dt=0.004,
        program=program,
        correction=nothing,
        torque=nothing,
    )


def test_a_sharp_corner_at_which_the_program_stops_for_an_instant_is_no_corner_to_round(
    irb4600: RobotDescription,
) -> None:
    arm = RigidArm(irb4600)
    sharp, round_ = (choose_points(plan_of(irb4600, pause), arm) for pause in (True, False))
    inner = sharp.stops[1:-1]
    assert np.abs(sharp.t[1:-1][inner] - 0.3).min() < 0.02
    assert not round_.stops[1:-1].any()
    assert write_rapid(sharp, arm)["corner.mod"].count(",fine,") == sharp.stops.sum()
