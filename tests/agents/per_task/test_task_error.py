"""Errors at the control samples, from recordings at any rate, noisy or with holes."""

import numpy as np
import pytest

from ffgym.agents.torque_response import at_samples, circle_rms, rms, task_error
from ffgym.core.errors import FFGymError
from ffgym.recordings.metrics import motor_error, path_errors, standstill_offset
from ffgym.simulation import LaserTracker, Run, simulate
from ffgym.studies import circle_references


@pytest.fixture(scope="module")
def reference(arm):
    return circle_references(arm, ["p1"], [0.1], [0.001, 0.003])["p1", 0.1]


@pytest.fixture(scope="module")
def recording(arm, reference):
    return simulate([Run(reference=reference)], arm=arm)[0]


def test_a_straight_line_comes_back_as_it_is(reference, recording):
    line = np.stack([3.0 - 2.0 * recording.t, 0.5 * recording.t], axis=1)
    found = at_samples(line, recording, reference)
    inner = slice(1, -1)  # at the ends there is nothing beyond
    np.testing.assert_allclose(found[inner], np.stack([3.0 - 2.0 * reference.t, 0.5 * reference.t], axis=1)[inner])


def test_a_recording_at_the_control_rate_is_taken_as_it_is(arm, reference):
    (slow,) = simulate([Run(reference=reference)], arm=arm, record_dt=0.004)
    np.testing.assert_array_equal(task_error(slow, reference, "motor"), motor_error(slow))


def test_rows_that_the_tracker_missed_lie_between_their_neighbours(reference, recording):
    line = (2.0 * recording.t)[:, None]
    holes = np.where(np.arange(len(line))[:, None] % 10 == 0, line, np.nan)
    inner = slice(1, -3)
    np.testing.assert_allclose(at_samples(holes, recording, reference)[inner, 0], 2.0 * reference.t[inner])
    with pytest.raises(FFGymError, match="no row in which the TCP was seen"):
        at_samples(np.full_like(line, np.nan), recording, reference)


def test_noise_is_averaged(reference, recording):
    noise = np.random.default_rng(0).normal(size=(len(recording.t), 1))
    assert np.std(at_samples(noise, recording, reference)) < 0.5


def test_the_error_of_the_tool_is_its_reference_less_what_was_measured(reference, recording):
    offset = standstill_offset(recording)
    exact = recording.vector("tcp_reference.position") - (recording.vector("tcp.position") - offset)
    found = task_error(recording, reference, "tcp")
    np.testing.assert_allclose(found, exact[::4], atol=0.02 * np.abs(exact).max())  # averaged over 8 ms
    assert np.abs(found[:10]).max() < 1e-9  # it begins at rest


def test_a_tracker_at_its_own_rate_shows_the_same_error(arm, reference, recording):
    tracker = LaserTracker(noise=0.0, period=0.01)
    (tracked,) = simulate([Run(reference=reference)], arm=arm, sensors=[tracker])
    exact = task_error(recording, reference, "tcp")
    assert rms(task_error(tracked, reference, "tcp") - exact) < 0.1 * rms(exact)  # straight lines of 10 ms


def test_errors_are_told_circle_by_circle(reference, recording):
    error = task_error(recording, reference, "tcp")
    told = circle_rms(error, reference)
    scored = {e.label: e for e in path_errors(recording)}
    assert list(told) == list(scored) == ["circle 1 mm", "circle 3 mm"]
    for label, value in told.items():
        assert value >= 0.98 * scored[label].rms_3d  # the nearest point of the circle is no farther than the due one


def test_a_recording_of_another_motion_is_refused(arm, recording):
    other = circle_references(arm, ["p1"], [0.04], [0.001])["p1", 0.04]
    with pytest.raises(FFGymError, match="is none of the motion 'p1, 40 mm/s'"):
        task_error(recording, other, "motor")
