"""Tables with times as paths in time: derivatives belong to each other, and nothing moves after the end."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ffgym.paths.motions.table_part import MotionTable, follow_table

DT = 1e-4


def path_of(t, positions, rotations, dt=DT):
    table = MotionTable(t=t, positions=positions, rotations=rotations.as_matrix(), joints=None)
    return follow_table(table, t, "rows")(None, dt)


@pytest.fixture(scope="module")
def tumbling():
    """Two turns about an axis that wanders, in uneven steps of up to 60 deg."""
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.uniform(0.05, 0.1, 25))
    t -= t[0]
    every = [Rotation.from_rotvec(rng.normal(size=3))]
    for step in rng.uniform(0.1, 1.0, 24):
        axis = np.array([0.3, 0.4, 1.0]) + 0.3 * rng.normal(size=3)
        every.append(Rotation.from_rotvec(step * axis / np.linalg.norm(axis)) * every[-1])
    return t, rng.normal(size=(25, 3)), Rotation.concatenate(every)


def test_every_row_is_met_in_position_and_orientation(tumbling):
    t, positions, rotations = tumbling
    path = path_of(t, positions, rotations)
    rows = np.round(t[:-1] / DT).astype(int)
    away = (Rotation.from_matrix(path.rotation[rows]) * rotations[:-1].inv()).magnitude()
    reach = np.linalg.norm(path.angular_velocity[rows], axis=1) * DT
    assert np.all(away <= reach + 1e-9)
    speed = np.linalg.norm(path.velocity[rows], axis=1) * DT
    assert np.all(np.linalg.norm(path.position[rows] - positions[:-1], axis=1) <= speed + 1e-9)


def test_angular_rates_are_the_derivatives_of_the_orientation_in_world_axes(tumbling):
    path = path_of(*tumbling)
    turns = Rotation.from_matrix(path.rotation)
    rate = (turns[2:] * turns[:-2].inv()).as_rotvec() / (2 * DT)
    np.testing.assert_allclose(path.angular_velocity[1:-1], rate, atol=1e-4 * np.abs(rate).max())
    change = (path.angular_velocity[2:] - path.angular_velocity[:-2]) / (2 * DT)
    np.testing.assert_allclose(path.angular_acceleration[1:-1], change, atol=1e-2 * np.abs(change).max())
    assert np.abs(np.diff(path.angular_acceleration, axis=0)).max() < 1e-2 * np.abs(change).max()


def test_a_table_that_ends_at_rest_rests_at_its_last_row_until_the_next_sample():
    t = np.linspace(0, 1.0, 51)
    swing = np.sin(np.pi * t / 2) ** 2
    turns = Rotation.from_rotvec(np.outer(swing, [0.0, 0.2, 0.0]))
    path = path_of(t, np.outer(swing, [1.0, 0.0, 0.0]), turns, dt=0.03)
    assert path.t[-1] == pytest.approx(1.02)
    np.testing.assert_allclose(path.position[-1], [1, 0, 0], atol=1e-12)
    for still in (path.velocity, path.acceleration, path.angular_velocity, path.angular_acceleration):
        np.testing.assert_array_equal(still[-1], 0)
        assert np.abs(still[-2]).max() > 0


def test_what_moves_at_its_end_in_orientation_alone_ends_with_the_sample_before():
    t = np.linspace(0, 1.0, 51)
    turns = Rotation.from_rotvec(np.outer(t, [0.0, 0.2, 0.0]))
    path = path_of(t, np.zeros((51, 3)), turns, dt=0.03)
    assert path.t[-1] == pytest.approx(0.99)
    np.testing.assert_allclose(path.angular_velocity, np.tile([0, 0.2, 0], (34, 1)), atol=1e-6)
