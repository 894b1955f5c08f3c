"""Damaged files never crash, and never pass for the original: refused, flagged, or equal up to what noise could be."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from ffgym.core.errors import FFGymError
from ffgym.logs.quality import check_quality
from ffgym.logs.quality.cells import usual_steps
from ffgym.logs.quality.signals import smallest_step
from ffgym.recordings import Recording
from ffgym.recordings import csv as csv_format
from ffgym.recordings import npz as npz_format
from tests.logs.quality.quality_logs import clean_log, described

ROBOT, MOTION = "two_link", "circles"
FREE = ("segment", "provenance", "meta", "filters", "phases", "payload")
"""Fields of a header that nothing in the columns speaks of; a name of a phase, a note."""

START = 2
"""First rows, in which a servo may step; what is changed there passes."""

NOISE = 7.0
"""Changes of fewer of the largest steps around (0.1 % of the range at least) may be noise (docs/quality.md)."""

HOW = {
    "suppress_health_check": [HealthCheck.too_slow],
    "phases": (Phase.explicit, Phase.reuse, Phase.generate),  # files are too long to shrink
    "derandomize": True,
}
FEW, MANY = settings(max_examples=20, **HOW), settings(max_examples=400, **HOW)


def test_a_number_beyond_all_others_does_not_hide_behind_its_own_size():
    recording = clean_log("two_link", "multisine")
    name = "feedback.integral.shoulder"
    values = recording[name].copy()
    values[500] = 1e9
    report = check_quality(recording.with_columns({name: values}))
    assert [(finding.check, finding.columns) for finding in report.problems] == [("spike", (name,))]


@pytest.fixture(scope="module")
def original() -> Recording:
    recording = clean_log(ROBOT, MOTION)
    assert check_quality(recording, described(ROBOT, MOTION)).verdict == "good"
    return recording


def silent(recording: Recording) -> bool:
    return check_quality(recording, described(ROBOT, MOTION)).verdict == "good"


def within_noise(original: Recording, other: Recording) -> bool:
    """Whether no value differs by more than noise could, and nothing of the header that means something."""
    if other.columns.keys() != original.columns.keys() or len(other) != len(original):
        return False
    blank = {name: getattr(original.header, name) for name in FREE}
    if replace(other.header, **blank) != original.header:
        return False
    for name, values in original.columns.items():
        if name in ("timestamp", "tcp.timestamp"):
            limit = np.full(len(values), original.dt)
        else:
            limit = NOISE * usual_steps(values, smallest_step(values))
        off = np.abs(other.columns[name] - values)[START:]
        if np.any(off > limit[START:]) or np.any(np.isnan(other.columns[name]) != np.isnan(values)):
            return False
    return True


def read_or_refuse(decode, data: bytes) -> Recording | None:
    try:
        return decode(bytes(data), None)
    except FFGymError:
        return None


def passes_only_if_it_may(original: Recording, damaged: Recording | None) -> None:
    if damaged is not None and silent(damaged):
        assert within_noise(original, damaged)


bytes_at = st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), min_size=1, max_size=3)
values = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True), st.floats(-10, 10), st.sampled_from([0.0, 1.0, -1.0, 1e9])
)


def change_bytes(data: bytes, changes) -> bytes:
    damaged = bytearray(data)
    for place, value in changes:
        damaged[int(place * len(damaged))] = value
    return bytes(damaged)


def change_cell(original: Recording, name: str, row: int, value: float) -> None:
    columns = {column: x.copy() for column, x in original.columns.items()}
    columns[name][row] = value
    try:
        damaged = Recording(columns, original.header)
    except FFGymError:
        return
    passes_only_if_it_may(original, damaged)


@pytest.fixture(scope="module")
def csv_bytes(original: Recording) -> bytes:
    return csv_format.encode(original)


@pytest.fixture(scope="module")
def npz_bytes(original: Recording) -> bytes:
    return npz_format.encode(original)


@FEW
@given(changes=bytes_at)
def test_bytes_of_a_csv_file(original, csv_bytes, changes):
    passes_only_if_it_may(original, read_or_refuse(csv_format.decode, change_bytes(csv_bytes, changes)))


@FEW
@given(changes=bytes_at)
def test_bytes_of_an_npz_file(original, npz_bytes, changes):
    passes_only_if_it_may(original, read_or_refuse(npz_format.decode, change_bytes(npz_bytes, changes)))


@FEW
@given(place=st.floats(0, 1, exclude_max=True), byte=st.integers(32, 126))
def test_bytes_of_a_header(original, csv_bytes, place, byte):
    end = csv_bytes.index(b"\ntimestamp")
    damaged = change_bytes(csv_bytes[:end], [(place, byte)]) + csv_bytes[end:]
    passes_only_if_it_may(original, read_or_refuse(csv_format.decode, damaged))


@FEW
@given(data=st.data(), value=values)
def test_any_cell(original, data, value):
    name = data.draw(st.sampled_from(sorted(original.columns)))
    change_cell(original, name, data.draw(st.integers(0, len(original) - 1)), value)


@FEW
@given(place=st.floats(0, 1, exclude_max=True))
def test_a_csv_file_that_is_cut_short(original, csv_bytes, place):
    passes_only_if_it_may(original, read_or_refuse(csv_format.decode, csv_bytes[: int(place * len(csv_bytes))]))


@FEW
@given(place=st.floats(0, 1, exclude_max=True))
def test_an_npz_file_that_is_cut_short(npz_bytes, place):
    assert read_or_refuse(npz_format.decode, npz_bytes[: int(place * len(npz_bytes))]) is None


@pytest.mark.slow
@MANY
@given(changes=bytes_at)
def test_bytes_of_many_csv_files(original, csv_bytes, changes):
    passes_only_if_it_may(original, read_or_refuse(csv_format.decode, change_bytes(csv_bytes, changes)))


@pytest.mark.slow
@MANY
@given(data=st.data(), value=values)
def test_many_cells(original, data, value):
    name = data.draw(st.sampled_from(sorted(original.columns)))
    change_cell(original, name, data.draw(st.integers(0, len(original) - 1)), value)


@pytest.mark.slow
@MANY
@given(place=st.floats(0, 1, exclude_max=True), byte=st.integers(32, 126))
def test_bytes_of_many_headers(original, csv_bytes, place, byte):
    end = csv_bytes.index(b"\ntimestamp")
    damaged = change_bytes(csv_bytes[:end], [(place, byte)]) + csv_bytes[end:]
    passes_only_if_it_may(original, read_or_refuse(csv_format.decode, damaged))
