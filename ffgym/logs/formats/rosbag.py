"""MCAP files and rosbags (ROS 2 and 1): fields of messages by topic, joints by name, two clocks per topic."""

from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from ffgym.logs.contents import Contents
from ffgym.logs.formats.damage import one_error
from ffgym.logs.formats.message import flat, joint_names

LOG_TIME = "log_time"
"""Clock of the recorder: when a message arrived [ns since 1970]."""

STAMP = "header.stamp"
"""Clock of the sender, in messages with a header [ns since 1970]."""


def read_bag(path: Path) -> Contents:
    """Fields of the messages in a bag, e.g. `/joint_states:position.elbow` or `/tracker:pose.position.x`.

    Each topic is a stream with the clocks `/topic:header.stamp`, where its messages have one, and `/topic:log_time`.
    Messages that name their joints are sorted by joint; where several senders name different joints on one topic, each
    is a stream of its own, `/topic#1`, `/topic#2`.

    Raises:
        FFGymError: if the bag is damaged.
    """
    with one_error("an MCAP file or rosbag"):
        streams, skipped = _messages(path)
    arrays: dict[str, NDArray[Any]] = {}
    owner: dict[str, str] = {}
    clocks: dict[str, dict[str, str]] = {}
    for stream, rows in streams.items():
        for field in dict.fromkeys(field for row in rows for field in row):
            name = f"{stream}:{field}"
            array = _column([row.get(field) for row in rows])
            if array is None:
                skipped[name] = "a field that is absent, or of another length, in some messages"
            else:
                arrays[name], owner[name] = array, stream
        kinds = (STAMP, LOG_TIME)
        clocks[stream] = {kind: f"{stream}:{kind}" for kind in kinds if f"{stream}:{kind}" in arrays}
    return Contents(where=str(path), arrays=arrays, streams=owner, clocks=clocks, skipped=skipped)


def _messages(path: Path) -> tuple[dict[str, list[dict[str, Any]]], dict[str, str]]:
    """Flat messages by stream, and topics that cannot be read."""
    found: dict[str, dict[frozenset[str], list[dict[str, Any]]]] = defaultdict(lambda: defaultdict(list))
    skipped: dict[str, str] = {}
    with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
        known = [c for c in reader.connections if c.msgtype in reader.typestore.fielddefs]
        skipped |= {c.topic: f"messages of unknown type {c.msgtype}" for c in reader.connections if c not in known}
        for connection, log_time, raw in reader.messages(connections=known) if known else ():
            message = reader.deserialize(raw, connection.msgtype)
            joints = joint_names(message)
            row = {LOG_TIME: np.int64(log_time), **flat(message, joints)}
            found[connection.topic][frozenset(joints or ())].append(row)
    streams: dict[str, list[dict[str, Any]]] = {}
    for topic, groups in found.items():
        for i, rows in enumerate(groups.values(), start=1):
            streams[topic if len(groups) == 1 else f"{topic}#{i}"] = rows
    return streams, skipped


def _column(values: list[Any]) -> NDArray[Any] | None:
    """One field of all messages, shape (T,) or (T, K); None if some lack it or differ in length."""
    if any(value is None for value in values) or len({np.shape(value) for value in values}) > 1:
        return None
    return np.array(values)
