"""Motions that learning families are trained on: the one of the thesis, and several that show every speed there is."""

from collections.abc import Sequence

from ffgym.core.errors import FFGymError
from ffgym.paths import SPEEDS, Reference
from ffgym.robot import RigidArm
from ffgym.studies import circle_references, sine_references
from ffgym.studies.one_axis import FREQUENCIES


def thesis_motions(arm: RigidArm) -> list[Reference]:
    """The one motion that chapter 5 learns on: circles at p1 at 10 mm/s, or the sine of 1 Hz on one axis.

    Raises:
        FFGymError: if the robot has neither a work area nor one joint alone.
    """
    return training_motions(arm, speeds=SPEEDS[:1], frequencies=FREQUENCIES[:1])


def every_speed(arm: RigidArm) -> list[Reference]:
    """The motions at every speed of the tests: at p1 at 10, 40 and 100 mm/s, or the sines of 1 and 3 Hz on one axis.

    A network trained on them has met all speeds it will meet, which thesis 5.5 misses at higher speeds than trained.

    Raises:
        FFGymError: if the robot has neither a work area nor one joint alone.
    """
    return training_motions(arm, speeds=SPEEDS, frequencies=FREQUENCIES)


def friction_motions(arm: RigidArm) -> list[Reference]:
    """Motions on which friction is most of what the feedback does: p1 at 10 and 40 mm/s, or the sines of 1 and 3 Hz.

    At 100 mm/s the elastic joints ask for more torque than friction does, and a network over speed would learn that as
    friction: with it in training, the tool strays further at 100 mm/s than without (see docs/agents/bspline.md).

    Raises:
        FFGymError: if the robot has neither a work area nor one joint alone.
    """
    return training_motions(arm, speeds=SPEEDS[:2], frequencies=FREQUENCIES)


def training_motions(
    arm: RigidArm,
    positions: Sequence[str] | None = None,
    speeds: Sequence[float] = SPEEDS[:1],
    frequencies: Sequence[float] = FREQUENCIES[:1],
) -> list[Reference]:
    """Test motions of the robot: circles on one with a work area, sines on one with a single joint.

    Args:
        arm: nominal model of the robot.
        positions: names in the work area (circles only); None is the first, p1 in thesis 5.3.2: others are held out.
        speeds: of the TCP [m/s] (circles only).
        frequencies: [Hz] (sines only).

    Raises:
        FFGymError: if the robot has neither a work area nor one joint alone, or cannot follow a motion.
    """
    robot = arm.robot
    if robot.work_area is not None:
        names = list(robot.work_area.positions)[:1] if positions is None else positions
        return list(circle_references(arm, names, speeds).values())
    if robot.n_joints == 1:
        return list(sine_references(robot, frequencies).values())
    raise FFGymError(
        f"Robot {robot.name!r} has no work area and {robot.n_joints} joints, and so no test motion to learn on; "
        f"give references of your own."
    )
