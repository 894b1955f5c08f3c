import copy
import pickle
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recording_samples import columns, header, phases, recording, recordings, refused

from ffgym.core.errors import FFGymError
from ffgym.recordings import (
    FAMILIES,
    Phase,
    Recording,
    contour_errors,
    motor_error_rms,
    path_errors,
    write_recording,
)


def with_phases(*borders: float, n_rows: int = 5) -> Recording:
    pairs = pairwise(borders)
    kinds = ("standstill", "lead_in", "circle", "lead_out")
    parts = tuple(Phase(label=f"p{i}", kind=kinds[i], start=a, end=b) for i, (a, b) in enumerate(pairs))
    return Recording({"timestamp": np.arange(n_rows)}, header(phases=parts))


def changed(name: str, row: int, value: float) -> dict[str, Any]:
    table = columns()
    table[name][row] = value
    return table


def test_columns_are_read_only_copies() -> None:
    table = columns()
    rec = Recording(table, header())
    table["timestamp"][0] = -1.0
    assert rec.t[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        rec.t[0] = 1.0
    with pytest.raises(TypeError):
        rec.columns["timestamp"] = table["timestamp"]  # type: ignore[index]


def test_masked_samples_are_missing_ones() -> None:
    table = {name: np.ma.masked_array(values, mask=[0, 1, 0, 0, 0]) for name, values in columns().items()}
    tcp = [name for name in table if name.startswith("tcp.")]
    seen = Recording({**columns(), **{name: table[name] for name in tcp}}, header())
    assert [np.flatnonzero(np.isnan(seen[name])).tolist() for name in tcp] == [[1]] * len(tcp)
    with refused("Column 'motor.position.j1' row 1 is nan, must be finite"):
        Recording({**columns(), "motor.position.j1": table["motor.position.j1"]}, header())


@pytest.mark.parametrize("use", [path_errors, contour_errors, motor_error_rms, lambda r: write_recording(r, "a.npz")])
def test_a_list_in_place_of_a_recording_is_named(use: Callable[[Any], object]) -> None:
    with refused("recording must be a Recording, got list; read_recording makes one"):
        use([recording()])


def test_a_recording_in_place_of_a_list_says_so() -> None:
    with refused("This is one recording, not a list of them: put it in one"):
        list(recording())


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({}, "Column 'timestamp' [s] is required. Present: none"),
        ({"timestamp": [0.0]}, "at least 2 rows, got 1"),
        ({**columns(), "tcp.timestamp": [0.0]}, "Column 'tcp.timestamp' has 1 rows, must be 5 as in timestamp"),
        ({"timestamp": [[0.0], [1.0]]}, "real numbers of shape (T,), got float64 of shape (2, 1)"),
        ({"timestamp": ["0", "1"]}, "Column 'timestamp' must be real numbers"),
        ({"timestamp": [0, 1j]}, "Column 'timestamp' must be real numbers"),
        ({"timestamp": [[0], [1, 2]]}, "Column 'timestamp' must be numbers, one per row"),
        ({"timestamp": [0, 1, 1, 0]}, "row 2 is 1.0 s after 1.0 s"),
        ({"timestamp": [0, 1.7e18]}, "timestamp row 1 is 1.7e+18 s, beyond 1e+11 s. Convert it to seconds"),
        (changed("timestamp", 3, np.nan), "Column 'timestamp' row 3 is nan, must be finite; only tcp.*"),
        (changed("motor.position.j2", 4, np.nan), "Column 'motor.position.j2' row 4 is nan"),
        (changed("motor.position.j2", 1, -np.inf), "Column 'motor.position.j2' row 1 is -inf"),
        (changed("tcp.position.x", 2, np.inf), "Column 'tcp.position.x' row 2 is inf, must be finite."),
    ],
)
def test_invalid_columns_are_refused(table: dict[str, Any], message: str) -> None:
    with refused(message):
        Recording(table, header())


def test_missing_samples_of_the_tool_are_nan() -> None:
    rec = Recording(changed("tcp.position.y", 2, np.nan), header())
    np.testing.assert_array_equal(np.isnan(rec.vector("tcp.position")).nonzero(), [[2], [1]])


def test_arguments_of_the_wrong_type_are_refused() -> None:
    with refused("header must be a Header, got dict"):
        Recording(columns(), {})  # type: ignore[arg-type]
    with refused("columns must map names to arrays, got list"):
        Recording([], header())  # type: ignore[arg-type]


def test_joint_array_and_vector_stack_in_the_order_of_the_header() -> None:
    rec = recording(joints=("j2", "j1"))
    np.testing.assert_array_equal(rec.joint_array("motor.position")[:, 0], rec["motor.position.j2"])
    np.testing.assert_array_equal(rec.vector("tcp.position")[:, 2], rec["tcp.position.z"])
    assert rec.joint_array("motor.position").shape == (5, 2)


def test_absent_columns_are_named_with_what_is_available() -> None:
    rec = recording()
    with refused("No column 'motor.effort.j1' in this recording. Available: timestamp, motor.position, tcp.position"):
        rec.joint_array("motor.effort")
    with refused("tcp.position is read with recording.vector('tcp.position')"):
        rec.joint_array("tcp.position")
    with refused("timestamp is read with recording['timestamp']"):
        rec.vector("timestamp")
    with refused("Unknown column family 'motor.efort'"):
        rec.has("motor.efort")


