"""A move begins where a motor turns, and where it starts after a rest; a stop to turn is no rest."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffgym.diagnosis.measured import since_move
from ffgym.diagnosis.regimes import DWELL, REST

DT = 0.01


def moved(*pieces):
    """Angle and speed (T, 1) of pieces (speed, duration)."""
    speed = np.concatenate([np.full(round(duration / DT), v) for v, duration in pieces])[:, None]
    return np.cumsum(speed, axis=0) * DT, speed


def test_a_restart_in_the_same_direction_begins_anew_and_knows_its_rest():
    travel, stood = since_move(*moved((1.0, 1.0), (0.0, 0.5), (1.0, 1.0)), DT)
    assert travel[99] == pytest.approx(0.99)
    assert travel[150] == 0.0
    assert travel[-1] == pytest.approx(0.99)
    assert stood[99] == 0.0
    np.testing.assert_allclose(stood[150:], 0.5)


def test_a_motor_that_stops_to_turn_begins_anew_and_has_not_stood():
    travel, stood = since_move(*moved((1.0, 1.0), (0.0, DWELL / 2), (-1.0, 1.0)), DT)
    assert travel[-1] == pytest.approx(0.99)
    assert np.all(stood == 0.0)


def test_a_moment_of_standing_within_a_move_changes_nothing():
    travel, stood = since_move(*moved((1.0, 1.0), (0.0, DWELL / 2), (1.0, 1.0)), DT)
    assert travel[-1] == pytest.approx(1.99)
    assert np.all(stood == 0.0)


def test_a_record_that_begins_at_rest_counts_that_rest():
    travel, stood = since_move(*moved((0.0, 1.0), (-2.0, 0.5)), DT)
    assert travel[-1] == pytest.approx(0.98)
    np.testing.assert_allclose(stood[100:], 1.0)
    assert np.all(stood[:100] == 0.0)


@given(st.lists(st.tuples(st.sampled_from([-3.0, -1.0, 0.0, 0.9 * REST, 1.0]), st.integers(1, 60)), min_size=1))
def test_what_a_loop_over_samples_finds_is_found(pieces):
    angle, speed = moved(*((v, n * DT) for v, n in pieces))
    travel, stood = since_move(np.hstack([angle, -2 * angle]), np.hstack([speed, -2 * speed]), DT)
    began, last, still, before = 0, 0.0, 0, 0.0
    for k, v in enumerate(speed[:, 0]):
        if abs(v) < REST:
            still += 1
        else:
            if np.sign(v) != last or still * DT >= DWELL:
                began, before = k, still * DT if still * DT >= DWELL else 0.0
            last, still = np.sign(v), 0
        assert travel[k, 0] == pytest.approx(abs(angle[k, 0] - angle[began, 0]))
        assert stood[k, 0] == pytest.approx(before)
