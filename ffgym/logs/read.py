"""Logs: recordings, and files of other tools with a column map."""

import hashlib
import os
from dataclasses import replace
from pathlib import Path

from ffgym.core.errors import FFGymError, errors_at
from ffgym.core.files import check_there
from ffgym.logs.column_map import ColumnMap, load_columns
from ffgym.logs.convert import recordings_of
from ffgym.logs.drive_units import with_drive_units
from ffgym.logs.log_format import bare_name, read_contents
from ffgym.recordings import Header, Recording, read_recording
from ffgym.robot import RobotDescription, load_draft, log_header


def read_log(
    path: str | os.PathLike[str],
    columns: ColumnMap | str | Path | None = None,
    *,
    robot: RobotDescription | str | None = None,
    header: Header | None = None,
) -> Recording:
    """Read the one motion in a file: a recording, or with `columns` a file of another tool.

    Args:
        path: CSV or other text, NPZ, MAT, HDF5, Parquet, MCAP or rosbag file, or a folder of a rosbag or LeRobot set.
        columns: what the file holds: a built-in name, a TOML file (docs/column_maps.md), or a map; None for recordings.
        robot: whose log it is, where the column map leaves this open.
        header: for a recording without header, as `read_recording`.

    Raises:
        FFGymError: if the file cannot be read, does not fit the map, or holds several motions.
    """
    recordings = read_logs(path, columns, robot=robot, header=header)
    if len(recordings) > 1:
        names = ", ".join(recording.header.segment for recording in recordings[:5])
        raise FFGymError(
            f"{os.fspath(path)}: holds {len(recordings)} motions ({names}, ...); read_logs reads them all."
        )
    return recordings[0]


def read_logs(
    path: str | os.PathLike[str],
    columns: ColumnMap | str | Path | None = None,
    *,
    robot: RobotDescription | str | None = None,
    header: Header | None = None,
) -> list[Recording]:
    """Read all motions in a file; arguments as for `read_log`.

    Raises:
        FFGymError: if the file cannot be read, or does not fit the map.
    """
    check_there(path)
    if columns is None:
        if robot is not None:
            raise FFGymError("robot belongs to a column map; a recording says itself whose it is.")
        return [read_recording(path, header)]
    if header is not None:
        raise FFGymError("header belongs to a recording without one; with a column map, [log] says what it says.")
    columns = load_columns(columns)
    if columns.is_for_recordings:
        return [correct_offsets(read_recording(path), columns)]
    described = _robot_of(columns, robot)
    with errors_at(columns.where):
        columns, made = with_drive_units(columns, header_of(columns, described), described)
    contents = read_contents(path, columns.layout)
    provenance = {"file": Path(path).name, "sha256": _digest(Path(path)), "columns": Path(columns.where).name}
    made = replace(made, segment=made.segment or bare_name(path), provenance=provenance)
    with errors_at(f"{os.fspath(path)} with {columns.where}"):
        return [columns.rewiring.apply(recording) for recording in recordings_of(contents, columns, made)]


def correct_offsets(recording: Recording, columns: ColumnMap) -> Recording:
    """A recording with the corrections of a map, which its provenance names."""
    provenance = recording.header.provenance | {"columns": Path(columns.where).name}
    made = columns.rewiring.apply(recording)
    return made.derive(made.columns, replace(made.header, provenance=provenance))


def _digest(path: Path) -> str:
    """SHA-256 of a file, or of all files in a folder in the order of their names."""
    files = sorted(file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [path]
    total = hashlib.sha256()
    for file in files:
        with file.open("rb") as stream:
            while block := stream.read(1 << 20):
                total.update(block)
    return total.hexdigest()


def _robot_of(columns: ColumnMap, robot: RobotDescription | str | None) -> RobotDescription | None:
    """Robot whose logs a column map reads; None if the map has its joints, and its robot is just a name."""

    def describe(name: str | Path) -> RobotDescription:  # it may lack what a log does not need
        return load_draft(name).description_for("kinematics", "drive.gear_ratio")

    if "joints" in columns.header:
        found, mapped = None, columns.robot
        given = robot.name if isinstance(robot, RobotDescription) else robot
    else:
        own = columns.folder / columns.robot if columns.robot.endswith(".toml") else columns.robot
        of_map = describe(own) if columns.robot else None
        of_caller = describe(robot) if isinstance(robot, str) else robot
        found = of_map if of_caller is None else of_caller
        if found is None:
            raise FFGymError(
                f"{columns.where} names no robot: pass robot=, on the command line --robot, or set robot in its [log]."
            )
        mapped = found.name if of_map is None else of_map.name
        given = found.name
    if given is not None and given != mapped:
        raise FFGymError(
            f"{columns.where} is for robot {mapped!r}, not for {given!r}. Take the map of that robot, or leave the "
            "robot out of the map if the layout is the same."
        )
    return found


def header_of(columns: ColumnMap, robot: RobotDescription | None) -> Header:
    """Header for the recordings of a column map; its segment is the map's, or empty."""
    fields = dict(columns.header)
    if fields.get("payload") == "unknown":
        fields["payload"] = None
    with errors_at(columns.where):
        if robot is not None:
            return replace(log_header(robot), **fields)
        if "gear_ratio" not in fields:
            raise FFGymError("[log] has joints but no gear_ratio; give one per joint, 1 for a direct drive.")
        return Header(robot=columns.robot, **fields)
