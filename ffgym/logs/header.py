"""The header of a recording that a column map and a robot make."""

from dataclasses import replace

from ffgym.core.errors import FFGymError
from ffgym.logs.column_map import ColumnMap
from ffgym.recordings import Header
from ffgym.robot import RobotDescription, load_draft, log_header


def robot_of(columns: ColumnMap, robot: RobotDescription | str | None = None) -> RobotDescription | None:
    """Robot whose logs a column map reads; None if the map has its joints, and its robot is just a name.

    Args:
        columns: the map.
        robot: whose log it is, for a map that leaves this open; otherwise it must be the map's robot.

    Raises:
        FFGymError: if no robot is named, or the map is for another one.
    """
    own = "joints" in columns.header
    if own:
        _check_same(columns, columns.robot, robot.name if isinstance(robot, RobotDescription) else robot)
        return None
    if isinstance(robot, RobotDescription):
        description = robot
    elif robot or columns.robot:
        description = _described(columns, robot or columns.robot, given=robot is not None)
    else:
        raise FFGymError(
            f"{columns.where} names no robot: pass robot=, on the command line --robot, or set robot in its [log]."
        )
    if columns.robot and robot is not None:
        _check_same(columns, _described(columns, columns.robot, given=False).name, description.name)
    return description


def _described(columns: ColumnMap, robot: str, *, given: bool) -> RobotDescription:
    """Description by name, or path from the folder of the map; it may lack what a log does not need."""
    path = robot if given or not robot.endswith(".toml") else columns.folder / robot
    return load_draft(path).description_for("kinematics", "drive.gear_ratio")


def _check_same(columns: ColumnMap, mapped: str, given: str | None) -> None:
    if given is not None and given != mapped:
        raise FFGymError(
            f"{columns.where} is for robot {mapped!r}, not for {given!r}. Take the map of that robot, or leave the "
            "robot out of the map if the layout is the same."
        )


def header_of(columns: ColumnMap, robot: RobotDescription | None) -> Header:
    """Header for the recordings of a column map; its segment is the map's, or empty.

    Args:
        columns: the map.
        robot: what `robot_of` makes of it.

    Raises:
        FFGymError: if a field is invalid.
    """
    fields = dict(columns.header)
    if fields.get("payload") == "unknown":
        fields["payload"] = None
    try:
        if robot is not None:
            return replace(log_header(robot), **fields)
        if "gear_ratio" not in fields:
            raise FFGymError("[log] has joints but no gear_ratio; give one per joint, 1 for a direct drive.")
        return Header(robot=columns.robot, **fields)
    except FFGymError as error:
        raise FFGymError(f"{columns.where}: {error}") from error
