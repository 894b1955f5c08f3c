"""Checks of the header against the description, and of sizes: ranges, speeds, temperatures, rests and ends."""

from collections.abc import Iterator

import numpy as np

from ffgym.core.measures import rms
from ffgym.logs.quality.check import Seen, check
from ffgym.logs.quality.log import CheckedLog, NotJudgedError
from ffgym.recordings import FAMILIES
from ffgym.recordings.stretch import is_stretch
from ffgym.robot import RobotDescription

_TURNS = 12.0
"""Angle [rad] that no joint with stops reaches; wrists of six-axis robots turn to 7."""

_COLDEST, _HOTTEST = -40.0, 160.0
"""Temperatures [degC] of motors and gearboxes; 160 is where windings burn."""

_REACH = 20.0
"""Distance [m] that no slide moves by."""


def _robot(log: CheckedLog) -> RobotDescription:
    if log.robot is None:
        raise NotJudgedError("no robot is given")
    return log.robot


@check
def _robot_name(log: CheckedLog) -> Iterator[Seen]:
    robot, header = _robot(log), log.recording.header
    other = (robot.name != header.robot) + (robot.joints != header.joints)
    yield Seen(float(other), words={"said": ", ".join(header.joints), "described": ", ".join(robot.joints)})


@check
def _joint_count(log: CheckedLog) -> Iterator[Seen]:
    robot, header = _robot(log), log.recording.header
    wrong = len(header.joints) != robot.n_joints or header.joint_types != robot.kinematics.types
    said, described = ", ".join(header.joint_types), ", ".join(robot.kinematics.types)
    yield Seen(float(wrong), words={"n_said": len(header.joints), "said": said, "described": described})


@check
def _gear_ratio(log: CheckedLog) -> Iterator[Seen]:
    robot, header = _robot(log), log.recording.header
    if len(header.joints) != robot.n_joints:
        raise NotJudgedError("the number of joints differs")
    for joint, said, described in zip(log.joints, header.gear_ratio, robot.drive.gear_ratio.tolist(), strict=True):
        value = abs(np.log(said / described)) if said * described > 0 else np.log(2.0)
        yield Seen(float(value), (f"motor.position.{joint}",), joint, {"said": said, "described": described})


@check
def _payload(log: CheckedLog) -> Iterator[Seen]:
    robot, load = _robot(log), log.recording.header.payload
    if load is None or robot.tool is None or load["mass"] == 0 or robot.tool.mass == 0:
        raise NotJudgedError("the header has no payload, or the robot no tool with a mass")
    said, described = float(load["mass"]), robot.tool.mass
    yield Seen(abs(np.log(said / described)), words={"said": said, "described": described})


@check
def _torque_semantics(log: CheckedLog) -> Iterator[Seen]:
    if not log.recording.has("motor.effort"):
        raise NotJudgedError("there is no motor.effort")
    yield Seen(float(log.recording.header.torque_semantics == "unspecified"), ("motor.effort",))


@check
def _joint_range(log: CheckedLog) -> Iterator[Seen]:
    positions = [name for name in log.motion_families if name.endswith("position")]
    if not positions:
        raise NotJudgedError("there are no positions")
    if log.robot is None and len(log.joints) == 1:
        raise NotJudgedError("a single axis may turn without end; the robot would say its range")
    for family in positions:
        q = log.link_side(family)
        for j, joint in enumerate(log.joints):
            if log.robot is not None and log.is_described:
                (low, high), whose = log.robot.kinematics.range[j].tolist(), f"the range of {log.robot.name}"
            elif log.recording.header.joint_types[j] == "hinge":
                low, high, whose = -_TURNS, _TURNS, "what hinges of robots turn by"
            else:
                low, high, whose = -_REACH, _REACH, "what slides of robots move by"
            least, most = float(q[:, j].min()), float(q[:, j].max())
            words = {"least": least, "most": most, "low": low, "high": high, "whose": whose}
            yield Seen(max(most - high, low - least, 0.0) / (high - low), (f"{family}.{joint}",), joint, words)


@check
def _joint_speed(log: CheckedLog) -> Iterator[Seen]:
    if log.robot is None or not log.is_described or not log.has_positions:
        raise NotJudgedError("it needs the robot and positions")
    for j, joint in enumerate(log.joints):
        top, most = float(np.abs(log.dq[:, j]).max()), float(log.robot.kinematics.max_speed[j])
        words = {"top": top, "most": most, "unit": log.robot.kinematics.units[j]}
        yield Seen(top / most, (f"motor.position.{joint}",), joint, words)


@check
def _temperature(log: CheckedLog) -> Iterator[Seen]:
    if not log.recording.has("temperature"):
        raise NotJudgedError("there is no temperature")
    for _, j, name, values in log.joint_columns(("temperature",)):
        seen = values[np.isfinite(values)]
        if seen.size:
            words = {"low": float(seen.min()), "high": float(seen.max()), "coldest": _COLDEST, "hottest": _HOTTEST}
            outside = max(words["high"] - _HOTTEST, _COLDEST - words["low"], 0.0)
            yield Seen(outside, (name,), log.joints[j], words)


@check
def _tool_reach(log: CheckedLog) -> Iterator[Seen]:
    families = [name for name in ("tcp.position", "tcp_reference.position") if log.recording.has(name)]
    if not families:
        raise NotJudgedError("there is no tool position")
    for family in families:
        far = float(np.nanmax(np.abs(log.recording.vector(family)), initial=0.0))
        yield Seen(far, FAMILIES[family].columns(log.joints), words={"family": family})


@check
def _phases(log: CheckedLog) -> Iterator[Seen]:
    if not log.has_positions or not log.recording.header.phases:
        raise NotJudgedError("there are no phases, or no positions")
    top, margin = np.abs(log.dq).max(axis=0), log.rows(0.05)
    for phase in log.recording.header.phases:
        rows = np.flatnonzero((log.t >= phase.start) & (log.t < phase.end))[margin:-margin]
        if len(rows) < 5 or not log.excited.any():
            continue
        speed = rms(log.dq[rows], 0)[log.excited] / top[log.excited]
        rest = phase.kind == "standstill"
        words = {"phase": phase, "does": "move" if rest else "rest", "must": "rest" if rest else "move"}
        yield Seen(float(speed.max()) if rest else float(speed.max() == 0.0), ("timestamp",), words=words)


@check
def _ends_in_motion(log: CheckedLog) -> Iterator[Seen]:
    if not log.excited.any():
        raise NotJudgedError("no joint moves")
    if is_stretch(log.recording):
        raise NotJudgedError("the log is a stretch of a longer one")
    top = np.abs(log.dq).max(axis=0)
    share = np.where(log.excited, np.abs(log.dq[-1]) / np.where(top > 0, top, 1.0), 0.0)
    j = int(np.argmax(share))
    yield Seen(float(share[j]), ("timestamp",), log.joints[j])
