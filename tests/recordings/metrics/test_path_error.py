"""Path error of tools whose deviation from the circle is known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_recordings import CENTRE, NORMAL, RADIUS, REST, RUN, angles, circle_recording, clock, on_circle, phases

from ffgym.core.errors import FFGymError
from ffgym.recordings import Phase
from ffgym.recordings.metrics import Circle, circle_deviation, path_errors, standstill_offset

microns = st.floats(-200e-6, 200e-6)


def only(recording):
    (error,) = path_errors(recording)
    return error


@settings(max_examples=30)
@given(outward=microns, height=microns)
def test_a_constant_deviation_is_its_own_rms_and_maximum(outward, height):
    error = only(circle_recording(outward, height))
    assert error.rms == pytest.approx(abs(outward), abs=1e-13)
    assert error.max == pytest.approx(abs(outward), abs=1e-13)
    assert error.rms_3d == pytest.approx(np.hypot(outward, height), abs=1e-13)
    assert error.max_3d == pytest.approx(np.hypot(outward, height), abs=1e-13)


@settings(max_examples=30)
@given(size=st.floats(1e-6, 200e-6), waves=st.integers(1, 9), height=microns)
def test_a_wavy_deviation_has_the_rms_of_a_sine(size, waves, height):
    error = only(circle_recording(lambda angle: size * np.sin(waves * angle), height))
    assert error.rms == pytest.approx(size / np.sqrt(2), rel=1e-9)
    assert error.max == pytest.approx(size, rel=1e-3)
    assert error.rms_3d == pytest.approx(np.sqrt(size**2 / 2 + height**2), rel=1e-9)
    assert error.max_3d == pytest.approx(np.hypot(size, height), rel=1e-3)


@settings(max_examples=30)
@given(st.tuples(microns, microns, microns))
def test_the_offset_at_standstill_is_removed(offset):
    recording = circle_recording(50e-6, offset=offset)
    np.testing.assert_allclose(standstill_offset(recording), offset, atol=1e-15)
    assert only(recording).rms == pytest.approx(50e-6, abs=1e-14)


@pytest.mark.parametrize("lag", [0.0, 0.004, 0.05])
def test_a_tool_that_is_late_on_the_right_path_makes_no_error(lag):
    assert only(circle_recording(lag=lag)).max_3d < 1e-13


def test_a_tool_that_cuts_the_corner_makes_an_error():
    assert only(circle_recording(-80e-6)).max == pytest.approx(80e-6)


def test_label_radius_and_speed_are_those_of_the_reference():
    error = only(circle_recording(100e-6))
    assert error.label == "circle 5 mm"
    assert error.radius == pytest.approx(RADIUS, rel=1e-12)
    assert error.speed == pytest.approx(2 * np.pi * RADIUS / RUN, rel=1e-12)


def test_rows_that_the_tracker_missed_are_ignored():
    whole = circle_recording(lambda angle: 70e-6 * np.sin(3 * angle))
    gaps = {f"tcp.position.{axis}": whole[f"tcp.position.{axis}"].copy() for axis in "xyz"}
    for column in gaps.values():
        column[::2] = np.nan
    gaps["tcp.position.y"][1::4] = np.nan  # one axis alone
    error = only(whole.with_columns(gaps))
    assert error.rms == pytest.approx(only(whole).rms, rel=1e-3)


def test_what_happens_off_the_circles_does_not_count():
    wild = circle_recording()
    x = wild["tcp.position.x"].copy()
    x[np.isclose(wild.t, REST + RUN)] += 0.1  # the first row after the circle
    assert only(wild.with_columns({"tcp.position.x": x})).max_3d < 1e-13


def test_a_circle_without_a_single_tracker_row_is_refused():
    whole = circle_recording()
    lost = {f"tcp.position.{a}": np.where(whole.t >= REST, np.nan, whole[f"tcp.position.{a}"]) for a in "xyz"}
    with pytest.raises(FFGymError, match="circle 5 mm"):
        path_errors(whole.with_columns(lost))


def test_a_standstill_without_a_single_tracker_row_is_refused():
    whole = circle_recording()
    lost = {f"tcp.position.{a}": np.where(whole.t < REST, np.nan, whole[f"tcp.position.{a}"]) for a in "xyz"}
    with pytest.raises(FFGymError, match="standstill"):
        path_errors(whole.with_columns(lost))


def test_a_recording_without_circle_is_refused():
    with pytest.raises(FFGymError, match="'drawn circle' has no phase of kind 'circle'"):
        path_errors(circle_recording(phases=phases()[:1]))


@pytest.mark.parametrize("order", [(1,), (1, 0)])
def test_a_recording_without_standstill_before_its_circle_is_refused(order):
    circle = Phase(label="circle 5 mm", kind="circle", start=0.0, end=REST + RUN / 2)
    rest = Phase(label="rest", kind="standstill", start=1.0, end=1.1)
    with pytest.raises(FFGymError, match="no standstill before its first circle"):
        path_errors(circle_recording(phases=tuple((rest, circle)[i] for i in order)))


@pytest.mark.parametrize("family", ["tcp.position", "tcp_reference.position"])
def test_a_recording_without_tool_is_refused(family):
    missing = {f"{family}.{axis}": None for axis in "xyz"}
    with pytest.raises(FFGymError, match=family):
        path_errors(circle_recording(columns=missing))


def test_a_circle_whose_reference_is_a_line_is_refused():
    t = clock()
    with pytest.raises(FFGymError, match="no circle"):
        path_errors(circle_recording(columns={"tcp_reference.position.y": 0.0 * t, "tcp_reference.position.x": t}))


def test_each_circle_is_scored_on_its_own():
    half = REST + RUN / 2
    two = (
        phases()[0],
        Phase(label="first", kind="circle", start=REST, end=half),
        Phase(label="second", kind="circle", start=half, end=REST + RUN),
    )
    recording = circle_recording(lambda angle: np.where(angle < np.pi - 1e-9, 10e-6, 30e-6), phases=two)
    first, second = path_errors(recording)
    assert (first.label, second.label) == ("first", "second")
    assert first.rms == pytest.approx(10e-6, rel=1e-6)
    assert second.rms == pytest.approx(30e-6, rel=1e-6)


@given(radius=st.floats(0.0, 0.02), angle=st.floats(-10.0, 10.0), height=st.floats(-0.01, 0.01))
def test_deviation_is_outward_from_the_circle_and_along_its_normal(radius, angle, height):
    circle = Circle(centre=CENTRE, normal=NORMAL, radius=RADIUS)
    outward, up = circle_deviation(on_circle(np.array([angle]), radius, height), circle)
    assert outward[0] == pytest.approx(radius - RADIUS, abs=1e-15)
    assert up[0] == pytest.approx(height, abs=1e-15)
    assert angles(np.array([REST]))[0] == 0
