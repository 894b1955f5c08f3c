"""Motions by name or from a file, as references for a robot."""

from collections.abc import Callable, Mapping
from pathlib import Path

from ffgym.control import cartesian_reference
from ffgym.errors import FFGymError, check_choice
from ffgym.motions.motion import Motion
from ffgym.motions.rapid import rapid_motion
from ffgym.paths import circle_test
from ffgym.robot import RigidArm

READERS: Mapping[str, Callable[[RigidArm, Path], Motion]] = {".mod": rapid_motion, ".prg": rapid_motion}
"""What reads a file, by the suffix of its name."""


def list_motions() -> tuple[str, ...]:
    """Names of the motions that ship with the package."""
    return ("circles",)


def load_motion(arm: RigidArm, source: str | Path) -> Motion:
    """Motion for a robot from a built-in name, or from a file by path.

    Args:
        arm: the robot.
        source: a name of `list_motions`, or a path whose suffix is one of READERS.

    Raises:
        FFGymError: if there is no such motion or file, or the robot cannot make it.
    """
    reader = READERS.get(Path(source).suffix.lower())
    if reader is not None:
        return reader(arm, Path(source))
    if not isinstance(source, str) or Path(source).suffix:
        raise FFGymError(f"Motion {str(source)!r}: a motion file must end in {', '.join(READERS)}.")
    check_choice("motion", source, list_motions())
    area = arm.robot.work_area
    if area is None or not area.positions:
        raise FFGymError(f"Robot {arm.robot.name!r} has no work area.")
    centre = next(iter(area.positions.values()))
    return Motion(reference=cartesian_reference(arm, circle_test(centre, 0.04, dt=arm.robot.servo.control_dt)))
