"""Pictures of robots of other kinds: without tool, with slides, without looks."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

import ffgym  # noqa: F401  (registers the environments)
from ffgym.effects import EFFECTS
from ffgym.envs.rendering import Rendering
from ffgym.envs.rendering.gauge import Dial, Ruler
from ffgym.robot import builtin_robots, load_robot
from ffgym.simulation.plant import Machine

SMALL = Rendering(width=192, height=108)


def without_tool(robot):
    return replace(robot, tool=None, work_area=None, geoms=())


def run(robot, steps=60, options=None):
    env = gym.make(
        "ffgym/JointMotion-v0", robot=robot, render_mode="rgb_array", rendering=SMALL, disable_env_checker=True
    ).unwrapped
    env.reset(seed=0, options=options)
    for _ in range(steps):
        env.step(np.zeros(env.action_space.shape))
    return env


@pytest.mark.parametrize("name", builtin_robots())
def test_every_robot_can_be_drawn_with_and_without_looks(name, needs_gl):
    pictures = []
    for robot in (load_robot(name), replace(load_robot(name), geoms=())):
        env = run(robot, steps=30)
        picture = env.render()
        pictures.append(picture)
        half = picture[20:90, 20:76].reshape(-1, 3)  # of the left half, without captions
        assert len(np.unique(half, axis=0)) > 50  # more than sky and floor
        env.close()
    assert not np.array_equal(*pictures)


def test_a_machine_is_drawn_with_the_joints_that_its_effects_add(irb4600, needs_gl):
    base = EFFECTS["base_flexibility"].on(irb4600, compliance=3e-7)
    env = gym.make(
        "ffgym/CirclePath-v0",
        plant=Machine(robot=irb4600, effects=(base,)),
        render_mode="rgb_array",
        rendering=SMALL,
        disable_env_checker=True,
    ).unwrapped
    env.reset(seed=0)
    data = env._batch._renderer._data
    assert env.render().shape == (108, 192, 3)
    np.testing.assert_array_equal(data.qpos, env.core.plant.batch.qpos[0])
    np.testing.assert_allclose(data.site("tcp").xpos, env.core.plant.batch.bind("site_xpos")[0, -1], atol=1e-12)
    env.close()


def test_the_gauge_shows_the_joint_that_moves_most_of_its_range_and_its_error_behind_the_gearbox(irb4600, needs_gl):
    robot = without_tool(irb4600)
    ratio = robot.drive.gear_ratio * np.array([1, 1, -1, 1, 1, 1])
    robot = replace(robot, drive=replace(robot.drive, gear_ratio=ratio))
    env = run(robot, options={"peak_speed": [0, 0, 15.0, 0, 0, 0], "centre": np.zeros(6)})
    renderer = env._batch._renderer
    trail = renderer._trails.of(0)
    reference = env.core.motions[0].reference.q[:61, 2]
    np.testing.assert_allclose(trail[:, 0], reference, atol=1e-12)
    assert trail[-1, 1] == pytest.approx(-env.core.signals.error[0, 2] / ratio[2], abs=1e-15)
    captions = [c.text for panel in renderer._view.panels(0, renderer._model, trail, 0.5) for c in panel.captions]
    assert any(text.startswith("j3\n") for text in captions)
    env.close()


def test_a_slide_has_a_ruler_with_millimetres(needs_gl):
    env = run(load_robot("ball_screw"))
    renderer = env._batch._renderer
    panels = renderer._view.panels(0, renderer._model, renderer._trails.of(0), 0.5)
    text = " ".join(caption.text + caption.values for panel in panels for caption in panel.captions)
    assert "mm" in text
    assert "deg" not in text
    env.close()


def test_a_ruler_is_as_long_as_its_picture_whatever_the_range():
    for low, high in ((-0.01, 0.26), (0.0, 3.0)):
        ruler = Ruler(np.zeros(3), 2.0, np.array([low, high]))
        ends = ruler.points(np.zeros(2), np.array([low, high]))
        np.testing.assert_allclose(np.abs(ends[:, 0]), 0.9 * 2.0)
        older = ruler.points(np.array([0.0, 1.0]), np.array([low, low]))
        assert older[1, 1] < older[0, 1]
        ticks = len(ruler.marks()) - 1
        assert 9 <= ticks <= 60
    assert ruler.text(0.0125, 1) == "12.5 mm"


def test_a_dial_turns_counterclockwise_from_the_right():
    dial = Dial(np.array([1.0, 2.0, 3.0]), 0.5)
    points = dial.points(np.zeros(2), np.array([0.0, np.pi / 2])) - [1.0, 2.0, 3.0]
    np.testing.assert_allclose(points, [[0.5, 0, 0], [0, 0.5, 0]], atol=1e-15)
    assert np.linalg.norm(dial.points(np.ones(1), np.zeros(1)) - dial.centre) < 0.5
    assert dial.text(np.pi, 1) == "180.0 deg"
