"""Conditioning repairs or leaves out the troubles of real logs, says so, and leaves everything else as it is."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from ffgym.logs.preparation import LowPass
from ffgym.logs.quality import check_quality, condition, notes_of
from ffgym.recordings import Header, Recording, read_recording, write_recording
from tests.logs.quality.conditioning.troubles import (
    bad_row,
    clean,
    doubled,
    jittered,
    of_rows,
    stopped,
    thin,
    with_gaps,
)
from tests.logs.quality.quality_logs import clean_log, described

EFFORT = "motor.effort.elbow"
POSITION = "motor.position.elbow"
SHOULDER, ELBOW = 0, 1


def even(recording: Recording) -> bool:
    return bool(np.ptp(np.diff(recording.t)) < 1e-6 * recording.dt)


def masked(recording: Recording) -> np.ndarray:
    return ~recording.valid


@pytest.mark.parametrize(
    ("robot", "motion"),
    [("two_link", "multisine"), ("two_link", "ladder"), ("one_axis", "sine"), ("irb4600_60_205", "circles")],
)
@pytest.mark.parametrize("sensors", [True, False])
def test_a_clean_log_stays_as_it_is_to_the_bit(robot, motion, sensors):
    recording = clean_log(robot, motion, sensors=sensors)
    assert condition(recording) is recording


def fast() -> float:
    """When the elbow is fastest in the middle of the motion [s]."""
    recording = clean()
    speed = np.abs(recording["motor.velocity.elbow"][3000:6000])
    return float(recording.t[3000 + int(np.argmax(speed))])


TROUBLES = {
    "jitter": lambda: jittered(clean()),
    "gaps": lambda: with_gaps(clean(), ((2000, 3), (4000, 40))),
    "doubled": lambda: doubled(clean(), (3000, 3500, 5000)),
    "spike": lambda: bad_row(clean(), EFFORT, 4000),
    "stop": lambda: stopped(clean(), at=fast()),
    "jitter, gap, spike": lambda: bad_row(with_gaps(jittered(clean()), ((300, 4),)), EFFORT, 500),
    "clock step": lambda: of_rows(clean(), np.arange(8000), clean().t[:8000] + 0.3 * (np.arange(8000) > 3000)),
    "arrival": lambda: of_rows(clean(), np.arange(8000), arrival(clean().t[:8000])),
}


def arrival(t: np.ndarray) -> np.ndarray:
    """Times at which messages arrive: late by chance, by up to 0.4 of a period."""
    return t + 0.4 * (t[1] - t[0]) * np.random.default_rng(3).uniform(size=len(t))


@pytest.mark.parametrize("trouble", TROUBLES)
def test_a_conditioned_log_needs_no_more_and_serves(trouble):
    recording = TROUBLES[trouble]()
    once = condition(recording)
    assert once is not recording
    assert condition(once) is once
    assert even(once)
    assert notes_of(once)
    report = check_quality(recording, described("two_link", "multisine"), ["diagnosis"])
    assert report.verdict == "usable", report.problems[0].message
    assert report.conditioning == notes_of(once)


@pytest.mark.parametrize("trouble", TROUBLES)
def test_what_was_mended_is_flagged(trouble):
    checks = {
        "jitter": "clock_jitter",
        "gaps": "dropped_samples",
        "doubled": "repeated_rows",
        "spike": "spike",
        "clock step": "clock_jump",
        "arrival": "clock_jitter",
    }
    if trouble not in checks:
        pytest.skip("no check is about it")
    (finding, *_) = check_quality(TROUBLES[trouble]()).of(checks[trouble])
    assert finding.verdict == "flagged"
    assert finding.message.startswith("Mended or left out: ")


def error_of_torque(got: Recording, true: Recording, cutoff: float) -> float:
    """RMS of the difference over that of the torque, at the rows of the first, below a frequency."""
    low_pass = LowPass(cutoff=cutoff)
    worst = 0.0
    for name in ("motor.effort.shoulder", EFFORT):
        exact = CubicSpline(true.t, true[name])(got.t)
        difference = low_pass(got[name], got.dt) - low_pass(exact, got.dt)
        worst = max(worst, float(np.sqrt(np.mean(difference[50:-50] ** 2)) / np.std(exact)))
    return worst


def test_rows_every_10_or_12_ms_come_to_an_even_clock_with_little_error():
    """Torque without noise; straight lines would err by a fifth more, and by 0.7 % of the acceleration."""
    true = clean_log("two_link", "multisine", sensors=False)
    got = condition(jittered(true))
    assert got.dt == pytest.approx(0.01)
    assert masked(got).sum() == 0
    assert not got.has("valid")
    assert error_of_torque(got, true, 10.0) < 0.006
    uneven = jittered(true)
    lines = got.with_columns({n: np.interp(got.t, uneven.t, uneven[n]) for n in ("motor.effort.shoulder", EFFORT)})
    assert error_of_torque(got, true, 10.0) < 0.9 * error_of_torque(lines, true, 10.0)
    low_pass = LowPass(cutoff=10.0)
    exact = low_pass(CubicSpline(true.t, true[POSITION])(got.t), got.dt)
    ours = low_pass(got[POSITION], got.dt)
    bend = [np.diff(x, 2)[60:-60] for x in (ours, exact)]
    assert np.std(bend[0] - bend[1]) < 0.001 * np.std(bend[1])


def test_stamps_of_arrival_are_not_taken_for_the_times_of_the_rows():
    recording = TROUBLES["arrival"]()
    got = condition(recording)
    assert np.array_equal(got[POSITION], recording[POSITION])
    assert np.std(got.t - clean().t[: len(got)]) < 0.01 * got.dt
    assert "as smooth at even times" in notes_of(got)[0]


def test_a_coarse_clock_is_not_taken_for_the_times_of_the_rows():
    """Every 8 1/3 ms, written in milliseconds."""
    true = clean_log("two_link", "multisine")
    t = np.arange(0.0, 8.0, 1 / 120)
    columns = {name: CubicSpline(true.t, true[name])(t) for name in true.columns if name.startswith("motor.")}
    rounded = Recording({"timestamp": np.round(t, 3), **columns}, replace(true.header, phases=()))
    got = condition(rounded)
    assert got.dt == pytest.approx(1 / 120, rel=1e-4)
    assert np.array_equal(got[POSITION], rounded[POSITION])


def test_a_step_of_the_clock_is_taken_out():
    got = condition(TROUBLES["clock step"]())
    assert got.t[-1] - got.t[0] == pytest.approx(7.999)
    assert not masked(got).any()
    assert "clock steps" in notes_of(got)[0]


def test_missing_rows_are_bridged_and_left_out_if_they_are_long():
    true, got = clean(), condition(with_gaps(clean(), ((2000, 3), (4000, 40))))
    assert len(got) == len(true)
    assert np.flatnonzero(masked(got).all(axis=1)).tolist() == list(range(4000, 4040))
    assert np.abs(got[POSITION] - true[POSITION])[2000:2003].max() < 1e-3 * np.ptp(true[POSITION])
    assert np.abs(got[POSITION] - true[POSITION])[4000:4040].max() < 2e-2 * np.ptp(true[POSITION])


def test_a_pause_ends_a_log():
    recording = clean()
    t = recording.t + 60.0 * (np.arange(len(recording)) >= 3000)
    got = condition(of_rows(recording, np.arange(len(recording)), t))
    assert len(got) == len(recording) - 3000
    assert "only the longest part" in notes_of(got)[0]


def test_doubled_rows_are_dropped():
    true, got = clean(), condition(TROUBLES["doubled"]())
    assert len(got) == len(true)
    assert np.abs(got[POSITION] - true[POSITION]).max() < 1e-3 * np.ptp(true[POSITION])
    assert "3 rows of" in notes_of(got)[0]


@pytest.mark.parametrize("name", [EFFORT, POSITION])
def test_one_bad_row_is_replaced_and_left_out_for_its_joint(name):
    true, got = clean(), condition(bad_row(clean(), name, 4000))
    assert np.argwhere(masked(got)).tolist() == [[4000, ELBOW]]
    assert abs(got[name][4000] - true[name][4000]) < 0.05 * np.ptp(true[name])
    others = [other for other in true.columns if other != name]
    assert all(np.array_equal(got[other], true[other]) for other in others)
    assert f"{name} (1 row, the first at" in notes_of(got)[0]


def test_one_row_that_is_odd_for_several_joints_is_left_out_for_all():
    recording = bad_row(bad_row(clean(), EFFORT, 4000), "motor.effort.shoulder", 4000)
    assert np.argwhere(masked(condition(recording))).tolist() == [[4000, SHOULDER], [4000, ELBOW]]


def test_one_bad_row_of_another_column_leaves_torques_in():
    got = condition(bad_row(clean(), "motor.velocity.elbow", 4000))
    assert not got.has("valid")
    assert abs(got["motor.velocity.elbow"] - clean()["motor.velocity.elbow"]).max() < 5.0


def test_a_bad_row_of_the_tracker_is_a_missing_one():
    recording = clean_log("irb4600_60_205", "circles")
    seen = np.flatnonzero(np.isfinite(recording["tcp.position.x"]))
    x = recording["tcp.position.x"].copy()
    x[seen[len(seen) // 2]] += 1.0
    got = condition(recording.with_columns({"tcp.position.x": x}))
    assert np.isnan(got["tcp.position.x"][seen[len(seen) // 2]])
    assert not got.has("valid")


def test_a_column_that_sticks_out_all_the_time_is_left_to_the_gate():
    recording, rng = clean(), np.random.default_rng(0)
    torque = recording[EFFORT].copy()
    rows = rng.choice(len(torque), size=len(torque) // 50, replace=False)
    torque[rows] += 2 * np.ptp(torque)
    bad = recording.with_columns({EFFORT: torque})
    assert condition(bad) is bad
    assert check_quality(bad).verdict == "insufficient"


def test_an_abrupt_stop_and_the_rest_after_it_are_left_out():
    got = condition(TROUBLES["stop"]())
    out = np.flatnonzero(masked(got).all(axis=1))
    assert got.t[out[0]] == pytest.approx(fast(), abs=0.04)
    assert out[-1] == len(got) - 1
    assert got.t[-1] - got.t[out[0]] == pytest.approx(0.25, abs=0.01)
    assert not masked(got)[: out[0]].any()
    assert "stop abruptly" in notes_of(got)[0]


def stuck(name: str, rows: slice) -> Recording:
    recording = clean()
    values = recording[name].copy()
    values[rows] = values[rows.start]
    return recording.with_columns({name: values})


@pytest.mark.parametrize(("name", "joints"), [(EFFORT, [ELBOW]), (POSITION, [SHOULDER, ELBOW])])
def test_a_stuck_column_is_left_out(name, joints):
    first = int(np.searchsorted(clean().t, fast())) - 50
    rows = slice(first, first + 100)
    got = condition(stuck(name, rows))
    assert masked(got)[rows.start + 2 : rows.stop - 1, joints].all()
    assert masked(got).sum() <= len(joints) * (rows.stop - rows.start + 2)
    assert np.diff(got[name])[rows.start + 2 : rows.stop - 1].all()


def test_a_noisy_stretch_is_left_out():
    recording, rng = clean_log("two_link", "multisine", sensors=False), np.random.default_rng(0)
    torque = recording[EFFORT].copy()
    torque[3008:3400] += rng.normal(scale=0.3 * np.ptp(torque), size=392)
    noisy = recording.with_columns({EFFORT: torque})
    got = condition(noisy)
    assert masked(got)[3008:3400, ELBOW].all()
    assert not masked(got)[:, SHOULDER].any()
    assert np.array_equal(got[EFFORT], torque)
    assert check_quality(noisy, described("two_link", "multisine"), ["diagnosis"]).verdict == "usable"


def test_a_clock_of_slow_rows_that_is_even_enough_is_even():
    assert condition(thin(clean())).equals(thin(clean()))


def test_a_held_torque_acts_in_the_middle_of_its_interval():
    """A torque that rises evenly, held until the next row, is later by half an interval than its stamps say."""
    steps = np.random.default_rng(0).choice([0.010, 0.012], size=400)
    t = np.concatenate([[0.0], np.cumsum(steps)])
    header = Header(robot="bench", joints=("j1",), gear_ratio=(1.0,), torque_semantics="motor_side", hold="zoh")
    columns = {"timestamp": t, "motor.position.j1": np.sin(2 * t), "motor.effort.j1": t + 0.5 * np.append(steps, 0.01)}
    got = condition(Recording(columns, header))
    assert got.header.hold == "sampled"
    inner = slice(10, -10)
    np.testing.assert_allclose(got["motor.effort.j1"][inner], got.t[inner], atol=1e-4)


def test_a_mask_survives_files_slices_and_an_uneven_clock(tmp_path):
    recording = clean()
    mask = np.ones(len(recording))
    mask[3000:3500] = 0.0
    given = recording.with_columns({"valid.shoulder": np.ones(len(mask)), "valid.elbow": mask})
    for suffix in ("npz", "csv"):
        write_recording(given, tmp_path / f"log.{suffix}")
        assert read_recording(tmp_path / f"log.{suffix}").equals(given)
    assert masked(given.slice(3.0, 4.0)).sum() == 500
    got = condition(jittered(given))
    out = got.t[masked(got)[:, ELBOW]]
    assert not masked(got)[:, SHOULDER].any()
    assert (out.min(), out.max()) == pytest.approx((3.0, 3.5), abs=0.025)
    assert condition(given) is given


def test_a_long_end_that_counts_for_no_joint_is_dropped():
    recording = clean()
    mask = np.ones(len(recording))
    mask[6000:] = 0.0
    got = condition(recording.with_columns({"valid.shoulder": mask, "valid.elbow": mask}))
    assert len(got) == 6250
    assert "Rows that count for no joint" in notes_of(got)[0]


def test_a_log_of_which_nothing_is_left_is_refused():
    recording = clean()
    mask = np.zeros(len(recording))
    mask[4000:4100] = 1.0
    nothing = recording.with_columns({"valid.shoulder": np.zeros(len(mask)), "valid.elbow": np.zeros(len(mask))})
    assert [f.check for f in check_quality(nothing).problems if f.verdict == "refused"] == ["nothing_left"]
    little = recording.with_columns({"valid.shoulder": np.ones(len(mask)), "valid.elbow": mask})
    assert check_quality(little).verdict == "usable"
    assert {f.check for f in check_quality(little).problems} == {"masked"}


def fast_sine(amplitude: float, rest: float, rate: float = 5000.0) -> Recording:
    """A joint that rests, then turns to and fro, read by an encoder of 17 bits at the motor; torque in milliamperes."""
    t = np.arange(0.0, 6.0, 1 / rate)
    since = np.maximum(t - rest, 0.0)
    grow = np.clip(since, 0, 1) ** 3
    angle = 100 * amplitude * grow * np.sin(2 * np.pi * 0.7 * since)
    speed = np.gradient(angle, t)
    torque = 0.4 * np.tanh(speed / 0.05) + 0.01 * speed + 0.02 * np.random.default_rng(0).normal(size=len(t))
    step = 2 * np.pi / 2**17
    header = Header(robot="bench", joints=("j1",), gear_ratio=(100.0,), torque_semantics="motor_side", hold="sampled")
    columns = {
        "timestamp": t,
        "motor.position.j1": np.round(angle / step) * step,
        "motor.effort.j1": np.round(torque, 3),
    }
    return Recording(columns, header)


@pytest.mark.parametrize("amplitude", [0.02, 0.3])
@pytest.mark.parametrize("rest", [0.0, 2.0])
def test_turning_points_and_a_rest_at_5_khz_are_nothing_bad(amplitude, rest):
    recording = fast_sine(amplitude, rest)
    assert condition(recording) is recording
    assert check_quality(recording, needs=["diagnosis"]).verdict != "insufficient"


def test_a_torque_that_is_written_at_a_tenth_of_the_rate_is_not_stuck():
    recording = fast_sine(0.3, 0.0)
    torque = np.repeat(recording["motor.effort.j1"][::100], 100)[: len(recording)]
    held = recording.with_columns({"motor.effort.j1": torque})
    assert condition(held) is held
    assert [f.verdict for f in check_quality(held).of("stuck")] == ["ok"]


@pytest.mark.parametrize(("jump", "bad"), [(0.0, False), (1.0, True)])
def test_a_servo_that_sticks_by_friction_is_not_stuck(jump, bad):
    """100 Hz, no set-points: the joint stops within a row, and goes on from where it stood; a lost encoder jumps."""
    t = 0.01 * np.arange(1000)
    angle = 50 * np.sin(0.8 * t)
    missed = angle[330] - angle[300]
    angle[300:330] = angle[300]
    angle[330:] -= (1 - jump) * missed
    step = 2 * np.pi / 2**17
    header = Header(robot="bench", joints=("j1",), gear_ratio=(100.0,), torque_semantics="motor_side", hold="sampled")
    columns = {"timestamp": t, "motor.position.j1": np.round(angle / step) * step, "motor.effort.j1": np.cos(3 * t)}
    recording = Recording(columns, header)
    assert (condition(recording) is not recording) == bad
    assert ("stuck" in {f.check for f in check_quality(recording).problems}) == bad