def test_has_says_which_families_are_present() -> None:
    rec = recording().with_columns({"user.x": range(5)}, units={"user.x": "mm"})
    assert {name for name in FAMILIES if rec.has(name)} == {"timestamp", "motor.position", "tcp.position"}
    assert rec.has("user.x")
    assert not rec.has("user.y")
    assert [rec.unit(name) for name in ("user.x", "timestamp", "tcp.position.x")] == ["mm", "s", "m"]


def test_period_is_the_median() -> None:
    assert Recording({"timestamp": [0, 1, 2, 10]}, header()).dt == 1.0


def test_phase_is_half_open_and_may_end_one_period_after_the_last_row() -> None:
    rec = with_phases(0, 2, 3.5, 5)
    assert rec.mask(label="p0").tolist() == [True, True, False, False, False]
    assert rec.mask(kind="lead_in").tolist() == [False, False, True, True, False]
    assert rec.mask(kind="circle", label="p2").tolist() == [False, False, False, False, True]
    assert rec.mask().all()
    assert not rec.mask(kind="motion").any()
    assert not rec.mask(kind="circle", label="p0").any()
    assert [phase.label for phase in rec.phases_of("lead_in")] == ["p1"]


@pytest.mark.parametrize("borders", [(-0.1, 2), (0, 5.1), (7, 8)])
def test_phase_outside_the_recording_is_refused(borders: tuple[float, float]) -> None:
    with refused("lies outside the recording, [0.0, 5.0] s"):
        with_phases(*borders)


def test_unknown_phase_is_refused() -> None:
    with refused("Unknown phase label 'p9'. Available: p0, p1"):
        with_phases(0, 1, 2).mask(label="p9")
    with refused("Unknown phase kind 'circel'"):
        with_phases(0, 1, 2).phases_of("circel")  # type: ignore[arg-type]


@given(st.data())
def test_rows_keep_their_phase_when_a_recording_is_cut(data: Any) -> None:
    times = [0.0, 1.0, 2.0, 3.0, 5.0, 6.0, 7.0]
    whole = Recording({"timestamp": times}, header(phases=data.draw(phases(times))))
    border = st.none() | st.sampled_from(times) | st.floats(-1, 8)
    start, end = data.draw(border), data.draw(border)
    try:
        part = whole.slice(start, end)
    except FFGymError:
        assert sum((start is None or t >= start) and (end is None or t < end) for t in times) < 2
        return
    kept = np.isin(whole.t, part.t)
    assert all((start is None or t >= start) and (end is None or t < end) for t in part.t)
    for kind in ("standstill", "circle", None):
        np.testing.assert_array_equal(part.mask(kind=kind), whole.mask(kind=kind)[kept])


def test_cut_that_leaves_less_than_two_rows_is_refused() -> None:
    with refused("slice(0.5, 1.5) keeps 1 rows of [0.0, 4.0] s, must keep at least 2"):
        with_phases(0, 5).slice(0.5, 1.5)


def test_with_columns_returns_a_new_recording() -> None:
    rec = recording()
    more = rec.with_columns(**{"tcp.timestamp": rec.t + 1.0})
    assert more.has("tcp.timestamp")
    assert not rec.has("tcp.timestamp")
    with refused("Unknown column 'timestamps'"):
        rec.with_columns(timestamps=rec.t)


def test_equality_is_exact_to_the_bit() -> None:
    rec = recording()
    assert rec.equals(Recording(dict(reversed(list(rec.columns.items()))), rec.header))
    assert not rec.equals(rec.with_columns({"timestamp": np.nextafter(rec.t, 9.0)}))
    assert not rec.equals(rec.with_columns(changed("timestamp", 0, -0.0)))
    assert not rec.equals(rec.with_columns({"tcp.timestamp": rec.t}))
    assert not rec.equals(replace(rec, header=header(segment="other")))


@given(recordings())
def test_copies_and_pickles_are_equal_and_still_read_only(rec: Recording) -> None:
    for twin in (copy.deepcopy(rec), pickle.loads(pickle.dumps(rec))):
        assert twin.equals(rec)
        assert not twin.t.flags.writeable


def test_derived_recording_shares_columns_that_it_keeps_and_checks_all_others() -> None:
    rec = recording()
    moved = rec.t + 1.0
    other = rec.derive({**rec.columns, "timestamp": moved, "tcp.position.x": np.full(len(rec), np.nan)})
    assert other["motor.position.j1"] is rec["motor.position.j1"]
    assert np.isnan(other["tcp.position.x"]).all()
    moved[0] = -1.0
    assert other.t[0] == rec.t[0] + 1.0
    with refused("Column 'motor.position.j1' row 0 is nan, must be finite"):
        other.derive({**other.columns, "motor.position.j1": other["tcp.position.x"]})
    with refused("motor.position is incomplete: motor.position.j1 missing"):
        rec.derive({name: values for name, values in rec.columns.items() if name != "motor.position.j1"})
    with refused("Column 'motor.position.j2' has 4 rows, must be 5"):
        rec.derive({**rec.columns, "motor.position.j2": np.zeros(4)})


def test_cut_columns_do_not_keep_the_whole_and_cannot_be_changed() -> None:
    part = recording().slice(0.004)
    assert all(values.base is None and not values.flags.writeable for values in part.columns.values())
