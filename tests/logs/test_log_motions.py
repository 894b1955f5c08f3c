"""Files with several motions, clocks of many kinds, and samples between the rows."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from log_samples import CLOCK, LOG, N_ROWS, POSITION, arrays, column_map, refused, write_npz

from ffgym.logs import read_log, read_logs
from ffgym.logs.convert import resample

STACKED = POSITION + 'axes = ["motion", "time", "part"]\n'
RATE = '[columns.timestamp]\nrate_hz = "fs"\n'
STACK = np.arange(3)[:, None, None] + arrays()["q"]


def test_motions_along_an_axis_are_recordings_with_names_and_meta_of_their_own(tmp_path):
    path = write_npz(tmp_path, q=STACK, fs=np.array(250.0), hours=np.array(["9:00", "9:30", "10:00"]), cell=np.array(7))
    extra = '[motions]\nnames = "hours"\n[meta]\nhour = { source = "hours" }\ncell = { source = "cell" }\n'
    recordings = read_logs(path, column_map(RATE, STACKED, extra))
    assert [r.header.segment for r in recordings] == ["run_9:00", "run_9:30", "run_10:00"]
    assert [r.header.meta for r in recordings] == [{"hour": h, "cell": 7} for h in ("9:00", "9:30", "10:00")]
    for recording, q in zip(recordings, STACK, strict=True):
        np.testing.assert_array_equal(recording.joint_array("motor.position"), q)
        np.testing.assert_array_equal(recording.t, np.arange(N_ROWS) / 250.0)


def test_motions_may_share_a_clock_or_have_one_each(tmp_path):
    clocks = arrays()["t"] + 10 * np.arange(3)[:, None]
    clock = CLOCK + 'axes = ["motion", "time"]\n'
    shared = read_logs(write_npz(tmp_path, q=STACK), column_map(CLOCK, STACKED))
    own = read_logs(write_npz(tmp_path, q=STACK, t=clocks), column_map(clock, STACKED))
    assert [r.t[0] for r in shared] == [0.0, 0.0, 0.0]
    assert [r.t[0] for r in own] == [0.0, 10.0, 20.0]
    with refused("run.npz: holds 3 motions"):
        read_log(tmp_path / "run.npz", column_map(clock, STACKED))


def test_rows_are_split_where_a_number_changes(tmp_path):
    run = np.array([4, 4, 4, 2, 2, 9, 9])
    recordings = read_logs(write_npz(tmp_path, run=run), column_map(CLOCK, POSITION, '[motions]\nsplit = "run"\n'))
    assert [(r.header.segment, len(r)) for r in recordings] == [("run_4", 3), ("run_2", 2), ("run_9", 2)]
    np.testing.assert_array_equal(recordings[1].joint_array("motor.position"), arrays()["q"][3:5])


@pytest.mark.parametrize(
    ("tables", "changes", "message"),
    [
        ('[motions]\nsplit = "run"', {"run": np.array([0, 0, 1, 1, 0, 0, 1])}, "comes back to 0 in row 4; sort"),
        ('[motions]\nsplit = "run"', {"run": np.array([0, 0, 1, 1, 1, 1])}, "has 7 rows, but the array that splits"),
        ('[motions]\nsplit = "q"', {}, "'q' has shape (7, 2), must be one number per row"),
        ('[motions]\nnames = "run"', {"run": np.array(["a", "b"])}, "'run' has shape (2,), must be (1,), one per"),
        ('[motions]\nsplit = "absent"', {}, "There is no 'absent' in the file"),
    ],
)  # fmt: skip
def test_motions_that_cannot_be_told_apart_are_refused(tables, changes, message, tmp_path):
    with refused(message):
        read_logs(write_npz(tmp_path, **changes), column_map(CLOCK, POSITION, tables))


def test_stacked_arrays_must_hold_equally_many_motions(tmp_path):
    effort = '[columns."motor.effort"]\nsource = "u"\nunit = "N m"\naxes = ["motion", "time", "part"]\n'
    with refused("Arrays hold different numbers of motions along their axis 'motion': [2, 3]"):
        read_logs(write_npz(tmp_path, q=STACK, u=STACK[:2]), column_map(CLOCK, STACKED, effort))
    with refused("'hours' = ['9', '9', '10'] must be different for each motion"):
        names = '[motions]\nnames = "hours"\n'
        read_logs(write_npz(tmp_path, q=STACK, hours=np.array(["9", "9", "10"])), column_map(CLOCK, STACKED, names))


@pytest.mark.parametrize(("unit", "per_second"), [("s", 1), ("ms", 1e3), ("us", 1e6), ("ns", 1e9), ("min", 1 / 60)])
def test_a_clock_may_count_in_any_unit(unit, per_second, tmp_path):
    clock = CLOCK.replace('"s"', f'"{unit}"')
    recording = read_log(write_npz(tmp_path, t=arrays()["t"] * per_second), column_map(clock, POSITION))
    np.testing.assert_allclose(recording.t, arrays()["t"], rtol=1e-15)


@given(start=st.integers(0, 2**62), steps=st.lists(st.integers(1, 10**9), min_size=1, max_size=9))
def test_nanoseconds_since_1970_keep_every_digit(start, steps):
    from ffgym.logs.convert import since

    clock = start + np.concatenate([[0], np.cumsum(steps)])
    assert since(clock.astype(np.uint64), np.uint64(start)).tolist() == np.concatenate([[0], np.cumsum(steps)]).tolist()


def test_times_count_from_the_first_row_if_the_map_says_so(tmp_path):
    clock = CLOCK.replace('"s"', '"ns"') + "from_first = true\n"
    t = 1_790_000_000_123_456_789 + 4_000_000 * np.arange(N_ROWS)
    recording = read_log(write_npz(tmp_path, t=t), column_map(clock, POSITION))
    np.testing.assert_array_equal(recording.t, 0.004 * np.arange(N_ROWS))


@pytest.mark.parametrize("rate", [0.0, np.inf, np.nan, [250.0, 250.0]])
def test_a_rate_must_be_one_number_above_0(rate, tmp_path):
    with refused("[columns.'timestamp']: rate_hz =", "must be one number > 0"):
        read_log(write_npz(tmp_path, fs=np.array(rate)), column_map(RATE, POSITION))


TRACKER = '[columns."tcp.position"]\nsource = "xyz"\nunit = "mm"\nclock = "t_xyz"\nclock_unit = "ms"\n'


def test_a_tracker_with_a_clock_in_other_units_is_put_in_place(tmp_path):
    clock = CLOCK.replace('"s"', '"us"') + "from_first = true\n"
    t_us = 5_000_000 + (1e6 * arrays()["t"]).astype(np.int64)
    t_xyz = np.array([5004.0, 5016.0])
    path = write_npz(tmp_path, t=t_us, t_xyz=t_xyz, xyz=1000.0 * np.array([[1, 2, 3], [4, 5, 6]]))
    recording = read_log(path, column_map(clock, POSITION, TRACKER + 'resample = "gaps"\n'))
    seen = np.flatnonzero(np.isfinite(recording["tcp.position.x"]))
    assert seen.tolist() == [1, 4]
    np.testing.assert_array_equal(recording.vector("tcp.position")[seen], [[1, 2, 3], [4, 5, 6]])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"t_xyz": np.array([0.0, 0.0])}, "its clock must increase, but sample 1 is at 0.0 s after 0.0 s"),
        ({"t_xyz": np.array([0.0, np.nan])}, "its clock must increase, but sample 1 is at nan s"),
        ({"t_xyz": np.array([0.0, 1.0, 2.0])}, "its clock has 3 times for 2 samples"),
        (
            {"t_xyz": np.array([0.0]), "xyz": np.ones((1, 3))},
            "has 1 samples for 7 rows; to resample takes at least 2 of each",
        ),
        ({"t_xyz": None}, "There is no 't_xyz' in the file"),
    ],
)
def test_a_clock_that_does_not_fit_is_one_error(changes, message, tmp_path):
    path = write_npz(tmp_path, **{"t_xyz": np.array([0.0, 8.0]), "xyz": np.ones((2, 3)), **changes})
    with refused("[columns.'tcp.position']", message):
        read_log(path, column_map(CLOCK, POSITION, TRACKER + 'resample = "linear"\n'))


def test_only_what_may_miss_samples_gets_gaps(tmp_path):
    entry = '[columns."reference.position"]\nsource = "q"\nunit = "rad"\nclock = "t"\nresample = "gaps"\n'
    with refused("resample = 'gaps' leaves NaN, which reference.position may not hold; take 'linear' or 'hold'"):
        read_log(write_npz(tmp_path), column_map(CLOCK, POSITION, entry))
    turn = '[columns."tcp.orientation"]\nsource = "o"\nunit = "1"\nclock = "t"\nresample = "linear"\n'
    with refused("resample = 'linear' between orientations gives none"):
        read_log(write_npz(tmp_path, o=np.ones((N_ROWS, 4))), column_map(CLOCK, POSITION, turn))
    with refused("resample needs clock"):
        read_log(
            write_npz(tmp_path), column_map(CLOCK, POSITION, entry.replace('clock = "t"\n', "").replace("gaps", "hold"))
        )


def test_scaled_clocks_are_not_compared(tmp_path):
    path = write_npz(tmp_path, t_xyz=np.array([0.0, 8.0]), xyz=np.ones((2, 3)))
    with refused("resample compares clocks in their units; timestamp then has no scale"):
        read_log(path, column_map(CLOCK + "scale = 2\n", POSITION, TRACKER + 'resample = "gaps"\n'))
    own = '[columns."tcp.timestamp"]\nsource = "t"\nunit = "s"\nfrom_first = true\noffset = 1\n'
    with refused("from_first takes the clock in its unit"):
        read_log(path, column_map(CLOCK, POSITION, own))


@given(
    clock=st.lists(st.integers(0, 400), min_size=2, max_size=40, unique=True).map(sorted),
    how=st.sampled_from(["gaps", "linear", "hold"]),
)
def test_a_sample_at_the_time_of_a_row_is_that_rows_sample(clock, how):
    t = np.arange(0, 401, 4) / 1000
    times = np.array(clock) / 1000
    samples, reached = resample(np.sin(times)[:, None], times, t, how)
    shared = np.isin(np.arange(0, 401, 4), clock)
    assert reached[shared].all()
    np.testing.assert_allclose(samples[shared, 0], np.sin(t[shared]))
    if how == "gaps":
        taken = samples[np.isfinite(samples)]
        assert len(np.unique(taken)) == len(taken)  # no sample is in two rows


def test_a_source_that_falls_silent_is_held_no_longer_than_its_longest_wait():
    t = 0.125 * np.arange(10)
    samples, reached = resample(np.array([[1.0], [2.0], [3.0]]), np.array([0.125, 0.5, 0.625]), t, "hold")
    np.testing.assert_array_equal(reached, (t >= 0.125) & (t <= 0.625 + 0.375))
    np.testing.assert_array_equal(np.isfinite(samples[:, 0]), reached)


def test_trimming_drops_rows_at_both_ends_only(tmp_path):
    path = write_npz(tmp_path, t_xyz=np.array([3.0, 17.0]), xyz=np.ones((2, 3)))
    recording = read_log(path, column_map(CLOCK, POSITION, TRACKER + 'resample = "linear"', log=LOG + "trim = true\n"))
    np.testing.assert_array_equal(recording.t, arrays()["t"][1:5])


@pytest.mark.parametrize("hours", [["9:30", "9:00", "10:00:30"], ["34200", "32400", "36030"]])
def test_times_of_day_become_seconds_since_the_earliest_motion(tmp_path, hours):
    path = write_npz(tmp_path, q=STACK, fs=np.array(250.0), hours=np.array(hours))
    extra = '[motions]\nnames = "hours"\n[meta]\nsession_start = { source = "hours", since_first = true }\n'
    recordings = read_logs(path, column_map(RATE, STACKED, extra))
    assert [r.header.meta["session_start"] for r in recordings] == [1800.0, 0.0, 3630.0]


def test_a_time_of_day_that_is_none_is_refused(tmp_path):
    path = write_npz(tmp_path, q=STACK, fs=np.array(250.0), hours=np.array(["9:00", "noon", "10:00"]))
    with refused("'hours' = ['9:00', 'noon', '10:00'] must be seconds, or times like '20:29'"):
        read_logs(path, column_map(RATE, STACKED, '[meta]\nbegan = { source = "hours", since_first = true }\n'))
