"""Intervals of friction parameters hold the truth as often as they say, on data that are the model's with noise."""

from dataclasses import replace

import numpy as np

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


def sliding(rng):
    dt, t = 0.002, 0.002 * np.arange(2500)
    sines = ((1.3, 0.5), (5.0, 2.0), (10.0, 1.0))
    speed = np.stack([a * np.sin(2 * np.pi * f * t) for a, f in sines], axis=1)
    data = SlidingData(
        segments=("a", "b", "c"),
        dt=dt,
        speed=speed,
        friction=np.zeros_like(speed),
        inertia=0.01 * np.gradient(speed, dt, axis=0),
        scored=np.broadcast_to((t > 0.1)[:, None], speed.shape),
        low_pass=LowPass(cutoff=100.0),
    )
    (friction,) = data.model_friction(TRUE[None])
    noise = data.low_pass(0.1 * rng.normal(size=friction.shape), dt)
    return replace(data, friction=friction + noise + 0.03 * data.inertia + 0.01)


def test_those_of_dynamic_parameters_with_an_error_of_inertia_and_an_offset():
    spreads = []
    for k in range(40):
        rng = np.random.default_rng(k)
        static = np.tile(TRUE[:4], (150, 1))
        fit = fit_bristles(sliding(rng), TRUE[:4], static, rng, start=np.array([100.0, 0.3]))
        spreads.append((TRUE[4:], fit.resampled))
        assert abs(fit.inertia_error - 0.03) < 0.01
        assert abs(fit.offset - 0.01) < 0.01
    share = shares(spreads)
    assert (share >= 0.8).all(), share
    assert (share <= 0.98).all(), share
