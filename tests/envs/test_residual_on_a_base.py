"""The second version: a bounded residual on a base law, scored as on the leaderboard, with features, tracks, states."""

import gymnasium as gym
import numpy as np
import pytest

from ffgym.agents import elastic_feedforward
from ffgym.core.errors import FFGymError
from ffgym.core.registration import ENVIRONMENTS
from ffgym.envs import EpisodeRecorder, History, LogRMSError, LowPassAction, Sensing
from ffgym.envs.rewards import STOP_PRICE
from ffgym.recordings.metrics import path_errors
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import PlantDistribution
from ffgym.studies import circle_references
from tests.envs.env_samples import CIRCLE, JOINTS, ONE_AXIS, actions_for

SHORT = {"position": "p3", "speed": 0.1, "radii": (0.001, 0.003)}
SECOND = sorted(name for name in ENVIRONMENTS if name.endswith("-v1"))


def run_episode(env, actions=None, seed=0, options=None):
    """Observations, rewards and infos of an episode, by default with zero actions."""
    seen, ended, k = [(*env.reset(seed=seed, options=options), 0.0)], False, 0
    while not ended:
        action = np.zeros(env.action_space.shape) if actions is None else actions[k]
        observation, reward, terminated, truncated, info = env.step(action)
        seen.append((observation, info, reward))
        ended, k = terminated or truncated or (actions is not None and k + 1 == len(actions)), k + 1
    observations, infos, rewards = zip(*seen, strict=True)
    return np.array(observations), infos, np.array(rewards)


def test_a_base_is_the_law_of_the_simulation_whatever_the_bound(irb4600, arm):
    (reference,) = circle_references(arm, ["p3"], [0.1], [0.001, 0.003]).values()
    (simulated,) = simulate([Run(reference=reference, law=elastic_feedforward(irb4600))], arm=arm)
    recorder = EpisodeRecorder()
    run_episode(gym.make(CIRCLE, base="elastic", bound=0.1, recorder=recorder), options=SHORT)
    (acted,) = recorder.recordings
    for name in ("motor.position", "motor.effort", "compensation.effort"):
        for column in [column for column in simulated.columns if column.startswith(name)]:
            np.testing.assert_allclose(acted[column], simulated[column], rtol=0, atol=1e-12, err_msg=column)
    assert np.abs(simulated.joint_array("compensation.effort")).max() > irb4600.friction.static.max()


def test_a_base_may_be_a_law_and_must_be_one(irb4600):
    law = elastic_feedforward(irb4600)
    by_name, itself = (
        run_episode(gym.make(CIRCLE, base=base, horizon=80), options=SHORT)[0] for base in ("elastic", law)
    )
    np.testing.assert_array_equal(by_name, itself)
    for base, problem in ((3, "base = 3 must be the name"), ("best", "base 'best'"), (type(law), "base = .* must be")):
        with pytest.raises(FFGymError, match=problem):
            gym.make(CIRCLE, base=base)


@pytest.mark.parametrize("base", ["none", "elastic"])
def test_the_return_is_the_measure_of_the_leaderboard(base):
    recorder = EpisodeRecorder(record_dt=0.004)
    env = gym.make(CIRCLE, base=base, reward=LogRMSError(scale=2e-6), recorder=recorder)
    _, infos, rewards = run_episode(env, options=SHORT)
    assert rewards.max() <= 0
    wanted = [-np.log1p((score.rms / 2e-6) ** 2) / 2 for score in path_errors(recorder.recordings[0])]
    assert rewards.sum() == pytest.approx(sum(wanted), abs=0.01)  # the score takes a point at the end, too
    # nothing counts off the circles
    on = np.array([info["phase"] == "circle" for info in infos])
    assert np.all(rewards[~on] == 0)
    # all of each circle counts once
    square = [info["path_error"] ** 2 for info in infos]
    for k in (0, 1):
        own = on & np.array([info["circle"] == k for info in infos])
        assert rewards[own].sum() == pytest.approx(-0.5 * np.log1p(np.mean(np.array(square)[own]) / 2e-6**2), rel=1e-9)


