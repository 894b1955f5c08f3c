"""Pictures of episodes: what they show, that they change nothing, and what happens without OpenGL."""

import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import ffgym  # noqa: F401  (registers the environments)
from ffgym.core.errors import FFGymError
from ffgym.envs import CirclePathVectorEnv, Hold
from ffgym.envs.rendering import Rendering

SMALL = Rendering(width=320, height=180)
MOTIONS = {
    "ffgym/CirclePath-v0": {"positions": ["p1"], "speeds": [0.04]},
    "ffgym/OneAxis-v0": {"frequencies": [3.0]},
    "ffgym/JointMotion-v0": {"peak_speeds": (10.0, 20.0)},
    "ffgym/FollowPath-v0": {"path": "square"},
}


def make(name="ffgym/CirclePath-v0", render_mode="rgb_array", rendering=SMALL, **arguments):
    return gym.make(
        name, render_mode=render_mode, rendering=rendering, **(MOTIONS[name] | arguments), disable_env_checker=True
    ).unwrapped


def run(env, steps, seed=0):
    env.reset(seed=seed)
    for _ in range(steps):
        env.step(np.zeros(env.action_space.shape))
    return env


def reddish(picture):
    """How many pixels of the right half have the colour of the trail."""
    half = picture[:, picture.shape[1] // 2 :].astype(int)
    return int(np.sum((half[..., 0] > 150) & (half[..., 1] < 90) & (half[..., 2] < 110)))


@pytest.fixture(autouse=True)
def _gl(needs_gl):
    """All tests of this file draw."""


@pytest.mark.parametrize("name", MOTIONS)
def test_a_picture_has_the_size_that_was_asked_for_and_changes_as_the_robot_moves(name):
    env = make(name)
    first = run(env, 0).render()
    assert first.shape == (180, 320, 3)
    assert first.dtype == np.uint8
    later = run(env, 150).render()
    assert np.mean(first != later) > 0.01
    env.close()


def test_the_same_episode_gives_the_same_pictures():
    env = make()
    first = run(env, 100).render()
    assert np.array_equal(first, env.render())
    assert np.array_equal(first, run(env, 100).render())
    env.close()


def test_rendering_does_not_change_the_episode():
    plain, drawn = make(render_mode=None, rendering=Rendering()), make()
    a, _ = plain.reset(seed=3)
    b, _ = drawn.reset(seed=3)
    for k in range(60):
        assert np.array_equal(a, b)
        if k % 20 == 0:
            drawn.render()
        action = np.full(6, 0.1 * (-1) ** k)
        a, reward, *_ = plain.step(action)
        b, same, *_ = drawn.step(action)
        assert reward == same
    drawn.close()


def test_a_vector_environment_gives_one_picture_each_and_each_its_own():
    env = gym.make_vec("ffgym/CirclePath-v0", num_envs=2, render_mode="rgb_array", rendering=SMALL, speeds=[0.04])
    env.reset(seed=0, options={"each": [{"position": "p1"}, {"position": "p3"}]})
    pictures = env.render()
    assert isinstance(pictures, tuple)
    assert [p.shape for p in pictures] == [(180, 320, 3)] * 2
    assert not np.array_equal(*pictures)
    env.close()


def test_a_vector_environment_refuses_a_window():
    with pytest.raises(FFGymError, match="shows one robot, num_envs = 2"):
        gym.make_vec("ffgym/CirclePath-v0", num_envs=2, render_mode="human")


def test_an_unknown_render_mode_is_named():
    with pytest.raises(FFGymError, match=r"Unknown render_mode 'ansi'\. Available: human, rgb_array"):
        CirclePathVectorEnv(render_mode="ansi")


def test_magnification_moves_the_trail_and_nothing_else():
    pictures = []
    for magnify in (1e-6, 5, 10):
        env = make(rendering=Rendering(magnify=magnify, width=480, height=270))
        pictures.append(run(env, 200).render())
        env.close()
    for a, b in ((0, 1), (1, 2)):
        assert not np.array_equal(pictures[a][:, 240:], pictures[b][:, 240:])
        assert np.array_equal(pictures[a][:, :240], pictures[b][:, :240])


def test_a_new_episode_empties_the_trail():
    env = make(rendering=Rendering(width=480, height=270))
    fresh = run(env, 0).render()
    drawn = run(env, 200).render()
    assert reddish(drawn) > 3 * reddish(fresh)
    env.reset(seed=0)
    assert np.array_equal(env.render(), fresh)
    env.close()


@pytest.mark.parametrize("name", ["ffgym/CirclePath-v0", "ffgym/FollowPath-v0"])
def test_the_drawn_deviation_is_as_long_as_the_path_error(name):
    env = make(name)
    env.reset(seed=0)
    errors = [0.0]
    for _ in range(300):
        *_, info = env.step(np.zeros(6))
        errors.append(info["path_error"])
    trail = env._batch._renderer._tracks[0].trail
    assert max(errors) > 5e-5
    assert np.linalg.norm(trail[:, 3:6], axis=1) == pytest.approx(errors, abs=1e-12)
    tcp = env.core.signals.tcp[0] - env.core.tcp_offset[0]
    assert np.linalg.norm(trail[-1, :3] + trail[-1, 3:6] - tcp) < 5e-5  # but for what is across a circle's plane
    env.close()


def test_the_trail_has_every_control_step_under_a_layer_that_holds_actions():
    plain, held = make(), make(layers=(Hold(10),))
    run(plain, 100)
    run(held, 10)
    one, other = plain._batch._renderer._tracks[0].trail, held._batch._renderer._tracks[0].trail
    assert len(one) == len(other) == 101
    assert np.array_equal(one, other)
    plain.close()
    held.close()


def test_gymnasiums_checker_accepts_the_rendering():
    env = make()
    env.metadata = env.metadata | {"render_modes": ["rgb_array"]}  # a window needs a screen
    check_env(env, skip_render_check=False)


def test_an_environment_that_was_closed_draws_no_more():
    env = run(make(), 3)
    env.close()
    env.close()
    with pytest.raises(FFGymError, match="is closed"):
        env.render()
    with pytest.raises(FFGymError, match="is closed"):
        env.step(env.action_space.sample())


def test_environments_draw_side_by_side_and_from_any_thread():
    one, other = run(make(), 50), run(make("ffgym/OneAxis-v0"), 50)
    first, second = one.render(), other.render()
    with ThreadPoolExecutor(1) as pool:
        assert np.array_equal(pool.submit(one.render).result(), first)
        assert np.array_equal(pool.submit(other.render).result(), second)
    one.close()
    assert np.array_equal(other.render(), second)
    other.close()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"magnify": 0.0}, "magnify = 0.0 is out of range"),
        ({"magnify": "much"}, "magnify must be a number"),
        ({"width": 10}, "width = 10.0 pixel is out of range"),
        ({"height": 99.5}, "height = 99.5 must be a whole number"),
    ],
)
def test_a_picture_that_cannot_be_drawn_is_refused(arguments, message):
    with pytest.raises(FFGymError, match=message):
        Rendering(**arguments)


@pytest.mark.parametrize("magnify", [None, 7.0])
def test_the_magnification_that_is_drawn_is_round_or_what_was_asked_for(magnify):
    env = run(make(rendering=Rendering(magnify=magnify, width=64, height=64)), 0)
    assert env._batch._renderer._tracks[0].magnify == (5.0 if magnify is None else magnify)
    env.close()


def test_the_example_of_the_documentation_runs():
    text = (Path(__file__).parents[2] / "docs" / "rendering.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", text, flags=re.S)
    names: dict[str, object] = {}
    exec(compile(block, "rendering.md", "exec"), names)
    assert names["picture"].shape == (540, 960, 3)
