"""Logs of other tools in every format, and the column maps that say what they hold."""

import gzip
import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from ffgym.logs import load_columns, parse_columns, read_contents, read_log, read_logs
from ffgym.logs.column import parse_column
from ffgym.logs.formats.hdf5 import read_mat73
from ffgym.logs.formats.parquet import read_table
from ffgym.logs.log_format import LogFormat
from scripts.fuzz.reader import Make, Reader
from scripts.fuzz.readers.samples import JOINTS, Q, T

_MAP = """
[log]
robot = "press"
joints = ["upper", "lower"]
gear_ratio = [120.0, -80.0]
position_side = "motor"
torque_semantics = "motor_side"

[columns.timestamp]
source = "t"
unit = "s"

[columns."motor.position"]
source = ["a", "b"]
unit = "rad"
"""
_RESAMPLED = (
    _MAP
    + """
[columns."motor.effort"]
source = ["u", "v"]
unit = "N m"
clock = "t2"
clock_unit = "s"
resample = "linear"
sign = [1, -1]

[columns."user.gap"]
source = "g"
unit = "mm"
"""
)
_TEXT = "\n".join(["t;a;b", *(f"{t};{a};{b}" for t, (a, b) in zip(T, Q, strict=True)), ""])
"""A table with semicolons."""


def _csv(folder: Path) -> Path:
    (folder / "log.csv").write_text(_TEXT, encoding="utf-8")
    return folder / "log.csv"


def _packed(folder: Path) -> Path:
    (folder / "log.csv.gz").write_bytes(gzip.compress(_TEXT.encode(), mtime=0))
    return folder / "log.csv.gz"


def _npz(folder: Path) -> Path:
    np.savez(folder / "log.npz", t=T, q=Q, words=np.array(["a", "b"]))
    return folder / "log.npz"


def _time_series(folder: Path) -> Path:
    mapping = json.dumps({"q": ["qpos", [0, 1]], "t": ["time", [0]]})
    np.savez(folder / "log.npz", times=T, data=Q, signal_mapping=np.array(mapping))
    return folder / "log.npz"


def _mat(compressed: bool) -> Make:
    def make(folder: Path) -> Path:
        variables = {"t": T, "q": Q, "log": {"q": Q, "c": np.array([1, "x"], dtype=object)}, "name": "press"}
        scipy.io.savemat(folder / "log.mat", variables, do_compression=compressed)
        return folder / "log.mat"

    return make


def _mat73(folder: Path) -> Path:
    file = io.BytesIO()
    with h5py.File(file, "w", userblock_size=512) as group:
        group["t"], group["log/q"], group["#refs#/a"] = T, Q, T
        references = group.create_dataset("c", (1, 1), dtype=h5py.ref_dtype)
        references[0, 0] = group["#refs#/a"].ref
        references.attrs["MATLAB_class"] = np.bytes_(b"cell")
    head = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM"
    (folder / "log.mat").write_bytes(head + file.getvalue()[len(head) :])
    return folder / "log.mat"


def _hdf5(folder: Path) -> Path:
    with h5py.File(folder / "log.h5", "w") as group:
        group["t"], group["arm/text"] = T, "of any length"
        group.create_dataset("q", data=Q, compression="gzip", chunks=(8, 2))
    return folder / "log.h5"


def _parquet(folder: Path) -> Path:
    table = pa.table({"t": T, "q": Q.tolist(), "arm": [{"x": 1.0}] * len(T), "state": ["a"] * len(T)})
    pq.write_table(table, folder / "log.parquet")
    return folder / "log.parquet"


def _lerobot(folder: Path) -> Path:
    (folder / "meta").mkdir()
    names = {"motors": list(JOINTS)}
    features = {"observation.state": {"dtype": "float32", "shape": [2], "names": names}}
    info = {"fps": 250, "features": features, "data_path": "data/chunk-000/{episode_index}.parquet"}
    (folder / "meta" / "info.json").write_text(json.dumps(info), encoding="utf-8")
    (folder / "data" / "chunk-000").mkdir(parents=True)
    table = pa.table({"timestamp": T, "observation.state": Q.tolist(), "episode_index": [0] * len(T)})
    pq.write_table(table, folder / "data" / "chunk-000" / "0.parquet")
    return folder


