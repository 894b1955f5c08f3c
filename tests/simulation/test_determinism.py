"""Same bits at any number of threads, alone or in company."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.control import DynamicLuGreExact, NoCompensation, StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.paths.reference import Reference
from ffgym.recordings import Phase
from ffgym.simulation import LaserTracker, Resolver, Run, simulate
from ffgym.simulation.plant import Plant
from ffgym.studies import circle_references
from tests.simulation.plant.driving import controls

SENSORS = (Resolver(bits=16), LaserTracker(noise=20e-6, period=0.001))


@pytest.fixture(scope="module")
def runs(irb4600, arm):
    """Runs of four lengths at different corners, none a multiple of the engine's chunk."""
    fast = circle_references(arm, ["p1", "p2"], [0.1], [0.001])
    slow = circle_references(arm, ["p3"], [0.04], [0.001])
    friction = irb4600.friction
    return [
        Run(reference=fast["p1", 0.1], law=DynamicLuGreExact(friction)),
        Run(reference=shortened(fast["p2", 0.1], 101), law=StaticLuGre(friction)),
        Run(reference=slow["p3", 0.04], law=NoCompensation()),
        Run(reference=shortened(slow["p3", 0.04], 38), law=DynamicLuGreExact(friction)),
    ]


def shortened(reference, samples):
    """The first samples of a reference."""
    phase = Phase(label="cut", kind="motion", start=0.0, end=float(reference.t[samples - 1]))
    cut = {name: getattr(reference, name)[:samples] for name in ("t", "q", "dq", "ddq")}
    return replace(reference, phases=(phase,), **cut)


@pytest.fixture(scope="module")
def together(arm, runs):
    return simulate(runs, arm=arm, n_threads=1)


def test_runs_have_different_lengths(together):
    assert len({len(recording) for recording in together}) == len(together)


def test_two_threads_give_the_bits_of_one(arm, runs, together):
    for one, two in zip(together, simulate(runs, arm=arm, n_threads=2), strict=True):
        assert one.equals(two)


@pytest.mark.parametrize("i", range(4))
def test_a_run_alone_has_the_bits_it_has_in_a_batch(arm, runs, together, i):
    (alone,) = simulate([runs[i]], arm=arm)
    assert alone.equals(together[i])


def test_order_of_the_runs_does_not_matter(arm, runs, together):
    for recording, other in zip(reversed(together), simulate(runs[::-1], arm=arm), strict=True):
        assert recording.equals(other)


def test_starting_poses_far_apart_do_not_disturb_each_other(irb4600):
    """Poses whose gravity deflection converges in different numbers of iterations."""
    poses = np.random.default_rng(0).uniform(-1, 1, (12, 6))
    poses[:, 2] = np.clip(poses[:, 2], -1, 0.5)
    runs = [Run(reference=standing(irb4600, pose)) for pose in poses]
    for run, recording in zip(runs, simulate(runs), strict=True):
        assert simulate([run])[0].equals(recording)


def standing(robot, q, samples=11):
    """Reference that stays at joint angles `q`."""
    still = np.zeros((samples, robot.n_joints))
    phase = Phase(label="rest", kind="standstill", start=0.0, end=0.004 * (samples - 1))
    t = np.arange(samples) * 0.004
    return Reference(name="standing", robot=robot, t=t, q=still + q, dq=still, ddq=still, phases=(phase,))


def test_a_second_simulation_repeats_the_first(arm, runs, together):
    for first, again in zip(together, simulate(runs, arm=arm, n_threads=1), strict=True):
        assert first.equals(again)


def test_sensors_repeat_with_their_seed(arm, runs):
    first, again, other = (simulate(runs[3:], arm=arm, sensors=SENSORS, seed=seed) for seed in (5, 5, 6))
    assert first[0].equals(again[0])
    assert not np.array_equal(first[0]["tcp.position.x"], other[0]["tcp.position.x"])


def test_sampling_a_recording_more_often_changes_no_sample(arm, runs, together):
    (often,) = simulate([runs[3]], arm=arm, record_dt=0.00025)
    rare = together[3]
    for column in ("motor.position.j3", "motor.effort.j2", "friction.effort.j1", "tcp.position.z"):
        np.testing.assert_allclose(often[column][::4], rare[column], atol=1e-12)
    np.testing.assert_array_equal(often["motor.position.j3"][::4], rare["motor.position.j3"])


def test_a_batch_stepped_in_parts_has_the_bits_of_one_call(irb4600, arm, runs):
    reference = runs[3].reference
    rows = (reference.q * irb4600.drive.gear_ratio, reference.motor_dq, np.zeros_like(reference.q))
    plants = [Plant(irb4600, 1) for _ in range(2)]
    for plant in plants:
        plant.rest(reference.q[:1])
    sent = controls(plants[0], *(row[None] for row in rows))
    whole = plants[0].advance(sent)
    parts = [plants[1].advance(sent[:, a:b]) for a, b in ((0, 7), (7, 20), (20, sent.shape[1]))]
    for k in range(3):
        np.testing.assert_array_equal(whole[k], np.concatenate([part[k] for part in parts], axis=1))


def test_the_simulation_that_becomes_unstable_is_named(irb4600, corners, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    plant = Plant(irb4600, 3)
    held = controls(plant, corners["p1"] * irb4600.drive.gear_ratio, shape=(3, 10, 6))
    for bad in (1, 1, 2, 1):  # every time, also after it was put to rest
        plant.rest(np.tile(corners["p1"], (3, 1)))
        plant.batch.qvel[bad, 0] = 1e11
        with pytest.raises(
            FFGymError, match=rf"Simulation {bad} of robot 'irb4600_60_205' became unstable between t = "
        ):
            plant.advance(held)
    plant.rest(np.tile(corners["p1"], (3, 1)))
    plant.advance(held)
    assert not list(tmp_path.iterdir())  # no MUJOCO_LOG.TXT
    assert capfd.readouterr() == ("", "")
