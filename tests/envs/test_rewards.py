"""Rewards: minus a cost with a physical meaning, for every sub-environment its own."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.envs import AbsolutePathError, EpisodeRecorder, FeedbackEffort, MotorError, RelativePathError, Reward
from ffgym.envs.rewards import REWARDS, STOP_STEPS
from ffgym.recordings.metrics import path_errors
from tests.envs.env_samples import CIRCLE, JOINTS, ONE_AXIS, actions_for

SHORT_CIRCLE = {"position": "p2", "speed": 0.1, "radii": (0.001, 0.003)}


def steps(env, count, seed=0, options=None, actions=None):
    """Rewards, observations and infos of some steps with random actions."""
    env.reset(seed=seed, options=options)
    n = env.action_space.shape[-1]
    actions = actions_for(count, 1, n)[:, 0] if actions is None else actions
    return [env.step(action) for action in actions]


def test_motor_error_is_the_error_in_units_of_what_breakaway_torque_bends_the_servo(irb4600):
    env = gym.make(CIRCLE)
    unit = irb4600.friction.static / irb4600.servo.position_gain
    for observation, reward, *_ in steps(env, 30, options=SHORT_CIRCLE):
        error = env.unwrapped.observation_layout.read(observation, "error")
        assert reward == pytest.approx(-np.sqrt(np.mean((error / unit) ** 2)), rel=1e-12)
        assert reward < 0


def test_feedback_effort_is_the_learning_signal_in_units_of_breakaway_torque(irb4600):
    env = gym.make(CIRCLE, reward="feedback_effort")
    servo, layout = irb4600.servo, env.unwrapped.observation_layout
    for observation, reward, _, _, info in steps(env, 30, options=SHORT_CIRCLE):
        assert reward == pytest.approx(-np.sqrt(np.mean((info["u_p"] / irb4600.friction.static) ** 2)), rel=1e-12)
        error, rate = (layout.read(observation, name) for name in ("error", "error_rate"))
        np.testing.assert_allclose(
            info["u_p"], servo.position_gain * error + servo.velocity_gain * rate, rtol=1e-9, atol=1e-12
        )
        np.testing.assert_allclose(info["u_c"], info["u_p"] + info["u_i"], rtol=1e-12, atol=1e-15)


def test_path_error_is_the_scored_deviation_on_circles():
    recorder = EpisodeRecorder(record_dt=0.004)
    env = gym.make(CIRCLE, reward=AbsolutePathError(scale=1e-3), recorder=recorder)
    env.reset(seed=0, options=SHORT_CIRCLE)
    rows, ended = [], False
    while not ended:
        _, reward, _, ended, info = env.step(np.zeros(6))
        rows.append((info["time"], info["path_error"], info["phase"], info["circle"]))
        assert reward == pytest.approx(-info["path_error"] / 1e-3, rel=1e-12, abs=1e-15)
    time, away, phase, circle = (np.array(column) for column in zip(*rows, strict=True))
    scores = path_errors(recorder.recordings[0])
    assert len(scores) == 2
    for k, score in enumerate(scores):
        on = (phase == "circle") & (circle == k)
        assert np.sqrt(np.mean(away[on] ** 2)) == pytest.approx(score.rms, rel=1e-6)
        assert away[on].max() == pytest.approx(score.max, rel=1e-6)
        assert score.max > 1e-5
    np.testing.assert_allclose(away[time < 0.28], 0.0, atol=1e-9)  # at rest in equilibrium nothing is amiss


def test_halving_a_large_path_error_is_worth_the_same_at_every_size():
    env = gym.make(CIRCLE, reward="relative_path_error")
    for _, reward, _, _, info in steps(env, 60, options=SHORT_CIRCLE):
        assert reward == pytest.approx(-np.log1p(info["path_error"] / 2e-5), rel=1e-12, abs=1e-15)
    assert info["path_error"] > 1e-6
    signals = replace(env.unwrapped.core.signals, path_error=np.array([1e-3, 5e-4, 1e-2, 5e-3]))
    cost = RelativePathError(scale=1e-9).cost(signals, env.unwrapped.core.robot)
    np.testing.assert_allclose(cost[::2] - cost[1::2], np.log(2), rtol=1e-5)


def test_path_error_beside_circles_is_the_distance_across_the_motion():
    recorder = EpisodeRecorder(record_dt=0.004)
    env = gym.make(CIRCLE, recorder=recorder, horizon=110)
    infos = [result[-1] for result in steps(env, 110, options={"position": "p3", "speed": 0.04, "radii": 0.005})]
    recording = recorder.recordings[0]
    tcp, reference = (recording.vector(f"{name}.position") for name in ("tcp", "tcp_reference"))
    away = tcp - reference - (tcp[0] - reference[0])
    along = np.gradient(reference, axis=0)
    length = np.linalg.norm(along, axis=1, keepdims=True)
    along = np.divide(along, length, out=np.zeros_like(along), where=length > 1e-9)
    across = np.linalg.norm(away - np.sum(away * along, axis=1, keepdims=True) * along, axis=1)
    off_circle = np.array([info["phase"] != "circle" for info in infos])
    moving = np.array([info["phase"] == "lead_in" for info in infos])
    assert moving.sum() > 20
    got = np.array([info["path_error"] for info in infos])
    # the last row of the recording knows nothing of what follows, so its direction is another one
    np.testing.assert_allclose(got[:-1][off_circle[:-1]], across[1:-1][off_circle[:-1]], rtol=1e-6, atol=1e-12)


def test_effort_costs_the_mean_square_of_the_applied_action():
    plain, dear = (gym.make(CIRCLE, reward=MotorError(effort_weight=weight)) for weight in (0.0, 0.3))
    actions = actions_for(10, 1, 6)[:, 0] * 2  # some beyond the range, which is clipped
    for one, two, action in zip(
        *(steps(env, 10, options=SHORT_CIRCLE, actions=actions) for env in (plain, dear)), actions, strict=True
    ):
        assert two[1] == pytest.approx(one[1] - 0.3 * np.mean(np.clip(action, -1, 1) ** 2), rel=1e-12)
        np.testing.assert_array_equal(one[0], two[0])


@pytest.mark.parametrize("reward", [MotorError, FeedbackEffort])
def test_a_stop_costs_its_price_once_at_the_cost_at_which_it_happened(reward):
    settings = {"error_limit": 0.02, "action_scale": 10.0}
    envs = [gym.make(ONE_AXIS, reward=reward(**price), **settings) for price in ({}, {"stop_steps": 0})]
    assert reward().stop_steps == STOP_STEPS
    for env in envs:
        env.reset(seed=0)
    terminated = False
    while not terminated:
        dear, cheap = (env.step([1.0]) for env in envs)
        terminated = dear[2]
        assert dear[1] == pytest.approx(cheap[1] * (1 + STOP_STEPS * terminated), rel=1e-12)
        assert cheap[2] == terminated
        assert abs(env.unwrapped.observation_layout.read(dear[0], "error")[0]) > 0.02 or not terminated


def test_each_episode_may_have_a_reward_of_its_own():
    env = gym.make_vec(ONE_AXIS, num_envs=3, reward="motor_error", autoreset_mode="SameStep", horizon=4)
    own = [{}, {"reward": "feedback_effort"}, {"reward": MotorError(effort_weight=1.0)}]
    references = [gym.make(ONE_AXIS, reward=o.get("reward", "motor_error"), horizon=4) for o in own]
    for seed in (0, None):  # the second episode is as the environment was made
        if seed == 0:
            env.reset(seed=seed, options={"each": own})
        else:
            references = [gym.make(ONE_AXIS, horizon=4) for _ in own]
        for k, single in enumerate(references):
            single.reset(seed=k)
            if seed is None:
                single.reset()
        for action in actions_for(4, 3):
            rewards = env.step(action)[1]
            wanted = [single.step(action[k])[1] for k, single in enumerate(references)]
            np.testing.assert_array_equal(rewards, wanted)


def test_rewards_by_name_say_whether_they_need_what_no_robot_measures():
    assert {name: kind.privileged for name, kind in REWARDS.items()} == {
        "motor_error": False,
        "path_error": True,
        "relative_path_error": True,
        "log_rms_error": True,
        "feedback_effort": False,
    }
    for name, kind in REWARDS.items():
        one, two = (steps(gym.make(CIRCLE, reward=reward), 3, options=SHORT_CIRCLE)[-1][1] for reward in (name, kind()))
        assert one == two


def test_a_reward_of_ones_own_is_taken():
    class Speed(Reward):
        name = "speed"

        def cost(self, signals, robot):
            return np.abs(signals.error_rate[:, 0])

    env = gym.make(ONE_AXIS, reward=Speed())
    for observation, reward, *_ in steps(env, 5):
        assert reward == pytest.approx(-abs(env.unwrapped.observation_layout.read(observation, "error_rate")[0]))


def test_the_path_error_of_a_robot_without_tool_is_refused_before_it_moves():
    for name, kwargs in ((ONE_AXIS, {}), (JOINTS, {"robot": "one_axis"})):
        for reward in ("path_error", "relative_path_error"):
            with pytest.raises(FFGymError, match=r"'one_axis' has no tool.*motor_error"):
                gym.make(name, reward=reward, **kwargs)
    env = gym.make(ONE_AXIS)
    env.reset(seed=0)
    with pytest.raises(FFGymError, match="'one_axis' has no tool"):
        env.reset(options={"reward": AbsolutePathError()})
    env.step([0.0])


# Emergency stop


def run_on(env):
    """Return of every sub-environment with zero actions, and the largest error [rad]."""
    core, going = env.core, np.ones(env.num_envs, dtype=bool)
    total, largest = np.zeros(env.num_envs), 0.0
    while going.any():
        result = core.step(np.zeros((env.num_envs, core.robot.n_joints)), going)
        assert not result.terminated.any()
        total += result.reward
        largest = max(largest, np.abs(core.signals.error).max())
        going &= ~result.truncated
    return total, largest


def test_nothing_stops_without_action_and_stopping_pays_on_no_standard_task(irb4600):
    at_the_limit = 0.5 * irb4600.servo.position_gain / irb4600.friction.static  # of one motor alone
    stopping = -(1 + STOP_STEPS) * at_the_limit / np.sqrt(6)
    env = gym.make_vec(CIRCLE, num_envs=12, sampling="sequence", autoreset_mode="Disabled")
    env.reset(seed=0)
    total, largest = run_on(env)
    assert total.min() > stopping.max()
    assert largest < 0.25


def test_nothing_stops_without_action_on_sines_and_random_motions():
    for name, kwargs in ((ONE_AXIS, {"sampling": "sequence", "duration": 3.0}), (JOINTS, {})):
        env = gym.make_vec(name, num_envs=2 if name == ONE_AXIS else 20, autoreset_mode="Disabled", **kwargs)
        env.reset(seed=0)
        assert run_on(env)[1] < 0.35


def test_no_bang_bang_agent_gets_a_motor_to_its_limit():
    """Torque in the direction of motion pumps energy into servo and springs, all that an action can."""
    env = gym.make_vec(CIRCLE, num_envs=7, autoreset_mode="Disabled", horizon=200)
    env.reset(seed=0, options={"position": "p2", "speed": 0.01})
    for _ in range(200):
        pumping = np.where(env.core.signals.error_rate > 0, -1.0, 1.0)
        pumping[:6] *= np.eye(6)  # one motor alone; all of them in the last one
        assert not env.step(pumping)[2].any()
    assert np.abs(env.core.signals.error).max() < 0.25


class Weighted(Reward):
    """A plain class, equal to every other of its kind as far as dataclasses go."""

    name = "weighted"

    def __init__(self, weight):
        super().__init__()
        object.__setattr__(self, "weight", weight)

    def cost(self, signals, robot):
        return self.weight * np.abs(signals.error[:, 0])


def test_each_sub_environment_has_its_own_reward_even_if_they_compare_equal():
    env = gym.make_vec(ONE_AXIS, num_envs=2)
    same = {"frequency": 1.0}
    env.reset(seed=0, options={"each": [same | {"reward": Weighted(1.0)}, same | {"reward": Weighted(100.0)}]})
    reward = env.step(np.zeros((2, 1)))[1]
    assert reward[1] == pytest.approx(100 * reward[0])
    assert reward[0] < 0


@pytest.mark.parametrize(
    ("weight", "message"),
    [(np.nan, r"The cost of Weighted is \[nan"), (np.ones((3, 1)), r"The cost of Weighted has shape \(3, 2\)")],
)
def test_a_reward_of_ones_own_must_give_one_finite_number_each(weight, message):
    env = gym.make_vec(ONE_AXIS, num_envs=2, reward=Weighted(weight))
    env.reset(seed=0)
    with pytest.raises(FFGymError, match=message):
        env.step(np.zeros((2, 1)))