def test_a_motion_without_circles_and_a_robot_without_tool_are_scored_as_a_whole(one_axis):
    _, infos, rewards = run_episode(gym.make(JOINTS, reward="log_rms_error", duration=1.2))
    square = [info["path_error"] ** 2 for info in infos if info["phase"] == "motion"]
    assert rewards.sum() == pytest.approx(-0.5 * np.log1p(np.mean(square) / 1e-5**2), rel=1e-9)
    env = gym.make(ONE_AXIS, reward="log_rms_error", duration=0.5)
    observations, infos, rewards = run_episode(env)
    error = env.unwrapped.observation_layout.read(observations, "error")[:, 0]
    scaled = error * one_axis.servo.position_gain / one_axis.friction.static
    moving = np.array([info["phase"] == "motion" for info in infos])
    assert rewards.sum() == pytest.approx(-0.5 * np.log1p(np.mean(scaled[moving] ** 2) / 0.01**2), rel=1e-9)


def test_stopping_costs_more_than_any_circle():
    env = gym.make(CIRCLE, reward="log_rms_error", error_limit=1e-3)
    _, _, rewards = run_episode(env, options=SHORT)
    assert rewards[-1] == pytest.approx(-STOP_PRICE, abs=1.0)
    whole = run_episode(gym.make(CIRCLE, reward="log_rms_error"), options={"position": "p1", "speed": 0.1})[2]
    assert whole.sum() > -STOP_PRICE / 5
    for wrong in ({"scale": 0.0}, {"motor_scale": -1.0}):
        with pytest.raises(FFGymError, match="is out of range"):
            LogRMSError(**wrong)


def test_features_are_directions_the_torque_of_the_base_and_errors_beyond_its_own(irb4600, arm):
    (reference,) = circle_references(arm, ["p3"], [0.1], [0.001, 0.003]).values()
    law = elastic_feedforward(irb4600)
    env = gym.make(CIRCLE, base="elastic", features=True, preview=2)
    layout = env.unwrapped.observation_layout
    observations = run_episode(env, options=SHORT)[0]
    np.testing.assert_allclose(layout.read(observations, "base_torque")[:-1], law.torque(reference)[1:], atol=1e-9)
    speed = layout.read(observations, "reference_velocity", ahead_by=2)
    direction = np.tanh(speed / irb4600.friction.stribeck_velocity)
    np.testing.assert_allclose(layout.read(observations, "reference_direction", ahead_by=2), direction, atol=1e-9)
    # the law moves motors off their references on purpose, on its own robot to a tenth
    error, asked = layout.read(observations, "error"), law.own_errors(reference)[0]
    plain = gym.make(CIRCLE, base="elastic")
    raw = plain.unwrapped.observation_layout.read(run_episode(plain, options=SHORT)[0], "error")
    np.testing.assert_allclose(error + asked, raw, atol=1e-9)
    left, before = (np.sqrt(np.mean(values[:, :2] ** 2, axis=0)) for values in (error, raw))
    assert np.all(left < 0.1 * before)
    # a scaled observation is of order 1, in tenths of the error at breakaway
    scale = 0.1 * irb4600.friction.static / irb4600.servo.position_gain
    np.testing.assert_allclose(layout["error"].scale, scale, rtol=1e-12)


def test_the_track_feed_forward_sees_nothing_of_the_machine():
    drawn = PlantDistribution().draw(gym.make(CIRCLE).unwrapped.core.robot, np.random.default_rng(3))
    actions = actions_for(60, 1, 6)[:, 0]
    for track, same in (("feed-forward", True), ("feedback", False)):
        both = [
            run_episode(
                gym.make(CIRCLE, track=track, features=True, base="lugre_dynamic", plant=plant),
                actions,
                options=SHORT | {"speed": 0.04},
            )[0]
            for plant in (None, drawn)
        ]
        assert np.array_equal(*both) == same
    assert "error" not in gym.make(CIRCLE, track="feed-forward").unwrapped.observation_layout
    with pytest.raises(FFGymError, match="track 'both'"):
        gym.make(CIRCLE, track="both")


