"""Recordings in files of which columns are read one at a time, and stretches that are cut out of them."""

import numpy as np
import pytest
from recording_samples import recording, refused

from ffgym.recordings import Phase, write_recording
from ffgym.recordings.io import Stored
from ffgym.recordings.stretch import SETTLING, Span, is_stretch, read_session_start, stretches_of


@pytest.fixture
def long():
    """Ten seconds, as a session of which they are the second minute has them."""
    phases = (Phase(label="go", kind="motion", start=1.0, end=6.0),)
    return recording(2500, segment="go", meta={"session_start": 60.0}, phases=phases)


def test_columns_that_are_read_one_at_a_time_are_those_of_the_recording(long, tmp_path):
    write_recording(long, tmp_path / "go.npz")
    stored = Stored(tmp_path / "go.npz")
    assert stored.header == long.header
    assert set(stored.columns) == set(long.columns)
    assert all(np.array_equal(stored[name], long[name]) for name in long.columns)
    assert stored.whole().equals(long)
    assert stored.rename("other").whole().equals(long.rename("other"))


def test_a_damaged_file_and_a_missing_column_are_refused(long, tmp_path):
    path = tmp_path / "go.npz"
    write_recording(long, path)
    with refused("go.npz: The file has no nothing. Copy"):
        Stored(path)["nothing"]
    path.write_bytes(path.read_bytes()[:3000])
    with refused("go.npz: Damaged, cut short, not NPZ"):
        Stored(path)


def test_a_stretch_has_the_rows_of_its_time_its_place_on_the_clock_and_the_phases_in_it(long, tmp_path):
    write_recording(long, tmp_path / "go.npz")
    spans = [Span(start=2.0, end=4.0), Span(start=5.0, end=7.0)]
    for source in (long, Stored(tmp_path / "go.npz")):
        first, second = stretches_of(source, spans)
        assert first.header.segment == "go 0:00:02"
        assert (first.t[0], second.t[0]) == (2.0, 5.0)
        assert all(np.array_equal(second[name], long.slice(5.0, 7.0)[name]) for name in long.columns)
        assert read_session_start(second.header) == 65.0
        assert second.header.phases[0].end == 6.0
        assert is_stretch(first)
    assert not is_stretch(long)


def test_rows_next_to_a_cut_in_a_motion_do_not_count(long):
    (part,) = stretches_of(long, [Span(start=2.0, end=4.0, at_rest=(False, True))])
    assert np.array_equal(part.valid[:, 0], part.t >= 2.0 + SETTLING)
    (part,) = stretches_of(long, [Span(start=2.0, end=4.0, at_rest=(True, False))])
    assert np.array_equal(part.valid[:, 1], part.t <= part.t[-1] - SETTLING)
