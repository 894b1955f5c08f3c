import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recording_samples import columns, header, read_or_refused, recording, refused

from ffgym.core.errors import FFGymError
from ffgym.recordings.npz import decode, encode

GOOD = encode(recording())


class Trap:
    """Leaves a trace when it is unpickled."""

    def __init__(self, path: str) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (Path(self.path),)


def packed(**arrays: Any) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def zipped(*entries: tuple[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as file:
        for name, data in entries:
            file.writestr(name, data)
    return buffer.getvalue()


def array_bytes(values: Any) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, np.asarray(values))
    return buffer.getvalue()


def test_other_readers_see_named_arrays_and_a_json_text() -> None:
    with np.load(io.BytesIO(GOOD)) as file:
        np.testing.assert_array_equal(file["tcp.position.z"], recording()["tcp.position.z"])
        assert str(file["header"]) == recording().header.to_json()


def test_compressed_file_of_another_tool_is_read_with_a_header() -> None:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **columns())
    assert decode(buffer.getvalue(), header()).equals(recording())
    with refused("This NPZ file has no 'header' entry, so it is not known what its numbers mean. Pass read_recording("):
        decode(buffer.getvalue())


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"no archive", "Damaged, cut short, not NPZ"),
        (GOOD[:-1], "Damaged, cut short, not NPZ"),
        (GOOD[: len(GOOD) // 2], "Damaged, cut short, not NPZ"),
        (array_bytes([1.0, 2.0]), "Damaged, cut short, not NPZ"),
        (packed(header=np.array(1.0), **columns()), "The 'header' entry must be JSON text, got float64"),
        (packed(header=np.array(["{}"]), **columns()), "of shape (1,)"),
        (packed(header=np.array("{"), **columns()), "The header is not valid JSON"),
        (packed(header=np.array('{"schema_version": 3}'), **columns()), "schema_version = 3 is not readable"),
        (packed(header=np.array(header().to_json()), timestamp=np.array(["a", "b"])), "must be real numbers"),
        (packed(header=np.array(header().to_json()), x=np.arange(2)), "Unknown column 'x'"),
        (zipped(("timestamp", b"text")), "The NPZ entry 'timestamp' is not an array"),
    ],
)
def test_damaged_file_is_refused(data: bytes, message: str) -> None:
    with refused(message):
        decode(data)


@pytest.mark.filterwarnings("ignore:Duplicate name:UserWarning")
def test_repeated_entry_is_refused() -> None:
    data = zipped(("timestamp.npy", array_bytes([0.0, 1.0])), ("timestamp.npy", array_bytes([0.0, 2.0])))
    with refused("holds timestamp more than once"):
        decode(data, header())


def test_pickled_object_is_refused_and_not_run(tmp_path: Path) -> None:
    trace = tmp_path / "trace"
    with refused("Damaged, cut short, not NPZ, or with a password or Python objects in it (ValueError)"):
        decode(packed(timestamp=np.array([Trap(str(trace))], dtype=object)), header())
    assert not trace.exists()


@given(st.integers(0, len(GOOD) - 1))
def test_file_cut_anywhere_is_refused(length: int) -> None:
    with pytest.raises(FFGymError):
        decode(GOOD[:length])


@given(st.integers(0, len(GOOD) - 1), st.binary(max_size=4), st.integers(0, 4))
def test_file_with_damaged_bytes_is_read_or_refused(place: int, insert: bytes, drop: int) -> None:
    with read_or_refused():
        read = decode(GOOD[:place] + insert + GOOD[place + drop :])
        np.testing.assert_array_equal(read.t, recording().t)


@given(st.binary())
def test_arbitrary_array_headers_are_refused(damage: bytes) -> None:
    good = array_bytes([0.0, 1.0])
    for place in (0, 6, 10, 40):
        data = good[:place] + damage + good[place + len(damage) :]
        with read_or_refused():
            decode(zipped(("timestamp.npy", data)), header())
