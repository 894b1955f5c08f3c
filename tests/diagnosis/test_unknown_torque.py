"""Torque that depends on motion that a log does not show counts as noise, and nothing else does."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.replay import replay
from ffgym.diagnosis.sampling import without_trembling
from ffgym.diagnosis.weights import downweight, estimate_unknown_torque
from tests.diagnosis.replay.replay_samples import nominal, recorded

KEY = ("torque", 0)
NOISE = 0.01


@pytest.fixture(scope="module")
def log():
    return assemble_log(nominal().robot, [recorded({"nominal": nominal()})["nominal"]])


def bias_of(log, values=0.0):
    return {"torque": np.full((len(log.sampling.at), 1, log.robot.n_joints), values)}


def turned_back(log, way):
    """The log with motors that slide, stop, and go back by a `way` [rad] in the second half of it, link side."""
    n = len(log.q)
    speed = np.where(np.arange(n) < n // 2, 0.2, 0.0)
    speed[n // 2 + n // 8 : n // 2 + n // 4] = -way / (n // 8 * log.dt)
    soft = np.hanning(n // 8)
    speed = np.convolve(speed, soft / soft.sum(), mode="same")
    q = np.repeat(np.cumsum(speed * log.dt)[:, None, None], log.robot.n_joints, axis=2)
    dq = np.gradient(q, log.dt, axis=0)
    return replace(log, q=q, dq=dq, ddq=np.zeros_like(q), slip_dq=dq)


def test_friction_is_not_known_where_a_motor_turned_back_within_the_band_of_its_noise(log):
    coulomb = log.robot.friction.coulomb
    presliding = log.robot.drive.joint_angle(coulomb / log.robot.friction.bristle_stiffness)
    back = turned_back(log, 0.5 * float(np.abs(presliding[0])))
    band = np.full(log.robot.n_joints, 0.3 * np.abs(presliding[0]))
    seen = replace(back, trembling=band, slip_dq=np.gradient(without_trembling(back.q, band), log.dt, axis=0))
    hidden, exact = (estimate_unknown_torque(replay(one, nominal()), bias_of(log))[:, 0, 0] for one in (seen, back))
    after = log.sampling.at > 0.8 * len(log.q)
    assert hidden[after].min() > 0.1 * coulomb[0]
    assert exact[after].max() < 0.01 * coulomb[0]
    before = (log.sampling.at > 0.1 * len(log.q)) & (log.sampling.at < 0.4 * len(log.q))
    assert hidden[before].max() < 0.01 * coulomb[0]


def test_friction_is_not_known_where_a_motor_stops_faster_than_the_band_of_its_motion_shows(log):
    """Four periods of the band about its reversals; elsewhere next to nothing is unknown."""
    run = replay(log, nominal())
    unknown = estimate_unknown_torque(run, bias_of(log))[:, 0, 0]
    turns = np.flatnonzero(np.diff(np.sign(log.dq[:, 0, 0])) != 0)
    away = np.abs(log.sampling.at[:, None] - turns).min(axis=1) * log.dt > 4 / log.sampling.motion_filter.cutoff
    rms = np.sqrt(np.mean(run.bristles.torque[:, 0, 0] ** 2))
    assert unknown[~away].max() > 0.02 * rms
    assert unknown[away].max() < 0.1 * unknown[~away].max()


@pytest.mark.parametrize(("dt", "share"), [(0.0007, 0.1), (0.007, 1.0), (0.01, 1.0), (0.1, 0.0)])
def test_what_a_replay_does_wrong_is_not_known_where_reversals_are_hardly_longer_than_samples(log, dt, share):
    run = replay(log, nominal())
    rare = replace(run, read=replace(log, sampling=replace(log.sampling, dt=dt, cutoff=0.1 / dt)))
    with_it, without = (estimate_unknown_torque(rare, bias_of(rare.read, size))[:, 0] for size in (1.0, 0.0))
    np.testing.assert_allclose(with_it, np.hypot(without, share), atol=1e-12)


def test_what_is_unknown_counts_as_noise_in_its_row_and_the_next():
    unknown = np.zeros((100, 1, 1))
    unknown[50] = 10 * NOISE
    found = downweight({KEY: np.full(1, 1 / NOISE)}, {"torque": unknown})[KEY]
    np.testing.assert_allclose(found[49:52], 1 / (NOISE * np.hypot(1, 10)))
    np.testing.assert_allclose(np.delete(found, [49, 50, 51], axis=0), 1 / NOISE)


def test_what_is_no_torque_is_known_as_it_was():
    weight = np.full(1, 1 / NOISE)
    found = downweight({("tool", 0): weight}, {"torque": np.ones((100, 1, 1))})
    np.testing.assert_array_equal(found["tool", 0], weight)
