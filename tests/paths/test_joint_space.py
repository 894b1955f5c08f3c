"""Joint-space motions: the sine of the one-axis test, and constant speed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from path_samples import magnitudes

from ffgym.paths import constant_velocity, joint_sine

few = settings(max_examples=20)
rates = st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=4)


def central(values, dt):
    return (values[2:] - values[:-2]) / (2 * dt)


@few
@given(amplitude=rates, frequency=magnitudes(0.01, 100.0), periods=st.floats(0.5, 3.0), shift=st.floats(-3.0, 3.0))
def test_the_sine_has_its_amplitude_frequency_and_derivatives(amplitude, frequency, periods, shift):
    duration, centre = periods / frequency, np.full(len(amplitude), shift)
    path = joint_sine(amplitude, frequency, duration, centre=centre, dt=duration / 2000)
    dt, size, omega = path.t[1], np.abs(amplitude).max(), 2 * np.pi * frequency
    np.testing.assert_allclose(
        path.q - centre, np.outer(np.sin(omega * path.t), amplitude), atol=1e-12 * (size + abs(shift))
    )
    tolerance = 2e-4 * size + 1e-11
    np.testing.assert_allclose(central(path.q, dt), path.dq[1:-1], rtol=0, atol=tolerance * omega)
    np.testing.assert_allclose(central(path.dq, dt), path.ddq[1:-1], rtol=0, atol=tolerance * omega**2)
    assert path.q.shape == (len(path.t), len(amplitude))
    assert path.t[-1] >= duration * (1 - 1e-9)


def test_the_sine_of_the_thesis_starts_at_full_speed():
    path = joint_sine([1.0], 3.0, 10.0)
    assert path.q[0, 0] == 0
    assert path.dq[0, 0] == pytest.approx(6 * np.pi)
    assert [(p.label, p.kind, p.start, p.end) for p in path.phases] == [("sine 3 Hz", "motion", 0.0, 10.0)]


@few
@given(
    velocity=rates.filter(any),
    duration=magnitudes(0.05, 10.0),
    ramp=magnitudes(0.05, 2.0),
    dwell=magnitudes(0.05, 1.0),
    start=st.floats(-3.0, 3.0),
)
def test_constant_velocity_is_constant_smooth_and_at_rest_at_both_ends(velocity, duration, ramp, dwell, start):
    dt, first = 1e-3, np.full(len(velocity), start)
    path = constant_velocity(velocity, duration, start=first, ramp=ramp, dwell=dwell, dt=dt)
    size = np.abs(velocity).max()
    jerk = 6 * size / ramp**2
    np.testing.assert_allclose(central(path.q, dt), path.dq[1:-1], rtol=0, atol=jerk * dt**2 + 1e-11)
    np.testing.assert_allclose(central(path.dq, dt), path.ddq[1:-1], rtol=0, atol=jerk * dt + 1e-11)
    assert np.abs(np.diff(path.ddq, axis=0)).max() <= jerk * dt * (1 + 1e-6) + 1e-13
    run = next(p for p in path.phases if p.kind == "motion")
    rows = (path.t > run.start + 1e-9) & (path.t < run.end - 1e-9)
    np.testing.assert_array_equal(path.dq[rows], np.tile(velocity, (rows.sum(), 1)))
    for row, at in ((0, first), (-1, first + np.array(velocity) * (duration + ramp))):
        np.testing.assert_allclose(path.q[row], at, rtol=1e-12, atol=1e-12)
        np.testing.assert_array_equal(path.dq[row], 0)
    durations = [p.end - p.start for p in path.phases]
    np.testing.assert_allclose(durations, [dwell, ramp, duration, ramp, dwell], rtol=1e-9)
    assert [p.kind for p in path.phases] == ["standstill", "lead_in", "motion", "lead_out", "standstill"]


@few
@given(velocity=rates.filter(any), duration=magnitudes(0.1, 2.0))
def test_running_backwards_is_the_mirror_image(velocity, duration):
    forth = constant_velocity(velocity, duration)
    back = constant_velocity([-v for v in velocity], duration)
    np.testing.assert_array_equal(back.q, -forth.q)
    np.testing.assert_array_equal(back.ddq, -forth.ddq)
