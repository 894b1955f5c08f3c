"""Long logs are thinned to what a diagnosis can afford: stretches that tell most, spread over all of the log."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis import diagnose
from ffgym.diagnosis.settings import Settings, use_settings
from ffgym.diagnosis.thinning import compute_affordable_time, read_notes, thin
from ffgym.diagnosis.thinning_cells import MotionRegressor, cut_cells, take_medians
from ffgym.effects import EFFECTS
from ffgym.paths import joint_reference, multisine
from ffgym.recordings import Recording, write_recording
from ffgym.recordings.io import Stored
from ffgym.recordings.stretch import read_session_start
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine

DT = 0.004

AFFORDED = 60.0
"""Time that a diagnosis can afford in these tests [s]."""


@pytest.fixture(autouse=True)
def small():
    """A bound that logs of some minutes exceed."""
    with use_settings({"blocks.samples": round(AFFORDED / DT)}):
        yield


def swing(amplitude, frequency, seconds):
    """To and fro, from rest to rest."""
    t = DT * np.arange(round(seconds / DT))
    return amplitude * np.sin(2 * np.pi * frequency * t) * np.minimum(1.0, np.minimum(t, t[::-1]))


def working(robot, motions, *, rest=1.0, name="day", noise=1e-5, seed=0):
    """Positions of one axis that makes motions, with a rest after each; no torque that belongs to them."""
    still = np.zeros(round(rest / DT))
    angle = np.concatenate([part for motion in motions for part in (motion, still)]) * 100.0
    angle = angle + np.random.default_rng(seed).normal(scale=noise, size=len(angle))
    (made,) = simulate([Run(reference=joint_reference(robot, multisine([0.0], [[0.1]], [1.0], [[0.0]], 1.0)))])
    columns = {"timestamp": DT * np.arange(len(angle)), "motor.position.j1": angle, "motor.effort.j1": angle}
    return Recording(columns, replace(made.header, segment=name, phases=()))


def lasting(recordings):
    return sum(float(one.t[-1] - one.t[0]) for one in recordings)


def top_speed(recordings):
    return max(np.abs(np.gradient(one["motor.position.j1"][::10], 10 * DT)).max() for one in recordings)


def test_a_log_that_can_be_afforded_is_left_as_it_is(one_axis):
    short = working(one_axis, [swing(0.1, 0.5, 8.0)] * 6)
    assert lasting([short]) < AFFORDED
    assert thin([short]) == [short]
    assert read_notes(thin([short])) == ()


def test_six_axes_can_afford_the_protocol_diagnosis_at_1_khz_and_recorded_sessions():
    with use_settings({"blocks.samples": Settings().blocks.samples}):
        assert 88.0 < compute_affordable_time(0.001, 6) < 100.0
        assert compute_affordable_time(0.01, 6) > 415.0  # all recordings of the UR10e
        assert compute_affordable_time(0.1, 6) > 3630.0  # those of the KR300


def test_a_long_log_is_thinned_to_the_bound_and_spread_over_all_its_time(one_axis):
    long = working(one_axis, [swing(0.1, 0.5, 9.0), swing(0.2, 0.3, 9.0), swing(0.05, 1.0, 9.0)] * 10)
    parts = thin([long])
    assert 0.8 * AFFORDED < lasting(parts) <= AFFORDED
    begins = [read_session_start(part.header) for part in parts]
    assert begins == [float(part.t[0]) for part in parts]
    assert begins == sorted(begins)
    assert all(any(third * 100 <= begin < (third + 1) * 100 for begin in begins) for third in range(3))
    assert thin(parts) == parts
    (note,) = read_notes(parts)
    assert f"{lasting(parts):.0f} of {lasting([long]):.0f} s are used, {len(parts)} stretches of 1 recording" in note


def test_rows_of_a_stretch_are_those_of_the_log(one_axis):
    long = working(one_axis, [swing(0.1, 0.5, 9.0)] * 30)
    for part in thin([long]):
        rows = np.searchsorted(long.t, part.t)
        assert all(np.array_equal(part[name], long[name][rows]) for name in long.columns)


def test_what_is_rare_in_a_long_log_is_used(one_axis):
    usual = [swing(0.02, 0.2, 9.0)] * 15
    long = working(one_axis, [*usual, swing(0.5, 0.3, 9.0), *usual])
    parts = thin([long])
    assert top_speed(parts) == pytest.approx(top_speed([long]), rel=0.05)
    reversals = [np.count_nonzero(np.diff(np.sign(np.diff(one["motor.position.j1"][::50])))) for one in parts]
    assert sum(reversals) > len(parts)


def test_a_glitch_draws_no_stretch(one_axis):
    long = working(one_axis, [swing(0.05 + 0.005 * k, 0.5, 9.0) for k in range(30)])
    angle = long["motor.position.j1"].copy()
    angle[[20_000, 40_000]] += 1e4
    assert [one.t[0] for one in thin([long.with_columns({"motor.position.j1": angle})])] == [
        one.t[0] for one in thin([long])
    ]


def test_stretches_begin_and_end_at_rest_where_joints_rest(one_axis):
    parts = thin([working(one_axis, [swing(0.1, 0.5, 9.0)] * 30)])
    assert all(part.valid.all() for part in parts)
    assert max(np.abs(np.gradient(part["motor.position.j1"][:20]).mean()) for part in parts) < 1e-3
    moving = thin([working(one_axis, [swing(0.1, 0.5, 300.0)])])
    assert lasting(moving) > 0.8 * AFFORDED
    assert not any(part.valid[0, 0] for part in moving if part.t[0] > 0)


@pytest.mark.parametrize("pause", [5.0, 40_000.0])
def test_no_stretch_lies_in_a_pause_of_the_clock(pause, one_axis):
    usual, fast = [swing(0.05, 0.2, 9.0)] * 12, swing(0.5, 0.3, 4.0)
    long = working(one_axis, [*usual, fast, fast, *usual])
    t = np.where(long.t > 124.5, long.t + pause, long.t)
    paused = long.with_columns(timestamp=t)
    assert (
        len(cut_cells(take_medians(paused), MotionRegressor.of([take_medians(paused)]))) < 300
    )  # a night takes no memory
    parts = thin([paused])
    assert all(np.diff(part.t).max() < 2 * DT for part in parts)
    assert {part.t[0] > 124.5 + pause for part in parts} == {False, True}
    assert lasting(parts) > 0.8 * AFFORDED


def test_no_stretch_lies_where_nothing_moves(one_axis):
    usual = [swing(0.1, 0.5, 9.0)] * 10
    parts = thin([working(one_axis, [*usual, np.zeros(round(150.0 / DT)), *usual])])
    assert all(np.ptp(part["motor.position.j1"]) > 1.0 for part in parts)
    assert len(parts) > 4


def test_the_order_of_recordings_changes_no_stretch(one_axis):
    motions = [[swing(0.1 + 0.02 * k, 0.4, 9.0), swing(0.05, 0.1 * (k + 1), 9.0)] * (k + 1) for k in range(6)]
    logs = [working(one_axis, made, name=f"log {k}", seed=k) for k, made in enumerate(motions)]
    first = {part.header.segment: part for part in thin(logs)}
    second = {part.header.segment: part for part in thin(logs[::-1])}
    assert len(first) > 3
    assert first.keys() == second.keys()
    assert all(part.equals(second[name]) for name, part in first.items())


def test_recordings_in_files_are_thinned_as_those_in_memory(one_axis, tmp_path):
    logs = [working(one_axis, [swing(0.1, 0.3 * k, 9.0)] * 8, name=f"log{k}", seed=k) for k in (1, 2)]
    for log in logs:
        write_recording(log, tmp_path / f"{log.header.segment}.npz")
    stored = thin([Stored(tmp_path / f"log{k}.npz") for k in (1, 2)])
    assert len(stored) > 3
    assert all(one.equals(other) for one, other in zip(stored, thin(logs), strict=True))


def test_slow_rows_can_be_afforded_for_longer():
    assert compute_affordable_time(0.01, 6) > compute_affordable_time(0.004, 6)
    assert compute_affordable_time(0.004, 1) == 6 * compute_affordable_time(0.004, 6)


def test_a_hidden_effect_is_found_in_a_thinned_log(one_axis):
    """Of five minutes that repeat two motions a minute is used, and the diagnosis says so."""
    paths = [
        multisine([0.0], np.full((2, 1), 8.0), [0.4, 1.1], np.full((2, 1), phase), 9.0, name=f"sines {phase}")
        for phase in (0.0, 1.5)
    ]
    machine = Machine(robot=one_axis, effects=(EFFECTS["viscous_level"].on(one_axis, change=0.3),))
    made = simulate([Run(reference=joint_reference(one_axis, path)) for path in paths], machine=machine, record_dt=DT)
    names = ("motor.position.j1", "motor.effort.j1")
    columns = {name: np.concatenate([one[name] for one in made * 15]) for name in names}
    rng = np.random.default_rng(3)
    columns["motor.effort.j1"] = columns["motor.effort.j1"] + rng.normal(scale=0.01, size=len(columns[names[0]]))
    columns["motor.position.j1"] = columns["motor.position.j1"] + rng.normal(scale=2e-5, size=len(columns[names[0]]))
    columns["timestamp"] = DT * np.arange(len(columns[names[0]]))
    long = Recording(columns, replace(made[0].header, segment="long", phases=()))
    diagnosis = diagnose(one_axis, [long])
    (cause,) = diagnosis.causes
    assert cause.effect == "viscous_level"
    low, high = cause.parameters[0].interval
    assert low < 0.3 < high
    assert any(note.startswith("The log was thinned: ") for note in diagnosis.quality)
    assert all(name.startswith("long 0:0") for name in diagnosis.motions)
