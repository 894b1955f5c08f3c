"""Checks of the header against the description: is this a log of this robot?"""

from collections.abc import Iterator

import numpy as np

from ffgym.logs.quality.check import Check, NotJudgedError, Seen
from ffgym.logs.quality.log import Log
from ffgym.robot import RobotDescription


def _robot(log: Log) -> RobotDescription:
    if log.robot is None:
        raise NotJudgedError("no robot is given")
    return log.robot


def _name(log: Log) -> Iterator[Seen]:
    robot, header = _robot(log), log.recording.header
    other = (robot.name != header.robot) + (robot.joints != header.joints)
    message = (
        f"header: the log is of {header.robot!r} with joints {', '.join(header.joints)}, the description of "
        f"{robot.name!r} with {', '.join(robot.joints)}. Name the right robot."
    )
    yield Seen(value=float(other), message=message)


def _joints(log: Log) -> Iterator[Seen]:
    robot, header = _robot(log), log.recording.header
    wrong = len(header.joints) != robot.n_joints or header.joint_types != robot.kinematics.types
    message = (
        f"header: the log has {len(header.joints)} joints ({', '.join(header.joint_types)}), robot {robot.name!r} has "
        f"{robot.n_joints} ({', '.join(robot.kinematics.types)}). Name the right robot."
    )
    yield Seen(value=float(wrong), message=message)


def _gears(log: Log) -> Iterator[Seen]:
    robot, header = _robot(log), log.recording.header
    if len(header.joints) != robot.n_joints:
        raise NotJudgedError("the number of joints differs")
    for joint, said, described in zip(log.joints, header.gear_ratio, robot.drive.gear_ratio.tolist(), strict=True):
        same_way = said * described > 0
        value = abs(np.log(said / described)) if same_way else np.log(2.0)
        message = (
            f"header gear_ratio of joint {joint} is {said:.6g}, that of {robot.name} {described:.6g}, must be equal "
            "within 0.5 %. Correct the header, or the description."
        )
        yield Seen(value=float(value), message=message, columns=(f"motor.position.{joint}",), joint=joint)


def _payload(log: Log) -> Iterator[Seen]:
    robot, payload = _robot(log), log.recording.header.payload
    if payload is None or robot.tool is None or payload["mass"] == 0 or robot.tool.mass == 0:
        raise NotJudgedError("the header has no payload, or the robot no tool with a mass")
    said, described = float(payload["mass"]), robot.tool.mass
    message = (
        f"header payload is {said:.4g} kg, the tool of {robot.name} {described:.4g} kg, must be equal within 10 %. "
        "Correct one of them."
    )
    yield Seen(value=abs(np.log(said / described)), message=message)


def _semantics(log: Log) -> Iterator[Seen]:
    if not log.recording.has("motor.effort"):
        raise NotJudgedError("there is no motor.effort")
    header = log.recording.header
    message = (
        f"header torque_semantics is {header.torque_semantics!r}, hold {header.hold!r}: what needs torque refuses the "
        "log. Say what the torque is (docs/recordings.md)."
    )
    yield Seen(value=float(header.torque_semantics == "unspecified"), message=message, columns=("motor.effort",))


IDENTITY = (
    Check(
        name="joint_count",
        figure="Joints in another number or of another type",
        unit="1",
        flag=0.5,
        refuse=0.5,
        why="nothing of the description applies to another number of joints",
        judge=_joints,
    ),
    Check(
        name="robot_name",
        figure="Name of the robot, names of its joints that differ",
        unit="1",
        flag=0.5,
        why="names may differ; that they do has to be known",
        judge=_name,
    ),
    Check(
        name="gear_ratio",
        figure="Gear ratio of the header over that of the description, as |ln|",
        unit="1",
        flag=0.005,
        refuse=0.1,
        why="ratios are ratios of teeth and known exactly; half a percent is rounding",
        judge=_gears,
    ),
    Check(
        name="payload",
        figure="Payload of the header over that of the description, as |ln|",
        unit="1",
        flag=0.1,
        why="10 % of the payload are a few percent of the gravity torque",
        judge=_payload,
    ),
    Check(
        name="torque_semantics",
        figure="Torque of unknown meaning",
        unit="1",
        flag=0.5,
        why="it is not guessed",
        judge=_semantics,
    ),
)
"""Checks of the header."""
