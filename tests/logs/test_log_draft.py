"""What is said about an unknown file, and the column map that is proposed for it."""

import numpy as np
import pytest
from log_samples import refused

from ffgym.logs import Contents, TextLayout, parse_columns
from ffgym.logs.draft import clocks, draft, listing

T = 0.004 * np.arange(5)
ARRAYS = {
    "sample": np.arange(5),
    "q1": -T,
    "q2": np.cos(9 * T),
    "ctrl_time": T,
    "state": np.column_stack([T, T]),
    "mode": np.array(["run"] * 5),
    "x": np.array([1.0, np.nan, 3, 4, 5]),
}


def test_every_array_is_described_on_a_line():
    lines = listing(Contents(where="run.mat", arrays=ARRAYS, skipped={"log": "a MATLAB object"}))
    assert lines[0] == "sample     (5,) int64, 0 to 4, increases by 1"
    assert lines[4] == "state      (5, 2) float64, 0 to 0.016"
    assert lines[5] == "mode       (5,) <U3 'run'"
    assert lines[6] == "x          (5,) float64, 1 to 5, 1 missing"
    assert lines[7] == "log        cannot be read: a MATLAB object"


def test_a_clock_increases_and_those_called_so_come_first():
    assert clocks(Contents(where="x", arrays=ARRAYS)) == ["ctrl_time", "sample"]
    assert clocks(Contents(where="x", arrays={"time": np.zeros(5)})) == []


def test_a_draft_lacks_only_what_is_marked():
    text = draft(Contents(where="run.csv", arrays=ARRAYS), TextLayout(decimal=",", names_row=3))
    with refused("draft: log.robot = '?' is still to be filled in"):
        parse_columns(text, where="draft")
    assert 'source = "ctrl_time"  # or sample' in text
    assert '# one of "state", "q{number}"' in text
    filled = parse_columns(text.replace("?", "x"))
    assert filled.layout == TextLayout(decimal=",", names_row=3)
    assert set(filled.columns) == {"timestamp", "motor.position", "motor.effort", "reference.position"}


def test_a_draft_for_a_bag_knows_the_clock_and_the_joints():
    names = ["/js:header.stamp", "/js:log_time", "/js:position.a", "/js:position.b", "/js:effort.a"]
    arrays = {name: np.arange(5) for name in names}
    contents = Contents(
        where="run.mcap",
        arrays=arrays,
        streams=dict.fromkeys(names, "/js"),
        clocks={"/js": {"header.stamp": names[0], "log_time": names[1]}},
    )
    text = draft(contents)
    assert 'source = "/js:header.stamp"  # or /js:log_time' in text
    assert 'unit = "ns"\nfrom_first = true' in text
    assert '# one of "/js:position.{joint}", "/js:effort.{joint}"' in text


@pytest.mark.parametrize("name", ['a "quoted" \\ name', "line\nend", "tab\t", "Position [°]", "\x7f\u2028"])
def test_a_draft_is_toml_whatever_arrays_are_called(name):
    contents = Contents(where="x", arrays={name: T, f"{name}2": np.column_stack([T, T])})
    filled = parse_columns(draft(contents).replace("?", "x"))
    assert filled.columns["timestamp"].source == name


def test_a_file_without_a_clock_gets_a_rate():
    text = draft(Contents(where="x", arrays={"q": np.zeros((5, 2))}))
    assert "rate_hz = 0.0  # samples per second" in text
    with refused("rate_hz = 0.0 Hz is out of range"):
        parse_columns(text.replace("?", "x"))
