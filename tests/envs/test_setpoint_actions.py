"""Environments whose actions correct set-points."""

import gymnasium as gym
import numpy as np
import pytest

import ffgym  # noqa: F401  registers the environments
from ffgym.agents import LawAgent, elastic_feedforward
from ffgym.control import SetpointChannel
from ffgym.core.errors import FFGymError
from ffgym.envs import EpisodeRecorder
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription
from ffgym.simulation import Run, simulate

CIRCLE = {"positions": ["p1"], "speeds": [0.1], "radii": [0.003], "preview": 8, "action_scale": 200.0}


def make(n: int = 1, **arguments: object) -> gym.vector.VectorEnv:
    """Make circle environments with the set-point channel."""
    return gym.make_vec("ffgym/CirclePath-v1", num_envs=n, **({"channel": "setpoint"} | CIRCLE | arguments))


def run(env: gym.vector.VectorEnv, agent: LawAgent | None) -> list[dict]:
    """Run one episode; return the info of each step."""
    observation, _ = env.reset(seed=0)
    state, infos, ended = None, [], False
    while not ended:
        action = np.zeros((1, 6))
        if agent is not None:
            action, state = agent.predict(observation, state)
        observation, _, terminated, truncated, info = env.step(action)
        infos.append(info)
        ended = bool((terminated | truncated)[0])
    return infos


@pytest.fixture(scope="module")
def recorded(irb4600: RobotDescription) -> tuple[Recording, Recording, Recording]:
    """The elastic law as an agent, as the base, and simulated, all through set-points."""
    law, recordings = elastic_feedforward(irb4600), []
    for as_base in (False, True):
        recorder = EpisodeRecorder()
        env = make(base=law if as_base else "none", recorder=recorder)
        run(env, None if as_base else LawAgent.for_env(law, env))
        recordings += recorder.recordings
        reference = env.unwrapped.core.motions[0].reference
        env.close()
    [simulated] = simulate([Run(reference=reference, law=law, channel=SetpointChannel())])
    return recordings[0], recordings[1], simulated


def test_a_law_as_agent_moves_the_machine_as_in_a_simulation(recorded: tuple[Recording, ...]) -> None:
    agent, _, simulated = recorded
    for family in ("motor.position", "reference.position", "correction.position", "feedback.effort"):
        np.testing.assert_allclose(agent.joint_array(family), simulated.joint_array(family), atol=1e-8)


def test_a_base_moves_the_machine_as_in_a_simulation(recorded: tuple[Recording, ...]) -> None:
    _, base, simulated = recorded
    for family in ("motor.position", "correction.position", "feedback.effort"):
        np.testing.assert_allclose(base.joint_array(family), simulated.joint_array(family), atol=1e-9)


def test_an_action_of_one_moves_the_set_point_by_its_size() -> None:
    recorder = EpisodeRecorder()
    env = make(action_scale=0.5, recorder=recorder, horizon=3)
    size, robot = env.unwrapped.action_size, env.unwrapped.core.robot
    np.testing.assert_allclose(size, 0.5 * robot.friction.static / robot.servo.position_gain)
    observation, _ = env.reset(seed=0)
    layout = env.unwrapped.observation_layout
    for _ in range(3):
        observation, _, _, truncated, info = env.step(np.ones((1, 6)))
        np.testing.assert_allclose(layout.read(observation, "added_setpoint")[0], size)
    assert truncated[0]
    [recording] = recorder.recordings
    np.testing.assert_allclose(recording.joint_array("correction.position")[4::4], np.tile(size, (3, 1)), rtol=1e-12)
    np.testing.assert_allclose(info["u_c"][0], recording.joint_array("feedback.effort")[-1], atol=1e-9)
    with pytest.raises(FFGymError, match="correct set-points, see its action_size"):
        _ = env.unwrapped.action_torque
    env.close()


def test_an_episode_goes_on_from_a_saved_state_to_the_bit() -> None:
    env = make(2)
    env.reset(seed=0)
    rng = np.random.default_rng(0)
    core = env.unwrapped.core
    for _ in range(5):
        env.step(0.01 * rng.standard_normal((2, 6)))
    saved, actions = core.save(), 0.01 * rng.standard_normal((4, 2, 6))
    first = [env.step(action)[0] for action in actions]
    core.restore(saved)
    again = [env.step(action)[0] for action in actions]
    assert np.array_equal(first, again)
    env.close()


def test_an_unknown_channel_is_refused() -> None:
    with pytest.raises(FFGymError, match=r"Unknown channel 'current'. Available: setpoint, torque"):
        make(channel="current")
