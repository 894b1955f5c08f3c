"""Parquet files, and LeRobot data sets made of them."""

import io
import json
from datetime import datetime, timedelta

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from log_samples import column_map, decoded, refused

from ffgym.logs import read_contents, read_log, read_logs
from ffgym.logs.formats.parquet import Parquet

T = 0.02 * np.arange(6)
Q = np.column_stack([np.sin(T), np.cos(T)])

LEROBOT = """
[motions]
split = "episode_index"
[columns.timestamp]
source = "timestamp"
unit = "s"
[columns."motor.position"]
source = "observation.state.{joint}"
unit = "rad"
[columns."reference.position"]
source = "action"
unit = "rad"
"""


def stored(**columns):
    file = io.BytesIO()
    pq.write_table(pa.table(columns), file)
    return file.getvalue()


def lists(values):
    return pa.FixedSizeListArray.from_arrays(pa.array(values.reshape(-1)), values.shape[1])


def test_columns_lists_and_structures_are_read_to_the_bit():
    start = datetime(2026, 1, 1)
    contents = decoded(
        Parquet(),
        stored(
            t=T,
            q=lists(Q),
            also=pa.array(Q.tolist()),
            cube=pa.array(np.arange(24.0).reshape(6, 2, 2).tolist()),
            arm=pa.array([{"x": i, "deep": {"y": 0.5 * i}} for i in range(6)]),
            n=pa.array([1, None, 3, 4, 5, 6]),
            when=pa.array([start + timedelta(microseconds=1500 * i) for i in range(6)]),
            state=pa.array(["a", "b"] * 3).dictionary_encode(),
            ragged=pa.array([[1.0] * i for i in range(6)]),
            raw=pa.array([b"x"] * 6),
        ),
    )
    expected = {"t": T, "q": Q, "also": Q, "cube": np.arange(24.0).reshape(6, 2, 2), "arm.x": range(6)}
    expected |= {"arm.deep.y": 0.5 * np.arange(6), "n": [1, np.nan, 3, 4, 5, 6]}
    for name, values in expected.items():
        np.testing.assert_array_equal(contents.numbers(name), values)
    assert np.diff(contents["when"]).tolist() == [1_500_000] * 5
    assert contents["when"].dtype == np.int64
    assert contents["state"].tolist() == ["a", "b"] * 3
    assert set(contents.skipped) == {"ragged", "raw"}
    with refused("'ragged' cannot be read: a Parquet column of type list<element: double>, or of lists of different"):
        contents["ragged"]


@pytest.mark.parametrize("data", [b"PAR1", stored(t=T)[:-20], b"PAR1" + bytes(200) + b"PAR1"])
def test_a_damaged_file_is_one_error(data):
    with refused("Not a Parquet file, or damaged, cut short or protected by a password"):
        decoded(Parquet(), data)


@pytest.fixture
def data_set(tmp_path):
    """A LeRobot folder with two episodes in one file and a third in another."""
    folder = tmp_path / "robot_set"
    (folder / "meta").mkdir(parents=True)
    names = {"motors": ["upper", "lower"]}
    info = {"codebase_version": "v3.0", "fps": 50, "features": {"observation.state": {"shape": [2], "names": names}}}
    (folder / "meta" / "info.json").write_text(json.dumps(info), encoding="utf-8")
    (folder / "data" / "chunk-000").mkdir(parents=True)
    for number, episodes in enumerate([(0, 1), (2,)]):
        parts = [
            {
                "observation.state": lists((episode + Q).astype(np.float32)),
                "action": pa.array((episode + Q).tolist()),
                "timestamp": T,
                "episode_index": np.full(6, episode),
            }
            for episode in episodes
        ]
        table = pa.concat_tables([pa.table(part) for part in parts])
        pq.write_table(table, folder / "data" / "chunk-000" / f"file-{number:03d}.parquet")
    return folder


def test_every_episode_of_a_lerobot_set_is_a_recording(data_set):
    recordings = read_logs(data_set, column_map(LEROBOT))
    assert [r.header.segment for r in recordings] == ["robot_set_0", "robot_set_1", "robot_set_2"]
    for episode, recording in enumerate(recordings):
        np.testing.assert_array_equal(recording.t, T)
        expected = (episode + Q).astype(np.float32).astype(np.float64)
        np.testing.assert_array_equal(recording.joint_array("motor.position"), expected)
        np.testing.assert_array_equal(recording.joint_array("reference.position"), episode + Q)
    assert read_contents(data_set)["fps"] == 50
    with refused("robot_set: holds 3 motions (robot_set_0, robot_set_1, robot_set_2, ...); read_logs reads them all"):
        read_log(data_set, column_map(LEROBOT))


def test_a_lerobot_set_that_is_not_whole_is_one_error(data_set):
    file = data_set / "data" / "chunk-000" / "file-001.parquet"
    file.write_bytes(file.read_bytes()[:-9])
    with refused("robot_set: Not a Parquet file (data/chunk-000/file-001.parquet), or damaged"):
        read_contents(data_set)
    file.write_bytes(stored(other=T))
    with refused("robot_set: Not a LeRobot data set of files with the same columns"):
        read_contents(data_set)
    for file in data_set.glob("data/*/*"):
        file.unlink()
    with refused("There are no data/chunk-*/*.parquet files"):
        read_contents(data_set)
    (data_set / "meta" / "info.json").write_text("[", encoding="utf-8")
    with refused("meta/info.json is not valid JSON"):
        read_contents(data_set)
    (data_set / "meta" / "info.json").unlink()
    with refused("robot_set: the folder has no metadata.yaml or meta/info.json"):
        read_contents(data_set)
