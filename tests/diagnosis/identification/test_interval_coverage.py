"""Intervals of friction parameters hold the truth as often as they say, on data that are the model's with noise."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.identification.bristle_fit import NAMES, SlidingData, fit_bristles
from ffgym.diagnosis.identification.stribeck_fit import SteadyFriction, fit_stribeck
from ffgym.logs.preparation import LowPass
from ffgym.robot.friction import LuGreParameters

TRUE = np.array([0.5367, 0.5634, 0.0437, 0.15, 69.9787, 0.6753])
"""f_c, f_s, f_v, v_s, sigma_0, sigma_1 of the thesis, (6.9) and (6.18)."""


def shares(spreads):
    """How often 90 % intervals of resamples (B, P) hold the truth (P,), for pairs of both."""
    inside = [
        (low <= true) & (true <= high)
        for true, resampled in spreads
        for low, high in [np.quantile(resampled, [0.05, 0.95], axis=0)]
    ]
    return np.mean(inside, axis=0)


def steady(rng):
    speeds = np.array([0.02, 0.05, 0.09, 0.13, 0.18, 0.25, 0.4, 1.0, 3.0, 7.0, 14.0])
    run = np.repeat(np.arange(2 * len(speeds)), 12)
    speed = np.repeat(np.concatenate([speeds, -speeds]), 12)
    true = LuGreParameters(**dict(zip(NAMES, TRUE[:, None], strict=True)))
    friction = true.steady_torque(speed) + 0.003 * rng.normal(size=len(speed))
    return SteadyFriction(speed=speed, friction=friction, run=run)


def test_those_of_static_parameters():
    spreads = []
    for k in range(60):
        rng = np.random.default_rng(k)
        fit = fit_stribeck(steady(rng), rng, usual_velocity=0.1, n_resamples=80)
        spreads.append((TRUE[:4], fit.resampled[:, :4]))
    share = shares(spreads)
    assert (share >= 0.8).all(), share
    assert (share <= 0.98).all(), share


def sliding(rng, lag=0.0, delay=0.0, angle_noise=0.0):
    """Reversals of a joint, its angle measured with noise [rad].

    Friction follows the motion by `lag` [s], and the torque acts `delay` [s] later than recorded.
    """
    dt, t = 0.002, 0.002 * np.arange(2500)
    sines = ((1.3, 0.5), (5.0, 2.0), (10.0, 1.0))
    speed = np.stack([a * np.sin(2 * np.pi * f * t) for a, f in sines], axis=1)
    inertia = 0.01 * np.gradient(speed, dt, axis=0)
    low_pass = LowPass(cutoff=100.0)
    data = SlidingData(
        segments=("a", "b", "c"),
        dt=dt,
        speed=speed,
        friction=np.zeros_like(speed),
        by_inertia=inertia,
        by_links=0.6 * inertia,
        by_springs=np.zeros_like(inertia),
        arm_rate=np.gradient(inertia, dt, axis=0),
        angle_noise=np.full(3, angle_noise),
        shaken=np.array([[0.004] * 3, [0.006] * 3]),
        rows_dt=dt,
        scored=np.broadcast_to((t > 0.1)[:, None], speed.shape),
        low_pass=low_pass,
    )
    late = np.stack([a * np.sin(2 * np.pi * f * (t - lag)) for a, f in sines], axis=1)
    (friction,) = data.model_friction(TRUE[None], late)
    friction = friction + delay * (np.gradient(friction, dt, axis=0) + data.arm_rate)
    noise = low_pass(0.1 * rng.normal(size=friction.shape), dt)
    # noise of the angle is in speed and acceleration, and with the acceleration in what counts as friction
    wrong = np.gradient(low_pass(angle_noise * rng.normal(size=speed.shape), dt), dt, axis=0)
    shaken = 0.01 * np.gradient(wrong, dt, axis=0)
    return replace(
        data,
        speed=speed + wrong,
        friction=friction + noise + 0.03 * inertia + 0.01 - shaken,
        by_inertia=inertia + shaken,
        by_links=0.6 * (inertia + shaken),
    )


def fitted(n_fits, **wrong):
    """Fits to records that are drawn anew."""
    for k in range(n_fits):
        rng = np.random.default_rng(k)
        static = np.tile(TRUE[:4], (150, 1))
        yield fit_bristles(sliding(rng, **wrong), TRUE[:4], static, rng, start=np.array([100.0, 0.3]))


@pytest.mark.slow
def test_those_of_dynamic_parameters_with_an_error_of_inertia_and_an_offset():
    spreads = []
    for fit in fitted(40):
        spreads.append((TRUE[4:], fit.resampled))
        assert abs(fit.inertia_error - 0.03) < 0.01
        assert abs(fit.offset - 0.01) < 0.01
    share = shares(spreads)
    assert (share >= 0.8).all(), share
    assert (share <= 0.98).all(), share


@pytest.mark.slow
def test_those_of_dynamic_parameters_where_friction_follows_the_motion_late():
    fits = list(fitted(25, lag=1e-3))
    assert np.median([fit.lag for fit in fits]) == pytest.approx(1e-3, rel=0.3)
    share = shares([(TRUE[4:], fit.resampled) for fit in fits])
    assert (share >= 0.75).all(), share


@pytest.mark.slow
def test_those_of_dynamic_parameters_where_the_torque_acts_late():
    fits = list(fitted(25, delay=2e-3))
    assert np.median([fit.delay for fit in fits]) == pytest.approx(2e-3, rel=0.15)
    share = shares([(TRUE[4:], fit.resampled) for fit in fits])
    assert (share >= 0.75).all(), share


@pytest.mark.slow
def test_those_of_dynamic_parameters_where_noise_of_the_angle_is_in_speed_and_inertia():
    fits = list(fitted(25, angle_noise=1e-4))
    share = shares([(TRUE[4:], fit.resampled) for fit in fits])
    assert (share >= 0.75).all(), share
