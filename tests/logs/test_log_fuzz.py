"""Damaged files of every format are a recording's arrays or one clear error, never a crash or another exception."""

import io

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from ffgym.core.errors import FFGymError
from ffgym.logs import read_contents

N_FILES = 40
"""Damaged files of each format; some thousands were tried when the readers were written."""

T = 0.004 * np.arange(40)
Q = np.random.default_rng(0).normal(size=(40, 3))


def npz(folder):
    np.savez(folder / "good.npz", t=T, q=Q)


def csv(folder):
    rows = np.column_stack([T, Q]).tolist()
    text = "\n".join(["t;a;b;c", *(";".join(map(repr, row)) for row in rows), ""])
    (folder / "good.csv").write_text(text, encoding="utf-8")


def mat(folder):
    variables = {"t": T, "q": Q, "log": {"q": Q, "c": np.array([1, "x"], dtype=object)}}
    scipy.io.savemat(folder / "good.mat", variables, do_compression=False)  # where no checksum helps


def mat73(folder):
    file = io.BytesIO()
    with h5py.File(file, "w", userblock_size=512) as group:
        group["t"], group["log/q"], group["#refs#/a"] = T, Q, T
        references = group.create_dataset("c", (1, 1), dtype=h5py.ref_dtype)
        references[0, 0] = group["#refs#/a"].ref
        references.attrs["MATLAB_class"] = np.bytes_(b"cell")
    (folder / "good.mat").write_bytes(file.getvalue())


def hdf5(folder):
    with h5py.File(folder / "good.h5", "w") as group:
        group["t"], group["arm/text"] = T, "of any length"
        group.create_dataset("q", data=Q, compression="gzip")


def parquet(folder):
    table = pa.table({"t": T, "q": Q.tolist(), "arm": [{"x": 1.0}] * 40, "state": ["a"] * 40})
    pq.write_table(table, folder / "good.parquet")


def bag(folder, plugin):
    store = get_typestore(Stores.ROS2_HUMBLE)
    stamp = store.types["builtin_interfaces/msg/Time"](sec=1, nanosec=2)
    header = store.types["std_msgs/msg/Header"](stamp=stamp, frame_id="")
    state = store.types["sensor_msgs/msg/JointState"]
    with Writer(folder / "bag", version=9, storage_plugin=plugin) as writer:
        topic = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
        for i, q in enumerate(Q[:8]):
            sent = state(header=header, name=["a", "b", "c"], position=q, velocity=q, effort=q)
            writer.write(topic, i, store.serialize_cdr(sent, state.__msgtype__))


def mcap(folder):
    bag(folder, StoragePlugin.MCAP)


def db3(folder):
    bag(folder, StoragePlugin.SQLITE3)


def damaged(good, rng):
    """Cut short, with bytes changed, with a piece missing, or with a piece of noise."""
    data = np.frombuffer(good, dtype=np.uint8).copy()
    first, end = sorted(rng.integers(0, len(data), size=2).tolist())
    kind = rng.integers(4)
    if kind == 0:
        return data[:first].tobytes() or b"\0"
    if kind == 1:
        places = rng.integers(0, len(data), size=rng.integers(1, 20))
        data[places] = rng.integers(0, 256, size=len(places))
    elif kind == 2:
        data = np.delete(data, slice(first, end))
    else:
        end = min(end, first + 64)
        data[first:end] = rng.integers(0, 256, size=end - first)
    return data.tobytes() or b"\0"


@pytest.mark.parametrize("write", [npz, csv, mat, mat73, hdf5, parquet, mcap, db3], ids=lambda write: write.__name__)
def test_a_damaged_file_is_read_or_refused_in_one_line(write, tmp_path):
    write(tmp_path)
    (good,) = [file for file in tmp_path.rglob("*") if file.suffix not in ("", ".yaml")]
    assert len(list(read_contents(good))) > 1
    bad = tmp_path / f"bad{good.suffix}"
    rng = np.random.default_rng(7)
    refusals = []
    for _ in range(N_FILES):
        bad.write_bytes(damaged(good.read_bytes(), rng))
        try:
            read_contents(bad)
        except FFGymError as error:
            refusals.append(str(error))
    assert len(refusals) > N_FILES / 4
    assert all(text.startswith(f"{bad}: ") and len(text.splitlines()) == 1 for text in refusals)


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".mat", ".h5", ".parquet", ".mcap", ".db3"])
@pytest.mark.parametrize("data", [b"\0", b"\n", b"PK\x03\x04", b"MATLAB 5.0", bytes(1000), b"\xff" * 1000])
def test_what_is_no_file_of_its_kind_is_refused(suffix, data, tmp_path):
    path = tmp_path / f"log{suffix}"
    path.write_bytes(data)
    with pytest.raises(FFGymError, match=r"log\.") as error:
        read_contents(path)
    assert len(str(error.value).splitlines()) == 1


def test_pickled_and_protected_files_are_refused(tmp_path):
    np.savez(tmp_path / "pickled.npz", allow_pickle=True, x=np.array([{"run": 1}], dtype=object))
    with pytest.raises(FFGymError, match="a password or Python objects in it"):
        read_contents(tmp_path / "pickled.npz")
    np.savez(tmp_path / "protected.npz", x=T)
    data = bytearray((tmp_path / "protected.npz").read_bytes())
    for magic, flags in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):  # the mark of encryption in both headers
        data[data.find(magic) + flags] |= 1
    (tmp_path / "protected.npz").write_bytes(bytes(data))
    with pytest.raises(FFGymError, match=r"protected\.npz: .*a password or Python objects in it \(RuntimeError\)"):
        read_contents(tmp_path / "protected.npz")


def test_unknown_and_missing_files_are_refused(tmp_path):
    with pytest.raises(FFGymError, match=r"suffix '.xlsx' is unknown, must be one of .csv"):
        read_contents(tmp_path / "log.xlsx")
    with pytest.raises(FFGymError, match=r"log.mat: no such file"):
        read_contents(tmp_path / "log.mat")
    with pytest.raises(FFGymError, match="neither a rosbag nor a LeRobot data set"):
        read_contents(tmp_path)
