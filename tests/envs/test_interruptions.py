"""What fails in the middle leaves no environment that goes on as if nothing had happened."""

import signal

import gymnasium as gym
import numpy as np
import pytest

from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError
from ffgym.envs import EpisodeRecorder, LowPassAction, MotorError, ResidualAction

ONE_AXIS = "ffgym/OneAxis-v0"


def test_a_refused_reset_leaves_the_memory_of_layers():
    tried, untouched = (gym.make(ONE_AXIS, layers=(LowPassAction(5.0),)) for _ in range(2))
    for env in (tried, untouched):
        env.reset(seed=0)
        for _ in range(5):
            env.step([1.0])
    with pytest.raises(FFGymError, match="Unknown reset option"):
        tried.reset(options={"foo": 1})
    np.testing.assert_array_equal(tried.step([1.0])[0], untouched.step([1.0])[0])


class HalfALaw(FeedForwardLaw):
    """Knows 1 Hz only."""

    name = "half"

    def torque(self, reference):
        return np.zeros_like(reference.q) if "1 Hz" in reference.name else np.zeros(3)


def test_after_a_reset_that_fails_in_a_layer_the_environment_waits_for_another():
    env = gym.make(ONE_AXIS, layers=(ResidualAction(HalfALaw()),))
    env.reset(seed=0, options={"frequency": 1.0})
    env.step([0.0])
    with pytest.raises(FFGymError, match="torque of feed-forward law 'half' has shape"):
        env.reset(options={"frequency": 3.0})
    with pytest.raises(FFGymError, match="no episode running"):
        env.step([0.0])
    assert env.reset(options={"frequency": 1.0})[1]["time"] == 0.0
    env.step([0.0])


class InterruptedReward(MotorError):
    """Raises what it is told to, once."""

    error: BaseException | None = None

    def __call__(self, signals, robot, stopped):
        if type(self).error is not None:
            error, type(self).error = type(self).error, None
            raise error
        return super().__call__(signals, robot, stopped)


@pytest.mark.parametrize("error", [KeyboardInterrupt(), RuntimeError("in a user's code")])
def test_a_step_that_fails_after_the_engine_has_moved_needs_a_reset(error):
    env = gym.make_vec(ONE_AXIS, num_envs=2, reward=InterruptedReward())
    env.reset(seed=0)
    env.step(np.zeros((2, 1)))
    InterruptedReward.error = error
    with pytest.raises(type(error)):
        env.step(np.zeros((2, 1)))
    with pytest.raises(FFGymError, match="no episode running; call reset"):
        env.step(np.zeros((2, 1)))
    env.reset(seed=0)
    fresh = gym.make_vec(ONE_AXIS, num_envs=2)
    fresh.reset(seed=0)
    np.testing.assert_array_equal(env.step(np.zeros((2, 1)))[0], fresh.step(np.zeros((2, 1)))[0])


def many_steps(env):
    for _ in range(600):
        env.step(np.zeros((16, 6)))


def test_ctrl_c_leaves_no_environment_out_of_step():
    env = gym.make_vec("ffgym/CirclePath-v0", num_envs=16, speeds=[0.1])
    env.reset(seed=0)
    signal.signal(signal.SIGALRM, lambda *_: (_ for _ in ()).throw(KeyboardInterrupt()))
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    try:
        with pytest.raises(KeyboardInterrupt):
            many_steps(env)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
    core = env.unwrapped.core
    in_step = np.allclose(core.plant.batch.time, core.time)
    assert in_step or not core.running.any()


def test_a_recorder_that_fails_needs_a_reset():
    def full_disk(recording):
        raise OSError("no space left on device")

    env = gym.make(ONE_AXIS, horizon=2, recorder=EpisodeRecorder(on_episode=full_disk))
    env.reset(seed=0)
    env.step([0.0])
    with pytest.raises(OSError, match="no space"):
        env.step([0.0])
    with pytest.raises(FFGymError, match="no episode running"):
        env.step([0.0])