def _json_columns(folder: Path) -> Path:
    text = json.dumps({"t": T.tolist(), "arm": {"q": Q.tolist(), "u": None}, "name": "press"})
    (folder / "log.json").write_text(text, encoding="utf-8")
    return folder / "log.json"


def _json_lines(folder: Path) -> Path:
    rows = [json.dumps({"t": t, "q": q}) for t, q in zip(T.tolist(), Q.tolist(), strict=True)]
    (folder / "log.jsonl").write_text("\n".join(rows), encoding="utf-8")
    return folder / "log.jsonl"


def _bag2(plugin: StoragePlugin, suffix: str) -> Make:
    """Make a bag of ROS 2 in one of its two forms, without its folder."""

    def make(folder: Path) -> Path:
        store = get_typestore(Stores.ROS2_HUMBLE)
        state: Any = store.types["sensor_msgs/msg/JointState"]
        with Writer(folder / "bag", version=9, storage_plugin=plugin) as writer:
            topic = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
            for i, message in enumerate(_messages(store)):
                writer.write(topic, i, store.serialize_cdr(message, state.__msgtype__))
        (file,) = (folder / "bag").glob(f"*{suffix}")
        kept = file.rename(folder / f"log{suffix}")
        for rest in (folder / "bag").iterdir():
            rest.unlink()
        (folder / "bag").rmdir()
        return kept

    return make


def _bag1(folder: Path) -> Path:
    store = get_typestore(Stores.ROS1_NOETIC)
    state: Any = store.types["sensor_msgs/msg/JointState"]
    with Writer1(folder / "log.bag") as writer:
        topic = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
        for i, message in enumerate(_messages(store)):
            writer.write(topic, i, store.serialize_ros1(message, state.__msgtype__))
    return folder / "log.bag"


def _messages(store: Any) -> list[Any]:
    """Make messages of joint states, with a stamp."""
    header, time = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    state = store.types["sensor_msgs/msg/JointState"]
    more = {"seq": 0} if "seq" in header.__dataclass_fields__ else {}
    stamp = time(sec=1, nanosec=2)
    return [
        state(header=header(stamp=stamp, frame_id="", **more), name=list(JOINTS), position=q, velocity=q, effort=q)
        for q in Q[:6]
    ]


def _mapped(text: str, **more: Any) -> Make:
    """Make a column map, and a table that it reads."""

    def make(folder: Path) -> Path:
        (folder / "map.toml").write_text(text, encoding="utf-8")
        arrays = {"t": T, "a": Q[:, 0], "b": Q[:, 1], **more}
        rows = [
            ",".join(arrays),
            *(",".join(map(repr, row)) for row in zip(*map(np.ndarray.tolist, arrays.values()), strict=True)),
        ]
        (folder / "log.csv").write_text("\n".join([*rows, ""]), encoding="utf-8")
        return folder / "map.toml"

    return make


def _read_mapped(path: Path) -> None:
    for recording in read_logs(path.with_name("log.csv"), path):
        assert len(recording)


def _log_reader(name: str, *makes: Make, share: int, covers: tuple[Callable[..., Any], ...] = ()) -> Reader:
    return Reader(
        name=f"log_{name}", use=read_contents, makes=makes, covers=(read_contents, LogFormat, *covers), share=share
    )


_CLOCKED = {"u": Q[:, 0], "v": Q[:, 1], "t2": 1.1 * T - 0.001, "g": T}

READERS = (
    _log_reader("text", _csv, share=20),
    _log_reader("text_packed", _packed, share=8),
    _log_reader("npz", _npz, _time_series, share=12),
    _log_reader("matlab", _mat(False), _mat(True), _mat73, share=20, covers=(read_mat73,)),
    _log_reader("hdf5", _hdf5, share=15),
    _log_reader("parquet", _parquet, share=12, covers=(read_table,)),
    _log_reader("lerobot", _lerobot, share=10),
    _log_reader("json", _json_columns, _json_lines, share=12),
    _log_reader("mcap", _bag2(StoragePlugin.MCAP, ".mcap"), share=10),
    _log_reader("db3", _bag2(StoragePlugin.SQLITE3, ".db3"), share=10),
    _log_reader("bag", _bag1, share=8),
    Reader(
        name="column_map",
        use=_read_mapped,
        makes=(_mapped(_MAP), _mapped(_RESAMPLED, **_CLOCKED)),
        covers=(load_columns, parse_columns, parse_column, read_log, read_logs),
        share=30,
    ),
)
