"""Every episode its own plant, drawn like the given one; the controller keeps what it knows."""

import gymnasium as gym
import numpy as np

from ffgym.envs import EpisodeRecorder
from ffgym.simulation.plant import LogUniform, PlantDistribution
from tests.envs.env_samples import CIRCLE, ONE_AXIS, plant_state

SETTINGS = {"randomization": PlantDistribution(), "horizon": 3, "autoreset_mode": "SameStep"}


def friction_of(env):
    return [float(robot.friction.coulomb[0]) for robot in env.unwrapped.core.plant.robots]


def episodes(n, seed, count=4, **kwargs):
    """Friction of every episode (count, n) and all observations."""
    env = gym.make_vec(ONE_AXIS, num_envs=n, **(SETTINGS | kwargs))
    seen, drawn = [env.reset(seed=seed)[0]], [friction_of(env)]
    for k in range(3 * count - 1):
        seen.append(env.step(np.full((n, 1), 0.4))[0])
        if k % 3 == 2:
            drawn.append(friction_of(env))
    return np.array(drawn), np.array(seen)


def test_every_episode_of_every_sub_environment_has_a_plant_of_its_own():
    drawn, _ = episodes(3, seed=0)
    assert drawn.shape == (4, 3)
    assert len(set(drawn.ravel())) == 12


def test_draws_follow_the_seed_of_the_sub_environment_alone():
    drawn, seen = episodes(3, seed=5)
    again, same = episodes(3, seed=5, n_threads=2)
    np.testing.assert_array_equal(drawn, again)
    np.testing.assert_array_equal(seen, same)
    alone, own = episodes(1, seed=7)
    np.testing.assert_array_equal(alone[:, 0], drawn[:, 2])
    np.testing.assert_array_equal(own[:, 0], seen[:, 2])


def test_the_single_environment_draws_the_same_plants():
    drawn, _ = episodes(1, seed=7)
    env = gym.make(ONE_AXIS, randomization=PlantDistribution())
    singles = []
    for k in range(4):
        env.reset(seed=7 if k == 0 else None)
        singles += friction_of(env)
    np.testing.assert_array_equal(singles, drawn[:, 0])


def test_a_partial_reset_draws_for_those_that_begin_only():
    env = gym.make_vec(ONE_AXIS, num_envs=3, **SETTINGS)
    env.reset(seed=0)
    before = env.core.plant.robots.copy()
    env.reset(options={"reset_mask": np.array([False, True, False])})
    after = env.core.plant.robots
    assert [one is two for one, two in zip(before, after, strict=True)] == [True, False, True]


def test_a_drawn_plant_moves_as_the_same_plant_given_by_hand():
    drawn = gym.make(ONE_AXIS, randomization=PlantDistribution())
    drawn.reset(seed=3)
    frequency = drawn.unwrapped.core.motions[0].task["frequency"]
    given = gym.make(ONE_AXIS, plant=drawn.unwrapped.core.plant.robots[0])
    given.reset(seed=0, options={"frequency": frequency})
    for _ in range(30):
        one, two = drawn.step([0.5]), given.step([0.5])
        np.testing.assert_array_equal(one[0], two[0])
        assert one[1] == two[1]
    np.testing.assert_array_equal(plant_state(drawn), plant_state(given))


def test_a_drawn_six_axis_robot_begins_in_its_own_equilibrium_without_path_error():
    env = gym.make_vec(CIRCLE, num_envs=3, randomization=PlantDistribution(), speeds=[0.1], radii=[0.001])
    env.reset(seed=0)
    sag = env.core.tcp_offset
    assert len({float(x) for x in np.linalg.norm(sag, axis=1)}) == 3  # payloads differ
    for _ in range(60):
        *_, info = env.step(np.zeros((3, 6)))
        np.testing.assert_allclose(info["path_error"], 0.0, atol=1e-9)
        assert (info["phase"] == "standstill").all()


def test_what_is_switched_off_stays_nominal(one_axis):
    only_viscous = PlantDistribution(
        **dict.fromkeys(PlantDistribution.__dataclass_fields__) | {"viscous": LogUniform(2.0, 2.0)}
    )
    env = gym.make(ONE_AXIS, randomization=only_viscous)
    env.reset(seed=0)
    robot = env.unwrapped.core.plant.robots[0]
    np.testing.assert_allclose(robot.friction.viscous, 2 * one_axis.friction.viscous)
    np.testing.assert_array_equal(robot.friction.coulomb, one_axis.friction.coulomb)
    np.testing.assert_array_equal(robot.drive.rotor_inertia, one_axis.drive.rotor_inertia)


def test_a_recording_carries_the_fingerprint_of_its_own_plant():
    recorder = EpisodeRecorder()
    env = gym.make_vec(ONE_AXIS, num_envs=2, recorder=recorder, **SETTINGS)
    env.reset(seed=0)
    for _ in range(6):
        env.step(np.zeros((2, 1)))
    prints = [recording.header.provenance["physics_fingerprint"] for recording in recorder.recordings]
    assert len(prints) == len(set(prints)) == 4
