"""A reset or a step that is refused has changed nothing: not the physics, not the randomness, not a layer."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

from ffgym.control import NoCompensation, StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.envs import EpisodeRecorder, History, Hold, LowPassAction, ResidualAction, Sensing
from ffgym.simulation.plant import PlantDistribution, Uniform
from tests.envs.env_samples import CIRCLE, FAST_SERVO, JOINTS, ONE_AXIS, OTHER_GEAR, Remembering, plant_state

MANY_SPEEDS = {"frequency": 3.0, "amplitude": 500.0}
MASK = np.array([True, False])
RESETS = [
    ({"seed": -1}, "seed = -1 must be a whole number >= 0"),
    ({"seed": 2.5}, "seed = 2.5 must be a whole number"),
    ({"seed": "x"}, "seed = 'x' must be"),
    ({"seed": [1]}, "seed has 1 entries, must be one number or 2"),
    ({"seed": [1, -2]}, "seed = -2 must be a whole number >= 0"),
    ({"seed": [1, 2.5]}, "seed = 2.5 must be"),
    ({"options": 5}, "options = 5 must be a dict"),
    ({"options": {"wrong": 1}}, "Unknown reset option 'wrong'. Available: amplitude, frequency, horizon"),
    ({"options": {"reset_mask": [1, 0]}}, r"options\['reset_mask'\] must be an array of 2 bool"),
    ({"options": {"reset_mask": MASK[:1]}}, r"options\['reset_mask'\] must be an array of 2 bool"),
    ({"options": {"reset_mask": MASK & ~MASK}}, "with at least one True"),
    ({"options": {"reset_mask": [[True], [True, False]]}}, r"options\['reset_mask'\] must be an array"),
    ({"options": {"each": [{}]}}, r"options\['each'\] must be a list of 2 dicts"),
    ({"options": {"each": [{}, 5]}}, r"options\['each'\] must be a list of 2 dicts"),
    ({"options": {"each": [{}, {"wrong": 1}]}}, "Unknown reset option 'wrong'"),
    ({"options": {"each": [{}, {"reset_mask": MASK}]}}, "Unknown reset option 'reset_mask'"),
    ({"options": {"frequency": -1.0}}, "frequency = -1.0 Hz"),
    ({"options": {"frequency": "1"}}, "frequency must be a number in Hz, got .1."),
    ({"options": {"amplitude": 1e5}}, r"joint j1 is at .* rad"),
    ({"options": MANY_SPEEDS}, "must stay below 367.000 rad/s"),
    ({"options": {"plant": "irb4600_60_205"}}, "differ in joints"),
    ({"options": {"plant": FAST_SERVO}}, r"servo\.position_gain"),
    ({"options": {"each": [{"horizon": 3}, {"plant": OTHER_GEAR}]}}, r"drive\.gear_ratio"),
    ({"options": {"randomization": 5}}, "randomization = 5 must be of class PlantDistribution"),
    ({"options": {"randomization": PlantDistribution(joint_stiffness=Uniform(-1, -1))}}, "must be > 0"),
    ({"options": {"reward": "best"}}, "Unknown reward 'best'"),
    ({"options": {"reward": None}}, "reward = None must be one of"),
    ({"options": {"reward": "path_error"}}, "no tool"),
    ({"options": {"sensing": None}}, "sensing = None must be of class Sensing"),
    ({"options": {"horizon": -1}}, "horizon = -1"),
    ({"options": {"horizon": 1.5}}, "horizon = 1.5 must be a whole number"),
]


@pytest.mark.parametrize(("arguments", "message"), RESETS)
def test_a_reset_that_is_refused_changes_nothing(arguments, message):
    """Not even when it is only the second sub-environment that cannot do what it is asked to."""
    settings = {"num_envs": 2, "randomization": PlantDistribution(), "sampling": "sequence"}
    tried, untouched = (gym.make_vec(ONE_AXIS, autoreset_mode="SameStep", horizon=9, **settings) for _ in range(2))
    for env in (tried, untouched):
        env.reset(seed=1)
        env.step(np.full((2, 1), 0.5))
    state = plant_state(tried)
    seed = {"seed": 77} | arguments
    for given in (arguments, seed):
        with pytest.raises(FFGymError, match=message):
            tried.reset(**given)
    np.testing.assert_array_equal(plant_state(tried), state)
    assert tried.np_random_seed == untouched.np_random_seed == (1, 2)
    for _ in range(20):  # the same motions, plants, rewards and ends as if nothing had been tried, and then the next
        one, two = (env.step(np.full((2, 1), -0.5)) for env in (tried, untouched))
        for a, b in zip(one[:4], two[:4], strict=True):
            np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"seed": -1}, "seed = -1"),
        ({"seed": 2.5}, "seed = 2.5"),
        ({"seed": [1]}, r"seed = \[1\]"),
        ({"seed": 9, "options": {"frequency": "x"}}, "frequency must be a number"),
        ({"seed": 9, "options": {"horizon": 0}}, "horizon = 0"),
    ],
)
def test_a_single_reset_that_is_refused_changes_nothing(arguments, message):
    tried, untouched = (gym.make(ONE_AXIS, sampling="sequence", sensing=Sensing(noise=0.1)) for _ in range(2))
    for env in (tried, untouched):
        env.reset(seed=1)
        env.step([0.5])
    with pytest.raises(FFGymError, match=message):
        tried.reset(**arguments)
    assert tried.unwrapped.np_random_seed == 1
    for again in (False, True):
        if again:
            np.testing.assert_array_equal(tried.reset()[0], untouched.reset()[0])
        np.testing.assert_array_equal(tried.step([0.1])[0], untouched.step([0.1])[0])


def test_a_robot_too_soft_for_gravity_is_refused_and_the_others_keep_running(irb4600):
    soft = replace(irb4600, drive=replace(irb4600.drive, joint_stiffness=irb4600.drive.joint_stiffness * 1e-3))
    env = gym.make_vec(CIRCLE, num_envs=2, speeds=[0.1], radii=[0.001], positions=["p1"])
    env.reset(seed=0)
    env.step(np.zeros((2, 6)))
    state = plant_state(env)
    with pytest.raises(FFGymError, match="too soft"):
        env.reset(seed=5, options={"each": [{}, {"plant": soft}]})
    np.testing.assert_array_equal(plant_state(env), state)
    assert env.core.plant.robots == [irb4600, irb4600] or all(
        robot is env.core.plant.robot for robot in env.core.plant.robots
    )
    assert np.isfinite(env.step(np.zeros((2, 6)))[0]).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"position": "p9"}, "Unknown position 'p9'"),
        ({"position": (9.0, 9.0, 9.0)}, "not reachable"),
        ({"position": 5}, r"position has shape \(\)"),
        ({"speed": 0.0}, "speed = 0.0 m/s"),
        ({"speed": 5.0}, "speed = 5.0 m/s is too fast for radius"),
        ({"radii": []}, "radii is empty"),
        ({"radii": [-1.0]}, "radius = -1.0 m"),
        ({"radii": "3"}, "radii must be numbers"),
        ({"order": "x"}, "Unknown order 'x'"),
        ({"frequency": 1.0}, "Unknown reset option 'frequency'. Available: horizon, order, plant, position"),
    ],
)
def test_circles_that_cannot_be_run_are_refused(options, message):
    with pytest.raises(FFGymError, match=message):
        gym.make(CIRCLE).reset(options=options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"centre": [0.0, 0.0]}, r"centre has shape \(2,\), must be \(6\)"),
        ({"centre": [50.0] * 6}, "centre = .* must be within the middle 80 %"),
        ({"peak_speed": -1.0}, r"peak_speed = \[-1. .* must be >= 0"),
        ({"peak_speed": [1.0, 2.0]}, r"peak_speed has shape \(2,\), must be \(6\)"),
        ({"peak_speed": [[1.0], [2.0, 3.0]]}, "peak_speed must be numbers"),
        ({"peak_speed": 1e9}, "joint j. "),
    ],
)
def test_joint_motions_that_cannot_be_run_are_refused(options, message):
    with pytest.raises(FFGymError, match=message):
        gym.make(JOINTS).reset(options=options)


ACTIONS = [
    (np.zeros(2), r"actions has shape \(2,\), must be \(2, 1\)"),
    (np.zeros((3, 1)), r"actions has shape \(3, 1\), must be \(2, 1\)"),
    (np.zeros((2, 2)), r"actions has shape \(2, 2\), must be \(2, 1\)"),
    ([[1.0], [1.0, 2.0]], "actions must be numbers"),
    ([[1.0], ["a"]], "actions must be numbers"),
    ("ab", "actions must be numbers"),
    (None, "actions has shape"),
    ([[0.0], [np.nan]], r"actions must be finite, but entry \(1, 0\) is nan"),
    ([[np.inf], [0.0]], r"actions must be finite, but entry \(0, 0\) is inf"),
]


@pytest.mark.parametrize("some_ended", [False, True])
@pytest.mark.parametrize(("action", "message"), ACTIONS)
def test_an_action_that_is_refused_moves_nothing(action, message, some_ended):
    layers = [LowPassAction(20.0), ResidualAction(Remembering()), History(2)]
    tried, untouched = (gym.make_vec(ONE_AXIS, num_envs=2, layers=layers) for _ in range(2))
    horizons = [{}, {}] if not some_ended else [{}, {"horizon": 1}] if "0, 0" in message else [{"horizon": 1}, {}]
    for env in (tried, untouched):
        env.reset(seed=1, options={"each": horizons})
        env.step(np.full((2, 1), 0.5))
    state = plant_state(tried)
    with pytest.raises(FFGymError, match=message):
        tried.step(action)
    np.testing.assert_array_equal(plant_state(tried), state)
    for _ in range(3):
        for one, two in zip(tried.step(np.ones((2, 1)))[:4], untouched.step(np.ones((2, 1)))[:4], strict=True):
            np.testing.assert_array_equal(one, two)


def test_the_action_of_a_sub_environment_that_begins_anew_is_ignored_whatever_it_is():
    env = gym.make_vec(ONE_AXIS, num_envs=2)
    env.reset(seed=1, options={"each": [{"horizon": 1}, {}]})
    env.step(np.zeros((2, 1)))
    *_, info = env.step([[np.nan], [0.5]])
    np.testing.assert_array_equal(info["time"] > 0, [False, True])


@pytest.mark.parametrize(
    "layers", [[], [ResidualAction(NoCompensation())], [ResidualAction(Remembering()), History(2), Hold(2)]]
)
def test_a_step_before_the_first_reset_is_refused(layers):
    for env, action in (
        (gym.make_vec(ONE_AXIS, num_envs=2, layers=layers), np.zeros((2, 1))),
        (gym.make(ONE_AXIS, layers=layers).unwrapped, [0.0]),
    ):
        with pytest.raises(FFGymError, match=r"Sub-environments \[0.*\] have no episode running; call reset"):
            env.step(action)


def test_a_first_reset_of_some_only_is_refused_even_after_a_failed_one():
    env = gym.make_vec(ONE_AXIS, num_envs=2, autoreset_mode="Disabled")
    with pytest.raises(FFGymError, match="horizon"):
        env.reset(seed=1, options={"horizon": -1})
    with pytest.raises(FFGymError, match="The first reset must be of all sub-environments"):
        env.reset(options={"reset_mask": MASK})


@pytest.mark.parametrize(
    ("action", "message"),
    [([0.0, 0.0], r"action has shape \(2,\), must be \(1\)"), ([[0.0], [0.0, 1.0]], "action must be numbers")],
)
def test_an_action_for_one_robot_is_named_as_such(action, message):
    env = gym.make(ONE_AXIS).unwrapped
    env.reset(seed=0)
    with pytest.raises(FFGymError, match=message):
        env.step(action)


def test_a_base_agent_that_answers_nonsense_is_blamed_by_name():
    class Wrong(Remembering):
        answer = np.zeros((2, 3))

        def predict(self, *args, **kwargs):
            return self.answer, None

    agent = Wrong()
    env = gym.make_vec(ONE_AXIS, num_envs=2, layers=[LowPassAction(5.0), ResidualAction(agent)])
    env.reset(seed=0)
    with pytest.raises(FFGymError, match=r"actions of the base agent has shape \(2, 3\), must be \(2, 1\)"):
        env.step(np.zeros((2, 1)))
    agent.answer = np.full((2, 1), np.nan)
    with pytest.raises(FFGymError, match=r"actions of the base agent must be finite"):
        env.step(np.zeros((2, 1)))
    agent.answer = np.zeros((2, 1))
    assert np.isfinite(env.step(np.zeros((2, 1)))[0]).all()  # the filter has not learnt the NaN


def test_a_law_for_another_robot_is_refused(irb4600):
    env = gym.make(ONE_AXIS, layers=[ResidualAction(StaticLuGre(irb4600.friction))])
    with pytest.raises(FFGymError, match="6 joints does not fit robot 'one_axis'"):
        env.reset(seed=0)


def test_a_recorder_serves_one_environment_and_its_own_sample_time():
    recorder = EpisodeRecorder()
    first, second = (gym.make(ONE_AXIS, recorder=recorder, horizon=2) for _ in range(2))
    first.reset(seed=0)
    with pytest.raises(FFGymError, match="serves one environment; make one for each"):
        second.reset(seed=0)
    first.step([0.0])
    first.step([0.0])
    assert len(recorder.recordings) == 1
    with pytest.raises(FFGymError, match=r"record_dt = 0.003 s must be a multiple of physics_dt"):
        gym.make(ONE_AXIS, recorder=EpisodeRecorder(record_dt=0.003)).reset(seed=0)
