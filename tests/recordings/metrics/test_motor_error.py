"""Motor position error: reference minus measured, motor side, while the robot moves."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.recordings import Header, Phase, Recording
from ffgym.recordings.metrics import motor_error, motor_error_rms

T = 0.01 * np.arange(300)
RATIOS = (100.0, -50.0)
PHASES = (
    Phase(label="rest", kind="standstill", start=0.0, end=1.0),
    Phase(label="move", kind="motion", start=1.0, end=2.0),
    Phase(label="rest again", kind="standstill", start=2.0, end=3.0),
)


def recording(errors, side="motor", phases=PHASES):
    """Two joints that are off by `errors`, functions of time."""
    columns = {"timestamp": T}
    for joint, error in zip(("a", "b"), errors, strict=True):
        columns[f"reference.position.{joint}"] = np.sin(T)
        columns[f"motor.position.{joint}"] = np.sin(T) - error(T)
    return Recording(
        columns, Header(robot="two", joints=("a", "b"), gear_ratio=RATIOS, position_side=side, phases=phases)
    )


def test_the_error_is_reference_minus_measured():
    error = motor_error(recording([lambda t: 0 * t + 0.01, lambda t: -0.02 * t]))
    np.testing.assert_allclose(error, np.stack([0 * T + 0.01, -0.02 * T], axis=1), atol=1e-15)


def test_standstill_does_not_count():
    still_wrong = [lambda t: np.where((t >= 1) & (t < 2), 0.01, 5.0), lambda t: np.where((t >= 1) & (t < 2), 0.0, 1.0)]
    np.testing.assert_allclose(motor_error_rms(recording(still_wrong)), [0.01, 0.0], atol=1e-15)


def test_rms_of_a_sine_is_its_amplitude_over_the_square_root_of_two():
    rms = motor_error_rms(recording([lambda t: 0.3 * np.sin(2 * np.pi * t), lambda t: 0.1 * np.cos(4 * np.pi * t)]))
    np.testing.assert_allclose(rms, np.array([0.3, 0.1]) / np.sqrt(2), rtol=1e-12)


def test_rows_outside_any_phase_count_as_motion():
    rms = motor_error_rms(recording([lambda t: 0 * t + 0.5, lambda t: 0 * t + 0.25], phases=()))
    np.testing.assert_allclose(rms, [0.5, 0.25])


def test_angles_on_the_link_side_are_referred_to_the_motor():
    errors = [lambda t: 0 * t + 0.001, lambda t: 0 * t + 0.002]
    np.testing.assert_allclose(motor_error_rms(recording(errors, side="link")), [0.1, 0.1])
    np.testing.assert_allclose(motor_error(recording(errors, side="link"))[0], [0.1, -0.1], atol=1e-12)
    np.testing.assert_allclose(motor_error_rms(recording(errors)), [0.001, 0.002])


def test_a_recording_that_stands_still_all_the_time_is_refused():
    rest = (Phase(label="rest", kind="standstill", start=0.0, end=3.0),)
    with pytest.raises(FFGymError, match="standstill"):
        motor_error_rms(recording([np.sin, np.cos], phases=rest))


def test_a_recording_without_motor_positions_is_refused():
    empty = Recording({"timestamp": T}, Header(robot="two", joints=("a",), gear_ratio=(1.0,)))
    with pytest.raises(FFGymError, match=r"reference\.position"):
        motor_error(empty)


def test_coupled_joints_turn_each_others_motors():
    base = recording([lambda t: 0 * t + 0.001, lambda t: 0 * t + 0.002], side="link")
    coupled = Recording(base.columns, replace(base.header, coupling=((0.0, 3.0), (5.0, 0.0))))
    np.testing.assert_allclose(motor_error(coupled)[0], [0.1 + 3 * 0.002, -0.1 + 5 * 0.001], atol=1e-12)
