"""Contour error and lag of tools whose deviation from the path is known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_recordings import CENTRE, DT, RADIUS, REST, RUN, circle_recording, phases

from ffgym.core.errors import FFGymError
from ffgym.recordings import Header, Phase, Recording
from ffgym.recordings.metrics import Contour, contour_errors, path_errors, start_offset
from ffgym.recordings.metrics.contour import WHOLE

microns = st.floats(-200e-6, 200e-6)
SPEED = 2 * np.pi * RADIUS / RUN


def drawn(reference, tcp, phases=(), dt=DT, **changes):
    """Recording of a tool at `tcp` (T, 3) whose reference is at `reference` (T, 3) [m]."""
    columns = {"timestamp": dt * np.arange(len(reference))}
    for k, axis in enumerate("xyz"):
        columns |= {f"tcp.position.{axis}": tcp[:, k], f"tcp_reference.position.{axis}": reference[:, k]}
    header = Header(robot="drawn", joints=("j1",), gear_ratio=(100.0,), segment="drawn path", phases=phases, **changes)
    return Recording(columns, header)


def line(length=1000, speed=0.1, dt=DT):
    """Points (T, 3) of a straight run along (3, 0, 4) / 5."""
    return np.outer(speed * dt * np.arange(length), [0.6, 0.0, 0.8])


@settings(max_examples=20, deadline=None)
@given(outward=microns, height=microns)
def test_a_constant_deviation_from_a_circle_is_the_distance_in_space(outward, height):
    whole, circle = contour_errors(circle_recording(outward, height))
    assert (whole.label, circle.label) == (WHOLE, "circle 5 mm")
    # the reference stands still before its circle, so that its curve has a corner in time; 0.2 um is what that costs
    assert circle.max == pytest.approx(np.hypot(outward, height), abs=2e-7)
    assert circle.rms == pytest.approx(np.hypot(outward, height), abs=2e-8)


def test_on_circles_it_agrees_with_the_path_error_of_the_thesis():
    recording = circle_recording(lambda angle: 100e-6 * np.sin(3 * angle), lambda angle: 30e-6 * np.cos(angle))
    (circle,) = path_errors(recording)
    assert contour_errors(recording)[1].rms == pytest.approx(circle.rms_3d, rel=2e-3)
    assert contour_errors(recording)[1].max == pytest.approx(circle.max_3d, rel=2e-3)


@pytest.mark.parametrize("lag", [0.004, 0.02, 0.04])
def test_a_tool_that_is_late_on_the_right_path_has_lag_and_no_contour_error(lag):
    circle = contour_errors(circle_recording(lag=lag))[1]
    assert circle.max < 2e-7
    assert circle.lag_max == pytest.approx(RADIUS * np.sin(2 * np.pi * lag / RUN), rel=1e-3)


def test_a_tool_that_is_later_than_the_window_is_charged_for_it():
    late = circle_recording(lag=0.04)
    assert Contour.of(late, window=0.01).distance.max() == pytest.approx(0.03 * SPEED, rel=0.05)


@pytest.mark.parametrize("late", [-0.003, 0.0, 0.003])
def test_along_a_line_contour_and_lag_are_the_two_legs_of_the_error(late):
    reference = line()
    across = np.array([0.8, 0.0, -0.6])
    tcp = reference + 2e-4 * across - late * 0.1 * np.array([0.6, 0.0, 0.8])
    tcp[0] = reference[0]  # where it starts without offset
    contour = Contour.of(drawn(reference, tcp))
    inside = slice(10, -10)
    np.testing.assert_allclose(contour.error[inside], 2e-4 * np.tile(across, (980, 1)), atol=1e-12)
    np.testing.assert_allclose(contour.lag[inside], late * 0.1, atol=1e-12)


def test_a_path_that_crosses_itself_later_is_not_taken_for_the_present_one():
    t = np.linspace(0, 2 * np.pi, 4001)
    eight = np.stack([0.05 * np.sin(t), 0.05 * np.sin(2 * t), 0 * t], axis=1)
    crossing = np.argmin(np.abs(t - np.pi))
    velocity = np.gradient(eight, axis=0)
    across = np.cross([0.0, 0.0, 1.0], velocity / np.linalg.norm(velocity, axis=1, keepdims=True))
    tcp = eight + 5e-4 * across
    tcp[0] = eight[0]
    contour = Contour.of(drawn(eight, tcp))
    # at the crossing the other branch comes within 0, and is 2 s away
    np.testing.assert_allclose(contour.distance[crossing - 200 : crossing + 200], 5e-4, rtol=1e-3)


def test_running_back_along_the_same_line_keeps_the_sign_of_the_lag():
    there = line()
    reference = np.concatenate([there, there[::-1]])
    tcp = np.concatenate([np.repeat(there[:1], 5, axis=0), reference[:-5]])
    contour = Contour.of(drawn(reference, tcp))
    assert contour.distance.max() < 1e-4 / 2  # half a step at the reversal
    assert contour.lag[100:900] == pytest.approx(5e-4, rel=1e-9)
    assert contour.lag[1100:1900] == pytest.approx(5e-4, rel=1e-9)


@settings(max_examples=20, deadline=None)
@given(st.tuples(microns, microns, microns))
def test_the_offset_at_the_first_standstill_is_removed(offset):
    recording = circle_recording(50e-6, offset=offset)
    np.testing.assert_allclose(start_offset(recording), offset, atol=1e-15)
    assert contour_errors(recording)[1].rms == pytest.approx(50e-6, abs=2e-8)


def test_without_a_standstill_the_offset_is_that_of_the_first_row_that_was_seen():
    reference = line()
    tcp = reference + np.array([1e-3, 2e-3, 3e-3])
    tcp[:3] = np.nan
    recording = drawn(reference, tcp)
    np.testing.assert_allclose(start_offset(recording), [1e-3, 2e-3, 3e-3], atol=1e-15)
    contour = Contour.of(recording)
    assert contour.rows[0] == 3
    assert contour.distance.max() < 1e-12


def test_rows_that_the_tracker_missed_do_not_count():
    whole = circle_recording(lambda angle: 70e-6 * np.sin(3 * angle))
    gaps = {f"tcp.position.{axis}": np.where(np.arange(len(whole)) % 4, np.nan, whole[f"tcp.position.{axis}"])
            for axis in "xyz"}  # fmt: skip
    seen = Contour.of(whole.with_columns(gaps))
    assert len(seen.rows) == -(-len(whole) // 4)
    every = Contour.of(whole)
    np.testing.assert_array_equal(seen.distance, every.distance[::4])


def test_slow_rows_do_not_cut_the_curve_short():
    """Recorded every 4 ms at 100 mm/s the chords of a 1 mm circle leave it by 20 um; the curve between does not."""
    angle = 100 * 0.004 * np.arange(16)
    circle = 1e-3 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    between = 1e-3 * np.stack([np.cos(angle + 0.2), np.sin(angle + 0.2), 0 * angle], axis=1)
    between[0] = circle[0]
    assert Contour.of(drawn(circle, between, dt=0.004)).distance[3:-3].max() < 0.5e-6


def test_figures_are_those_of_each_phase_and_standstill_counts_nowhere():
    reference = line()
    tcp = reference.copy()
    tcp[400:600, 1] += 1e-4
    tcp[600:, 1] += 3e-4
    parts = [("wait", "standstill", 0.0, 0.4), ("one", "motion", 0.4, 0.6), ("two", "lead_out", 0.6, 1.0)]
    named = tuple(Phase(label=a, kind=k, start=s, end=e) for a, k, s, e in parts)
    whole, one, two = contour_errors(drawn(reference, tcp, named))
    assert [(e.label, e.start, e.end) for e in (one, two)] == [("one", 0.4, 0.6), ("two", 0.6, 1.0)]
    assert (one.rms, two.rms) == (pytest.approx(1e-4), pytest.approx(3e-4))
    assert whole.rms == pytest.approx(np.sqrt((200 * 1e-8 + 400 * 9e-8) / 600))


def test_a_recording_without_phases_counts_as_one_motion():
    reference = line()
    (whole,) = contour_errors(drawn(reference, reference))
    assert (whole.label, whole.max) == (WHOLE, pytest.approx(0.0, abs=1e-12))
    assert (whole.start, whole.end) == (0.0, pytest.approx(0.999))


def test_a_recording_that_only_rests_is_refused():
    with pytest.raises(FFGymError, match="'drawn circle' shows no TCP in motion"):
        contour_errors(circle_recording().slice(end=REST))


def test_a_recording_in_which_the_tool_is_never_seen_is_refused():
    reference = line()
    with pytest.raises(FFGymError, match="no TCP position in any row"):
        contour_errors(drawn(reference, np.full_like(reference, np.nan)))


@pytest.mark.parametrize("window", [-0.1, np.nan, "long"])
def test_a_window_that_is_no_time_is_refused(window):
    with pytest.raises(FFGymError, match="window"):
        Contour.of(circle_recording(), window)


def test_the_nearest_point_lies_on_the_path():
    contour = Contour.of(circle_recording(80e-6))
    distance = np.linalg.norm(contour.nearest - CENTRE, axis=1)
    np.testing.assert_allclose(distance, RADIUS, atol=2e-7)
    assert phases()[0].kind == "standstill"
