"""A submission's ZIP file is read without trust in what it says of itself."""

import io
import zipfile

import pytest

from ffgym.leaderboard.submission import manifest
from ffgym.leaderboard.submission.manifest import Refused, decode_archive, encode_archive, read_archive

FILES = {"manifest.json": b"{}", "agent.py": b"PREVIEW = 1\n" * 100}


def zipped(*names, content=b"x"):
    """A ZIP file with these names."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as file:
        for name in names:
            entry = zipfile.ZipInfo(name)
            entry.compress_type = zipfile.ZIP_DEFLATED
            file.writestr(entry, content)
    return buffer.getvalue()


def reason(data):
    with pytest.raises(Refused) as caught:
        decode_archive(data)
    assert caught.value.check == "archive"
    return caught.value.reason


def test_files_come_out_as_they_went_in_and_bytes_are_reproducible():
    data = encode_archive(FILES)
    assert decode_archive(data) == FILES
    assert encode_archive(FILES) == data


def test_what_would_unpack_to_too_much_is_refused(monkeypatch):
    monkeypatch.setattr(manifest, "LARGEST", 10_000)
    assert "would unpack to 20000 bytes" in reason(zipped("agent.py", content=bytes(20_000)))


def test_a_file_that_is_too_large_is_not_even_read(monkeypatch, tmp_path):
    (tmp_path / "agent.zip").write_bytes(bytes(2000))
    monkeypatch.setattr(manifest, "LARGEST", 1000)
    monkeypatch.setattr(manifest, "read_bytes", None)
    with pytest.raises(Refused, match="it has 2000 bytes, must be at most 1000"):
        read_archive(tmp_path / "agent.zip")


@pytest.mark.parametrize("told", [100, 5000])
def test_a_size_that_is_told_wrong_is_refused(told):
    data = bytearray(zipped("agent.py", content=bytes(range(256)) * 8))
    place = data.rindex(b"PK\x01\x02") + 24  # uncompressed size in the directory
    data[place : place + 4] = told.to_bytes(4, "little")
    assert reason(bytes(data))


def test_many_files_and_one_name_twice_are_refused():
    assert "holds 9 files" in reason(zipped(*map(str, range(9))))
    with pytest.warns(UserWarning, match="Duplicate name"):
        data = zipped("agent.py", "agent.py")
    assert "agent.py more than once" in reason(data)


@pytest.mark.parametrize("length", [0, 10, 60, -30, -1])
def test_a_file_that_is_cut_short_is_refused(length):
    assert "damaged or cut short" in reason(encode_archive(FILES)[:length])


def test_damaged_content_is_refused():
    data = bytearray(encode_archive(FILES))
    data[data.index(b"agent.py") + 12] ^= 0xFF
    assert "damaged" in reason(bytes(data))
