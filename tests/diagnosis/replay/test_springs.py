"""Driven springs against a stiff solver."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ffgym.diagnosis.replay.springs import FlownAwayError, Springs
from ffgym.diagnosis.settings import settings

MASS = np.array([[8.0, 1.5], [1.5, 2.0]])
STIFFNESS = np.array([2e4, 1e4])
DAMPING = np.array([20.0, 8.0])
DT = 0.00025


def springs(n, stiffness=STIFFNESS):
    return Springs(mass=np.broadcast_to(MASS, (n, 1, 2, 2)), stiffness=stiffness, damping=DAMPING, dt=DT)


def load(t):
    return np.stack([50 + 30 * np.sin(9 * t), 20 * np.cos(17 * t)], axis=-1)


@pytest.fixture(scope="module")
def solved():
    """Deflection (T, 2) by a solver of high order."""
    t = DT * np.arange(3200)

    def slope(at, y):
        return np.concatenate([y[2:], np.linalg.solve(MASS, load(at) - DAMPING * y[2:] - STIFFNESS * y[:2])])

    start = np.concatenate([load(0.0) / STIFFNESS, np.zeros(2)])
    return t, solve_ivp(slope, (0, t[-1]), start, t_eval=t, rtol=1e-9, atol=1e-12).y.T


def test_springs_bend_as_a_solver_of_high_order_says(solved):
    t, expected = solved
    found = springs(len(t)).bent_by(load(t)[:, None, :, None])
    size = np.abs(expected[:, :2]).max()
    assert np.abs(found.angle[:, 0, :, 0] - expected[:, :2]).max() < 2e-3 * size
    assert np.abs(found.rate[:, 0, :, 0] - expected[:, 2:]).max() < 5e-3 * np.abs(expected[:, 2:]).max()


def test_the_error_falls_with_the_square_of_the_step(solved):
    t, expected = solved
    fine = springs(len(t))

    def error(every):
        found = fine.coarser(every).bent_by(load(t[::every])[:, None, :, None])
        return np.abs(found.angle[:, 0, :, 0] - expected[::every, :2]).max()

    assert 3.0 < error(4) / error(2) < 5.0


def test_many_loads_at_once_bend_as_each_alone(solved):
    t, _ = solved
    one = springs(len(t)).bent_by(load(t)[:, None, :, None])
    for factors in ([1, -2], [1, -2, 3, 4, 5]):  # motion by motion, and step by step
        both = springs(len(t)).bent_by(load(t)[:, None, :, None] * np.array(factors))
        for own, factor in zip(np.moveaxis(both.angle, -1, 0), factors, strict=True):
            np.testing.assert_allclose(own, factor * one.angle[..., 0], atol=1e-13)


@pytest.mark.parametrize("n_loads", [2, 5])
def test_deflections_in_the_place_of_the_loads_are_the_same(solved, n_loads):
    torque = load(solved[0])[:, None, :, None] * np.arange(1.0, n_loads + 1)
    expected = springs(len(torque)).bent_by(torque)
    angle, rate = springs(len(torque)).bend_in_place(torque.copy())
    assert angle.tobytes() == expected.angle.tobytes()
    assert rate.tobytes() == expected.rate.tobytes()


def test_steps_that_are_kept_bend_springs_as_new_ones(solved):
    torque = load(solved[0])[:, None]
    start, kept = torque[0] / STIFFNESS, springs(len(torque))
    found = [kept.integrate(torque, None, start).angle for _ in range(3)]
    assert found[0].any()
    assert all(np.array_equal(one, found[0]) for one in found[1:])


def test_poses_that_change_are_followed_as_a_solver_of_high_order_says():
    """Steps are made of poses 8 ms apart, 32 steps here, and of cubics between them."""
    t = DT * np.arange(3200)

    def mass(at):
        return MASS * (1 + 0.4 * np.sin(6 * at))

    def slope(at, y):
        return np.concatenate([y[2:], np.linalg.solve(mass(at), load(at) - DAMPING * y[2:] - STIFFNESS * y[:2])])

    start = np.concatenate([load(0.0) / STIFFNESS, np.zeros(2)])
    expected = solve_ivp(slope, (0, t[-1]), start, t_eval=t, rtol=1e-9, atol=1e-12).y.T[:, :2]
    moving = Springs(mass=np.stack([mass(at)[None] for at in t]), stiffness=STIFFNESS, damping=DAMPING, dt=DT)
    for loads in (1, 4):
        torque = np.repeat(load(t)[:, None, :, None], loads, axis=-1)
        found = moving.bent_by(torque).angle[:, 0, :, -1]
        assert np.abs(found - expected).max() < 2e-3 * np.abs(expected).max()


def test_a_constant_load_stays_at_rest():
    found = springs(200).bent_by(np.broadcast_to(np.array([50.0, -20.0])[:, None], (200, 1, 2, 1)))
    np.testing.assert_allclose(found.angle[-1, 0, :, 0], [50.0 / 2e4, -20.0 / 1e4], rtol=1e-9)
    np.testing.assert_allclose(found.rate, 0.0, atol=1e-12)


def test_rigid_joints_do_not_bend():
    found = springs(100, np.array([np.inf, 1e4])).bent_by(load(DT * np.arange(100))[:, None, :, None])
    assert not found.angle[:, :, 0].any()
    assert found.angle[:, :, 1].any()


def test_a_push_that_is_a_spring_is_a_stiffer_spring(solved):
    t, _ = solved
    more = np.array([3e3, 0.0])
    n, torque = len(t), load(t)[:, None]
    stiffer = springs(n, STIFFNESS + more).bent_by(torque[..., None])
    pushed = springs(n).integrate(torque, lambda k, angle, rate: -more * angle, torque[0] / (STIFFNESS + more))
    size = np.abs(stiffer.angle).max()
    assert np.abs(pushed.angle - stiffer.angle[..., 0]).max() < 5e-3 * size


@pytest.mark.parametrize(("share", "stays"), [(0.5, True), (1.5, False)])
def test_an_arm_that_is_pushed_away_harder_than_its_springs_hold_it_flies_away(share, stays):
    n = 4000
    still, start = np.zeros((n, 1, 2)), np.full((1, 2), 1e-6)

    def away(k, angle, rate):
        return share * STIFFNESS * angle

    if stays:
        assert np.abs(springs(n).integrate(still, away, start).angle).max() < 1e-5
    else:
        with pytest.raises(FlownAwayError, match="does not stay where its motors are"):
            springs(n).integrate(still, away, start)


def test_what_is_not_a_number_has_flown_away_too():
    with pytest.raises(FlownAwayError, match="nan"):
        springs(10).integrate(np.zeros((10, 1, 2)), lambda k, angle, rate: np.full((1, 2), np.nan), np.zeros((1, 2)))


def test_rigid_joints_cannot_fly_away():
    rigid = springs(10, stiffness=np.full(2, np.inf))
    found = rigid.integrate(np.ones((10, 1, 2)), lambda k, angle, rate: 1e9 + angle, np.zeros((1, 2)))
    np.testing.assert_array_equal(found.angle, 0.0)


@pytest.mark.parametrize(("frequency", "off"), [(13.0, 2e-5), (40.0, 2e-3)])
def test_a_free_swing_keeps_its_frequency_in_the_longest_steps(frequency, off):
    n, stiffness = 2001, 1e4
    mass = np.full((n, 1, 1, 1), stiffness / (2 * np.pi * frequency) ** 2)
    spring = Springs(mass=mass, stiffness=np.array([stiffness]), damping=np.zeros(1), dt=settings().replay.spring_step)
    released = np.zeros((n, 1, 1, 1))
    released[0] = stiffness
    angle = spring.bent_by(released).angle[:, 0, 0, 0]
    turns = np.flatnonzero((angle[1:] >= 0) & (angle[:-1] < 0))
    crossing = turns + angle[turns] / (angle[turns] - angle[turns + 1])
    found = (len(turns) - 1) / ((crossing[-1] - crossing[0]) * settings().replay.spring_step)
    assert abs(found / frequency - 1) < off
    assert np.abs(angle[-500:]).max() > 0.999 * np.abs(angle[10:510]).max()  # no swing is lost