def test_clipped_actions_are_told():
    env = gym.make(CIRCLE)
    assert not env.reset(seed=0)[1]["clipped"].any()
    info = env.step(np.array([0.5, 1.0, -1.0, 1.5, -2.0, 0.0]))[-1]
    assert info["clipped"].tolist() == [False, False, False, True, True, False]
    assert not env.step(np.zeros(6))[-1]["clipped"].any()


def test_a_bound_is_another_name_of_the_action_scale(irb4600):
    for arguments in ({"bound": 0.6}, {"action_scale": 0.6}, {"bound": 9.0, "action_scale": 0.6}):
        env = gym.make(CIRCLE, **arguments)
        np.testing.assert_array_equal(env.unwrapped.action_torque, 0.6 * irb4600.friction.static)


@pytest.mark.parametrize("layers", [(), (LowPassAction(20.0), History(3))], ids=["plain", "layers"])
def test_an_episode_goes_on_from_a_state_as_it_did(layers):
    noisy = Sensing(encoder_bits=12, noise=1e-3)
    env = gym.make_vec(
        CIRCLE, num_envs=2, layers=layers, sensing=noisy, randomization=PlantDistribution(), horizon=30, base="elastic",
        autoreset_mode="SameStep", reward="log_rms_error",
    )  # fmt: skip
    actions = actions_for(40, 2, 6)

    def follow():
        return [env.step(action) for action in actions[10:]]  # through the end of the episode, into other machines

    env.reset(seed=4)
    for action in actions[:10]:
        env.step(action)
    state = env.unwrapped.get_state()
    first = follow()
    for _ in range(2):  # a state may be gone back to as often as one likes
        env.unwrapped.set_state(state)
        for ours, theirs in zip(follow(), first, strict=True):
            for a, b in zip(ours[:4], theirs[:4], strict=True):
                np.testing.assert_array_equal(a, b)
            np.testing.assert_array_equal(ours[4]["u_p"], theirs[4]["u_p"])
    assert any(step[3].any() for step in first)


def test_a_state_of_another_environment_and_of_a_recording_is_refused():
    env, other = gym.make(ONE_AXIS).unwrapped, gym.make(ONE_AXIS).unwrapped
    with pytest.raises(FFGymError, match="before the first reset"):
        env.get_state()
    for one in (env, other):
        one.reset(seed=0)
    with pytest.raises(FFGymError, match="get_state of this environment"):
        env.set_state(other.get_state())
    recorded = gym.make(ONE_AXIS, recorder=EpisodeRecorder()).unwrapped
    recorded.reset(seed=0)
    with pytest.raises(FFGymError, match="recorded"):
        recorded.get_state()


def test_one_machine_of_a_list_is_drawn_for_each_episode(irb4600):
    plants = [PlantDistribution().draw(irb4600, np.random.default_rng(k)) for k in range(3)]
    env = gym.make(CIRCLE, plant=plants).unwrapped
    met = []
    for _ in range(12):
        env.reset(seed=0 if not met else None)
        met.append(plants.index(env.core.plant.machines[0].robot))
    assert set(met) == {0, 1, 2}
    with pytest.raises(FFGymError, match=r"plant = \[\]"):
        gym.make(CIRCLE, plant=[])
    with pytest.raises(FFGymError, match="of one controller"):
        gym.make("ffgym/WorkcellCircles-v0", workcell=["thesis", "thesis_drives"])


@pytest.mark.parametrize("name", SECOND)
def test_ids_of_the_second_version_declare_their_limit_and_need_less(name):
    env = gym.make(name)
    longest = ENVIRONMENTS[name].longest
    assert env.spec.max_episode_steps == longest
    tasks = env.unwrapped.core.tasks
    motions = [tasks.draw(np.random.default_rng(0), task) for task in tasks.list_options() or [{}]]
    assert max(motion.n_steps for motion in motions) <= longest
    np.testing.assert_array_equal(env.unwrapped.action_torque, 0.6 * env.unwrapped.core.robot.friction.static)
    assert env.unwrapped.core.base is not None
    assert env.unwrapped.core.robot.drive.resolver_period > 0
    short = gym.make_vec(name, num_envs=1, max_episode_steps=3)
    short.reset(seed=0)
    ends = [bool(short.step(np.zeros(short.action_space.shape))[3][0]) for _ in range(3)]
    assert ends == [False, False, True]
