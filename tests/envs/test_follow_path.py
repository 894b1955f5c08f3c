"""Any motion as an environment: names, files and references; equal to the simulation bit for bit."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

import ffgym  # noqa: F401  (registers the environments)
from ffgym.control import StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.envs import EpisodeRecorder, ResidualAction
from ffgym.envs.motion import EpisodeMotion
from ffgym.paths import cartesian_reference, circle_test, joint_reference, joint_sine
from ffgym.paths.motions import load_motion
from ffgym.recordings.metrics import Contour
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import Run, simulate

NAME = "ffgym/FollowPath-v0"


def sine(robot, frequency=2.0, centre=None):
    path = joint_sine(
        [0.01] * robot.n_joints, frequency, 0.5, centre=centre, dt=robot.servo.control_dt, name=f"{frequency:g} Hz"
    )
    return joint_reference(robot, path)


def tilted(arm, speed=0.1, centre="p1", radius=0.003):
    point = arm.robot.position(centre)
    dt = arm.robot.servo.control_dt
    path = circle_test(point, speed, radii=[radius], normal=(1, 1, 2), dt=dt, name=f"tilted at {centre}, {speed:g} m/s")
    return cartesian_reference(arm, path)


def run(law=None, steps=None, **arguments):
    """Recording of an episode without action, and its infos."""
    recorder = EpisodeRecorder()
    layers = () if law is None else (ResidualAction(law),)
    env = gym.make(NAME, recorder=recorder, layers=layers, action_scale=30.0, **arguments)
    env.reset(seed=0)
    ended, infos = False, []
    while not ended:
        _, _, terminated, truncated, info = env.step(np.zeros(env.action_space.shape))
        ended = terminated or truncated
        infos.append(info)
    return recorder.recordings[0], infos


@pytest.mark.parametrize("robot", ["ball_screw", "one_axis"])
def test_a_joint_motion_equals_the_simulation_bit_for_bit(robot):
    robot = load_robot(robot)
    reference = sine(robot, centre=[0.1])
    (simulated,) = simulate([Run(reference=reference)])
    acted, _ = run(path=reference)
    assert acted.columns.keys() == simulated.columns.keys()
    for name in acted.columns:
        np.testing.assert_array_equal(acted[name], simulated[name], err_msg=name)


def test_a_path_in_any_plane_equals_the_simulation_with_and_without_a_law(arm, irb4600):
    reference = tilted(arm)
    law = StaticLuGre(irb4600.friction)
    plain, helped = simulate([Run(reference=reference), Run(reference=reference, law=law)], arm=arm)
    acted, _ = run(path=reference)
    for name in acted.columns:
        np.testing.assert_array_equal(acted[name], plain[name], err_msg=name)
    acted, _ = run(path=reference, law=law)
    for name in acted.columns:  # an action is torque / scale, which rounds
        np.testing.assert_allclose(acted[name], helped[name], rtol=0, atol=1e-9, err_msg=name)


def test_a_name_is_the_motion_that_load_motion_makes(arm):
    env = gym.make(NAME).unwrapped
    env.reset(seed=0)
    reference = load_motion(arm, "circles").reference
    np.testing.assert_array_equal(env.core.motions[0].reference.q, reference.q)
    assert env.core.motions[0].task == {"path": "circles"}


def test_one_of_a_list_is_drawn_and_a_sequence_runs_them_in_turn(one_axis):
    references = [sine(one_axis, f) for f in (1.0, 2.0, 3.0)]
    env = gym.make(NAME, path=references)
    drawn = [env.reset(seed=seed)[1]["task"] for seed in range(20)]
    assert set(drawn) == {"1 Hz", "2 Hz", "3 Hz"}
    envs = gym.make_vec(NAME, num_envs=3, path=references, sampling="sequence")
    assert envs.reset(seed=0)[1]["task"].tolist() == ["1 Hz", "2 Hz", "3 Hz"]


def test_an_episode_may_choose_its_motion(one_axis):
    first, second = sine(one_axis, 1.0), sine(one_axis, 2.0)
    env = gym.make(NAME, path=first)
    assert env.reset(seed=0, options={"path": second})[1]["task"] == "2 Hz"
    assert env.reset(seed=0, options={"path": [first]})[1]["task"] == "1 Hz"
    with pytest.raises(FFGymError, match="must be one motion"):
        env.reset(options={"path": [first, second]})


def test_the_robot_is_that_of_the_reference_unless_one_is_given(one_axis):
    reference = sine(one_axis)
    assert gym.make(NAME, path=reference).unwrapped.core.robot is one_axis
    again = load_robot("one_axis")  # another object with the same numbers
    assert gym.make(NAME, path=reference, robot=again).unwrapped.core.motions[0] is None


def test_a_motion_of_another_robot_is_refused(one_axis):
    with pytest.raises(FFGymError, match=r"'2 Hz' is for robot 'one_axis' with other numbers"):
        gym.make(NAME, path=["circles", sine(one_axis)], robot="irb4600_60_205")


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ([], "path is empty"),
        (3.0, "path = 3.0 must be the name of a motion"),
        ([None], "path = None must be"),
        ("nowhere", "nowhere"),
        ("absent.mod", r"absent\.mod"),
    ],
)
def test_what_is_no_motion_is_one_error(path, message):
    with pytest.raises(FFGymError, match=message):
        gym.make(NAME, path=path)


def test_a_robot_that_cannot_make_the_motion_says_so():
    with pytest.raises(FFGymError, match="'one_axis'"):
        gym.make(NAME, path="circles", robot="one_axis")


def test_the_path_error_needs_a_tool(one_axis):
    with pytest.raises(FFGymError, match="has no tool, so there is no path error"):
        gym.make(NAME, path=sine(one_axis), reward="path_error")


@pytest.mark.parametrize(("speed", "share"), [(0.01, 0.03), (0.04, 0.005)])  # the faster, the more curvature counts
def test_the_path_error_of_info_is_the_distance_to_the_path(arm, speed, share):
    recording, infos = run(path=tilted(arm, speed=speed))
    distance = Contour.of(recording).distance[4::4]
    seen = np.array([info["path_error"] for info in infos])
    moving = ~recording.mask(kind="standstill")[4::4]
    assert distance.max() > 5e-5
    np.testing.assert_allclose(seen[moving], distance[moving], atol=share * distance.max())


def test_circles_share_a_plane_only_if_they_share_their_centre(arm):
    one, other = (tilted(arm, centre=centre) for centre in ("p1", "p2"))
    assert np.any(EpisodeMotion(reference=one, arm=arm, task={}).plane[1])
    joined = {name: np.concatenate([getattr(one, name), getattr(other, name)]) for name in ("q", "dq", "ddq")}
    shift = one.t[-1] + one.robot.servo.control_dt
    phases = [replace(phase, end=min(phase.end, shift)) for phase in one.phases]
    phases += [replace(phase, start=phase.start + shift, end=phase.end + shift) for phase in other.phases]
    both = replace(one, t=np.concatenate([one.t, shift + other.t]), phases=tuple(phases), **joined)
    motion = EpisodeMotion(reference=both, arm=arm, task={})
    assert not np.any(motion.plane[1])
    rows, at = motion.rows(0), motion.columns
    assert not rows[:, at.radius].any()
    assert set(rows[:, at.circle]) == {-1.0, 0.0, 1.0}


def test_a_phase_called_circle_that_is_none_is_a_path_like_any_other(arm):
    reference = tilted(arm)
    called = tuple(replace(p, kind="circle" if p.kind == "lead_in" else p.kind) for p in reference.phases)
    crooked = replace(reference, phases=called)
    motion = EpisodeMotion(reference=crooked, arm=arm, task={}, in_space=True)
    assert not np.any(motion.plane[1])
    assert not motion.rows(0)[:, motion.columns.radius].any()
    with pytest.raises(FFGymError, match="The reference is no circle"):
        EpisodeMotion(reference=crooked, arm=arm, task={}).rows(0)  # in its plane no deviation is defined


def test_a_spec_with_a_reference_makes_the_same_environment(one_axis):
    env = gym.make(NAME, path=sine(one_axis), horizon=5)
    again = env.spec.make()
    np.testing.assert_array_equal(env.reset(seed=1)[0], again.reset(seed=1)[0])


def test_files_are_made_for_the_robot_that_was_given(irb4600):
    assert RigidArm(irb4600).robot is irb4600
    env = gym.make(NAME, robot=irb4600).unwrapped
    assert env.core.robot is irb4600
