"""A folder of recordings, with or without an index."""

import json

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.recordings import Header, Recording, read_folder, write_recording


def recording(segment):
    header = Header(robot="axis", joints=("j1",), gear_ratio=(100.0,), segment=segment)
    return Recording({"timestamp": np.arange(3.0), "motor.position.j1": np.arange(3.0)}, header)


@pytest.fixture
def folder(tmp_path):
    for name in ("b.npz", "a.csv", "c.npz"):
        write_recording(recording(name), tmp_path / name)
    (tmp_path / "notes.txt").write_text("of the day")
    return tmp_path


def index(folder, *files):
    (folder / "protocol.json").write_text(json.dumps({"motions": [{"file": name} for name in files]}))


def test_without_an_index_all_recordings_are_read_by_name(folder):
    assert [found.header.segment for found in read_folder(folder)] == ["a.csv", "b.npz", "c.npz"]


def test_an_index_says_which_belong_together_and_in_which_order(folder):
    index(folder, "c.npz", "a.csv")
    assert [found.header.segment for found in read_folder(folder)] == ["c.npz", "a.csv"]


def test_a_session_that_is_not_complete_is_refused_and_what_is_missing_named(folder):
    index(folder, "c.npz", "d.npz", "e.npz")
    with pytest.raises(
        FFGymError, match=r"2 of 3 recordings are missing, first d.npz. Run the same ffgym record again"
    ):
        read_folder(folder)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "protocol.json is not valid JSON"),
        ("[" * 100000, "protocol.json is not valid JSON"),
        ("[]", "protocol.json must be a JSON object"),
        ("{}", "protocol.json must list motions"),
        ('{"motions": []}', "protocol.json must list motions"),
        ('{"motions": 3}', "protocol.json must list motions"),
        ('{"motions": ["a.csv"]}', "protocol.json must list motions"),
        ('{"motions": [{"file": "../a.csv"}]}', "name of a file beside it"),
        ('{"motions": [{"file": 3}]}', "name of a file beside it"),
    ],
)
def test_a_damaged_index_is_one_error_that_says_what_to_do(folder, text, message):
    (folder / "protocol.json").write_text(text)
    with pytest.raises(FFGymError, match=message) as caught:
        read_folder(folder)
    assert "Remove it" in str(caught.value)


def test_an_index_that_is_no_text_is_named_once(folder):
    (folder / "protocol.json").write_bytes(b"\xff")
    with pytest.raises(FFGymError, match=r"protocol\.json: is not UTF-8 text") as caught:
        read_folder(folder)
    assert str(caught.value).count("protocol.json") == 1


def test_a_folder_that_is_none_or_holds_nothing_is_refused(tmp_path):
    with pytest.raises(FFGymError, match="nowhere: no such folder"):
        read_folder(tmp_path / "nowhere")
    with pytest.raises(FFGymError, match=r"holds no recordings \(.csv, .npz\)"):
        read_folder(tmp_path)


def test_a_damaged_recording_is_named_with_its_path(folder):
    (folder / "b.npz").write_bytes(b"PK")
    with pytest.raises(FFGymError, match=r"b\.npz: "):
        read_folder(folder)
