"""Motions from RAPID programs."""

from pathlib import Path

from ffgym.paths.limits import MotionLimits
from ffgym.paths.motions.composition import compose
from ffgym.paths.motions.motion import Motion
from ffgym.paths.rapid import load_program, on_branches
from ffgym.robot import RigidArm


def rapid_motion(
    arm: RigidArm, path: str | Path, *, entry: str | None = None, limits: MotionLimits | None = None
) -> Motion:
    """Motion of a program, for the robot with the program's tool; it starts at the first target.

    Args:
        arm: the robot.
        path: program file.
        entry: procedure that is run; None takes main, or the only one.
        limits: of speed, acceleration and jerk, beside the programmed speeds; None takes the defaults.

    Raises:
        FFGymError: if the program cannot be read, run or carried out; the message begins with the place.
    """
    execution = load_program(path).execute(arm.robot, entry)
    if execution.robot is not arm.robot:
        arm = RigidArm(execution.robot)
    moves, notes = on_branches(arm, execution)
    motion = compose(arm, moves, limits=limits, name=Path(path).stem)
    return Motion(reference=motion.reference, notes=(*notes, *motion.notes))
