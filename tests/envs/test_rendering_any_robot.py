"""Pictures of robots of other kinds: without tool, with slides, without looks."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

import ffgym  # noqa: F401  (registers the environments)
from ffgym.effects import EFFECTS
from ffgym.envs.rendering import Rendering
from ffgym.robot import builtin_robots, load_robot
from ffgym.simulation.plant import Machine

SMALL = Rendering(width=320, height=180)


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
        half = picture[40:140, 40:120].reshape(-1, 3)  # of the left half, without captions
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
    assert env.render().shape == (180, 320, 3)
    np.testing.assert_array_equal(data.qpos, env.core.plant.batch.qpos[0])
    np.testing.assert_allclose(data.site("tcp").xpos, env.core.plant.batch.bind("site_xpos")[0, -1], atol=1e-12)
    env.close()


def test_the_plot_shows_the_joint_that_moves_most_of_its_range_and_its_error_behind_the_gearbox(irb4600, needs_gl):
    robot = without_tool(irb4600)
    ratio = robot.drive.gear_ratio * np.array([1, 1, -1, 1, 1, 1])
    robot = replace(robot, drive=replace(robot.drive, gear_ratio=ratio))
    env = run(robot, options={"peak_speed": [0, 0, 15.0, 0, 0, 0], "centre": np.zeros(6)})
    track = env._batch._renderer._tracks[0]
    reference = env.core.motions[0].reference.q[:61, 2]
    np.testing.assert_allclose(track.trail[:, 0], reference, atol=1e-12)
    assert track.trail[-1, 1] == pytest.approx(-env.core.signals.error[0, 2] / ratio[2], abs=1e-15)
    plot = track.close_up()
    assert plot.title.startswith("j3 [deg]")
    red, blue = (plot.linedata[k, : 2 * plot.linepnt[k]].reshape(-1, 2) for k in range(2))
    np.testing.assert_allclose(blue[[0, -1], 1], np.rad2deg(reference[[0, -1]]), rtol=1e-5)
    np.testing.assert_allclose(blue[[0, -1], 0], [-60 * 0.004, 0.0], atol=1e-6)  # seconds before now
    np.testing.assert_allclose(red[-1, 1] - blue[-1, 1], track.magnify * np.rad2deg(track.trail[-1, 1]), atol=1e-4)
    env.close()


def test_errors_of_all_motors_are_plotted_in_milliradians_within_their_span(irb4600, needs_gl):
    env = run(irb4600, steps=100)
    plot = env._batch._renderer._tracks[0].motor_errors()
    last = [plot.linedata[k, 2 * plot.linepnt[k] - 1] for k in range(6)]
    np.testing.assert_allclose(last, 1e3 * env.core.signals.error[0], rtol=1e-5)
    low, high = plot.range[1]
    assert -low == high >= np.abs(last).max()
    env.close()


def test_a_slide_is_shown_in_millimetres(needs_gl):
    env = run(load_robot("ball_screw"))
    track = env._batch._renderer._tracks[0]
    assert "[mm]" in track.close_up().title
    assert track.values()[1].count(" mm") == 2
    env.close()
