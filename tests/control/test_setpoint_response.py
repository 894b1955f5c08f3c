"""Delay and filter of a controller: what reaches the servo, and what to send for it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ffgym.control import SetpointResponse
from ffgym.core.errors import FFGymError

DT = 0.004
T = np.arange(600) * DT
SHARE = np.clip((T - 0.2) / 2.0, 0.0, 1.0)  # at rest first and last, so that all can be sent early
SMOOTH = (np.sin(np.pi * SHARE) ** 4 * np.sin(2 * np.pi * 2 * T))[:, None]


def test_a_response_without_delay_and_filter_changes_nothing() -> None:
    np.testing.assert_allclose(SetpointResponse().apply(SMOOTH, DT), SMOOTH, atol=1e-15)
    np.testing.assert_allclose(SetpointResponse().invert(SMOOTH, DT), SMOOTH, atol=1e-12)


def test_a_delay_of_whole_samples_shifts_them() -> None:
    late = SetpointResponse(delay=3 * DT).apply(SMOOTH, DT)
    np.testing.assert_allclose(late[3:], SMOOTH[:-3], atol=1e-12)
    assert not late[:3].any()


def test_what_begins_or_ends_with_a_speed_rests_before_and_after() -> None:
    ramp = (0.1 + T)[:, None]
    late = SetpointResponse(delay=0.010).apply(ramp, DT)
    np.testing.assert_allclose(late[:3], 0.1, atol=1e-12)
    np.testing.assert_allclose(late[3], 0.102, atol=1e-12)
    sent = SetpointResponse(delay=0.010, lag=0.005).invert(ramp, DT)
    np.testing.assert_allclose(sent[-2:], ramp[-1:].repeat(2, axis=0), atol=1e-12)
    assert sent[-4, 0] == pytest.approx(ramp[-4, 0] + 0.015)


@pytest.mark.parametrize("damping", [None, 0.71, 1.0])
def test_a_filter_passes_a_sine_as_its_formula_says(damping: float | None) -> None:
    frequency = 2 * np.pi * 5.0
    response = SetpointResponse.low_pass(10.0, delay=0.0062, damping=damping)
    wave = np.sin(frequency * T)[:, None]
    passed = response.apply(wave, DT)[300:, 0]
    s = 1j * frequency
    gain = np.exp(-s * response.delay) / (1 + response.lag * s + response.curvature * s**2)
    wanted = np.imag(gain * np.exp(s * T[300:]))
    np.testing.assert_allclose(passed, wanted, atol=3e-3)  # straight lines between samples lose 2e-3


@given(st.floats(0.0, 0.03), st.floats(5.0, 40.0), st.sampled_from([None, 0.5, 0.71, 1.0]))
@settings(max_examples=50, deadline=None)
def test_what_is_sent_for_a_motion_makes_it_arrive(delay: float, cutoff: float, damping: float | None) -> None:
    response = SetpointResponse.low_pass(cutoff, delay=delay, damping=damping)
    arrived = response.apply(response.invert(SMOOTH, DT), DT)
    assert np.abs(arrived - SMOOTH).max() < 0.005 * np.abs(SMOOTH).max()


def test_what_is_not_compensated_arrives_late() -> None:
    response = SetpointResponse.low_pass(20.0, delay=0.008)
    lag = np.abs(response.apply(SMOOTH, DT) - SMOOTH).max()
    speed = np.abs(np.diff(SMOOTH, axis=0)).max() / DT
    assert lag == pytest.approx(response.total_delay * speed, rel=0.1)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"delay": -0.001}, "delay of set-points = -0.001 s"),
        ({"delay": 11.7}, "delay of set-points = 11.7 s is out of range"),  # meant in ms
        ({"delay": 0.0117, "lag": 8.0}, "lag of set-points = 8.0 s is out of range"),
        ({"curvature": 1e-4}, "rings for ever"),
    ],
)
def test_a_response_that_cannot_be_is_refused(change: dict, message: str) -> None:
    with pytest.raises(FFGymError, match=message):
        SetpointResponse(**change)


def test_a_response_says_what_it_is() -> None:
    assert SetpointResponse(delay=0.008).describe() == "delay 8.00 ms, no filter"
    assert "first-order filter at 20.0 Hz" in SetpointResponse.low_pass(20.0).describe()
    assert "second-order filter at 20.0 Hz with damping 0.71" in SetpointResponse.low_pass(20, damping=0.71).describe()
