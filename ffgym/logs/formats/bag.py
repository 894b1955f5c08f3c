"""MCAP files and rosbags (ROS 2 and 1): fields of messages by topic, joints by name, two clocks per topic."""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffgym.core.files import check_ordinary, read_bytes
from ffgym.logs.contents import Contents
from ffgym.logs.log_format import LogFormat
from ffgym.logs.text_layout import TextLayout

LOG_TIME = "log_time"
"""Clock of the recorder: when a message arrived [ns since 1970]."""

STAMP = "header.stamp"
"""Clock of the sender, in messages with a header [ns since 1970]."""

NANOSECONDS = 10**9
"""Per second: a stamp is whole seconds and nanoseconds."""

_TIMES = frozenset({"builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration"})

_NAMING = ("name", "joint_names")
"""Fields in which messages list their joints: sensor_msgs/JointState, and those of ros2_control."""


class Bag(LogFormat):
    """Fields of the messages in a bag, e.g. `/joint_states:position.elbow` or `/tracker:pose.position.x`.

    Each topic is a stream with the clocks `/topic:header.stamp`, where its messages have one, and `/topic:log_time`.
    Messages that name their joints are sorted by joint; where several senders name different joints on one topic, each
    is a stream of its own, `/topic#1`, `/topic#2`.
    """

    title = "an MCAP file or rosbag"
    suffixes = (".mcap", ".db3", ".bag")
    folder = "metadata.yaml"
    packages = ("rosbags",)
    extra = "ffgym[logs]"

    def read(self, path: Path, layout: TextLayout) -> Contents:
        """Read the messages of a bag, one array per field of a topic."""
        for file in path.iterdir() if path.is_dir() else [path]:
            check_ordinary(file)
        if (path.is_file() and not path.stat().st_size) or not path.exists():
            read_bytes(path)  # which says what is wrong
        streams, skipped = _messages(path)
        arrays: dict[str, NDArray[Any]] = {}
        owner: dict[str, str] = {}
        clocks: dict[str, dict[str, str]] = {}
        for stream, rows in streams.items():
            for field in dict.fromkeys(field for row in rows for field in row):
                name = f"{stream}:{field}"
                values = [row[field] for row in rows if field in row]
                if len(values) < len(rows) or len({np.shape(value) for value in values}) > 1:
                    skipped[name] = "a field that is absent, or of another length, in some messages"
                else:
                    arrays[name], owner[name] = np.array(values), stream
            kinds = (STAMP, LOG_TIME)
            clocks[stream] = {kind: f"{stream}:{kind}" for kind in kinds if f"{stream}:{kind}" in arrays}
        return Contents(where=str(path), arrays=arrays, streams=owner, clocks=clocks, skipped=skipped)


def _messages(path: Path) -> tuple[dict[str, list[dict[str, Any]]], dict[str, str]]:
    """Flat messages by stream, and topics that cannot be read."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    found: dict[str, dict[frozenset[str], list[dict[str, Any]]]] = defaultdict(lambda: defaultdict(list))
    skipped: dict[str, str] = {}
    with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
        named = [c for c in reader.connections if isinstance(c.topic, str)]
        if len(named) < len(reader.connections):
            skipped["topics without a name"] = "the bag says of some messages no topic"
        known = [c for c in named if c.msgtype in reader.typestore.fielddefs]
        skipped |= {c.topic: f"messages of unknown type {c.msgtype}" for c in named if c not in known}
        for connection, log_time, raw in reader.messages(connections=known) if known else ():
            message = reader.deserialize(raw, connection.msgtype)
            joints = _joint_names(message)
            row: dict[str, Any] = {LOG_TIME: np.int64(log_time)}
            for name, value in _leaves("", message):
                if joints and isinstance(value, np.ndarray) and value.shape == (len(joints),):
                    row |= {f"{name}.{joint}": entry for joint, entry in zip(joints, value, strict=True)}
                else:
                    row[name] = value
            found[connection.topic][frozenset(joints)].append(row)
    streams: dict[str, list[dict[str, Any]]] = {}
    for topic, groups in found.items():
        for i, rows in enumerate(groups.values(), start=1):
            streams[topic if len(groups) == 1 else f"{topic}#{i}"] = rows
    return streams, skipped


def _joint_names(message: Any) -> tuple[str, ...]:
    """Joints that a message names, in its order."""
    for names in (getattr(message, field, None) for field in _NAMING):
        if isinstance(names, list) and names and all(isinstance(name, str) for name in names):
            return tuple(names)
    return ()


def _leaves(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Numbers of a message by path, without text, and arrays of bytes, which are pictures and the like."""
    if getattr(value, "__msgtype__", "") in _TIMES:
        yield path, np.int64(value.sec * NANOSECONDS + value.nanosec)
    elif is_dataclass(value):
        for field in fields(value):
            yield from _leaves(f"{path}.{field.name}" if path else field.name, getattr(value, field.name))
    elif isinstance(value, np.ndarray):
        if value.dtype.kind in "biuf" and value.dtype != np.uint8 and value.size:
            yield path, value
    elif isinstance(value, list):
        for i, entry in enumerate(value):
            yield from _leaves(f"{path}[{i}]", entry)
    elif isinstance(value, bool | int | float):
        yield path, value
