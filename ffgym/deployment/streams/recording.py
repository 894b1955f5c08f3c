"""Log of a session as a recording: set-points as they were sent, and positions that the controller measured."""

from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.version import __version__
from ffgym.deployment.streams.session import StreamSession
from ffgym.recordings import Header, Recording
from ffgym.robot import RobotDescription


def record_session(session: StreamSession, robot: RobotDescription) -> Recording:
    """Make the recording of a session: one row for each valid packet of the controller.

    `reference.position` is the set-point that answered the packet, `motor.position` what the packet says was measured,
    and `correction.position` the correction that was in the set-point, all on the motor side; times are those of the
    controller's clock since the first set-point.

    Raises:
        FFGymError: if the session sent nothing.
    """
    log = session.log
    if len(log.time) < 2:
        raise FFGymError(f"The session is {session.state} and sent {session.sent} set-points; there is no log of it.")
    drive, joints = robot.drive, robot.joints
    families = {
        "reference.position": drive.motor_angle(np.stack(log.sent)),
        "motor.position": drive.motor_angle(np.stack(log.measured)),
        "correction.position": drive.motor_angle(np.stack(log.correction)),
    }
    columns = {"timestamp": np.array(log.time)}
    columns |= {f"{name}.{joint}": x[:, j] for name, x in families.items() for j, joint in enumerate(joints)}
    meta = {"law": session.plan.law, "plan": dict(session.plan.meta), "stream": summarise(session)}
    return Recording(columns=columns, header=header_of(robot, session.plan.name, meta=meta))


def summarise(session: StreamSession) -> dict[str, Any]:
    """Summarise a session: how it ended, packets and what was refused, the largest correction; JSON values."""
    corrections = session.log.correction
    largest = np.abs(corrections).max(axis=0).tolist() if corrections else []
    return {
        "state": session.state,
        "received": session.received,
        "refused": dict(sorted(session.refused.items())),
        "sent": session.sent,
        "correction_lost_after": session.lost_after,
        "largest_correction": largest,
        "beyond_limits": session.cut_share,
    }


def header_of(
    robot: RobotDescription,
    segment: str,
    *,
    provenance: dict[str, Any] | None = None,
    meta: dict[str, Any] | None = None,
) -> Header:
    """Make the header of a recording of positions of a robot, motor side."""
    return Header(
        robot=robot.name,
        joints=robot.joints,
        gear_ratio=tuple(robot.drive.gear_ratio.tolist()),
        coupling=None if robot.drive.coupling is None else robot.drive.coupling.tolist(),
        joint_types=robot.kinematics.types,
        position_side="motor",
        segment=segment,
        provenance={"ffgym": __version__, **(provenance or {})},
        meta=meta or {},
    )
