"""What a robot's own logs mean: the header of a recording, from its description."""

from ffgym.recordings import Header
from ffgym.recordings.header import Hold
from ffgym.robot.description import RobotDescription


def log_header(robot: RobotDescription, segment: str = "", hold: Hold = "sampled") -> Header:
    """Header for a log of the robot: joints, gears, sides of position and torque, tool as payload.

    Args:
        robot: the robot; its table [logs] says on which side of the gearbox positions and torques are logged.
        segment: name of the motion.
        hold: when the torque of a row acts (docs/recordings.md).

    Raises:
        FFGymError: if `hold` is unknown.
    """
    drive, tool = robot.drive, robot.tool
    return Header(
        robot=robot.name,
        joints=robot.joints,
        gear_ratio=tuple(drive.gear_ratio.tolist()),
        coupling=None if drive.coupling is None else drive.coupling.tolist(),
        joint_types=robot.kinematics.types,
        position_side=robot.logs.position,
        torque_semantics=robot.logs.torque,
        hold=hold,
        payload=None if tool is None else {"mass": tool.mass, "com": tool.com.tolist()},
        segment=segment,
    )
