"""Clean logs to break: simulated with the sensors of the robot."""

from functools import cache

from ffgym.paths.motions import load_motion
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.simulation import Run, sensors_of, simulate


@cache
def clean_log(robot: str, motion: str, *, sensors: bool = True) -> Recording:
    """A shipped motion on a shipped robot."""
    arm = RigidArm(load_robot(robot))
    reference = load_motion(arm, motion).reference
    arm = arm if reference.robot is arm.robot else RigidArm(reference.robot)
    measured = sensors_of(arm.robot) if sensors else ()
    return simulate([Run(reference=reference)], arm=arm, sensors=measured, seed=3)[0]


@cache
def described(robot: str, motion: str) -> RobotDescription:
    """The description of the machine that ran it: a motion may bring its own tool."""
    return load_motion(RigidArm(load_robot(robot)), motion).reference.robot
