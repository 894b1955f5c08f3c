"""The reference that a recording says its controller tracked."""

import numpy as np
from scipy.interpolate import CubicSpline

from ffgym.control import Reference
from ffgym.errors import FFGymError
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription


def reference_of(robot: RobotDescription, recording: Recording) -> Reference:
    """Set-points of a recording at the control step, from 0 s on, without phases; they are smooth in between.

    Raises:
        FFGymError: if the recording has no set-points, or the robot cannot make the motion.
    """
    if not recording.has("reference.position"):
        raise FFGymError(
            f"Recording {recording.header.segment!r} has no reference.position, so it cannot be run again."
        )
    dt = robot.servo.control_dt
    position = recording.joint_array("reference.position")
    q = position if recording.header.position_side == "link" else robot.drive.joint_angle(position)
    since = recording.t - recording.t[0]
    t = dt * np.arange(int(np.floor(since[-1] / dt + 1e-6)) + 1, dtype=np.float64)
    curve = CubicSpline(since, q)
    return Reference(
        name=recording.header.segment,
        robot=robot,
        t=t,
        q=curve(t),
        dq=curve(t, 1),
        ddq=curve(t, 2),
        phases=(),
    )
