"""The same questions to every robot that ships; a new description is picked up by itself."""

import subprocess
import sys
from contextlib import suppress
from dataclasses import replace
from functools import cache

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import ffgym  # noqa: F401 - registers the environments
from ffgym.agents.catalogue import CATALOGUE, make_law
from ffgym.agents.declaration import AgentSetting
from ffgym.cli.main import main
from ffgym.control import NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.paths.motions import list_motions, load_motion
from ffgym.recordings import read_recording, write_recording
from ffgym.recordings.metrics import motor_error
from ffgym.robot import RigidArm, builtin_robots, load_robot, resonances
from ffgym.simulation import Run, sensors_of, simulate
from ffgym.simulation.plant import Plant, PlantDistribution
from ffgym.studies import circle_references, sine_references

ROBOTS = builtin_robots()
IDEAL = ["lugre_static", "lugre_dynamic", "elastic", "oracle"]
"""They know the robot and learn nothing."""
PROGRAMS = ("cut_bracket", "thesis_circles", "laser_plate")
"""Built-in RAPID programs."""
LEARNED = [name for name in CATALOGUE if name not in ("none", *IDEAL)]

LIKE_ANOTHER = {"kuka_kr300_r2500", "two_link"}
"""Robots whose commands only the slow tests run: six axes and rigid joints, as others that the usual tests run."""
every_robot = pytest.mark.parametrize("name", ROBOTS)


@cache
def arm_of(name):
    return RigidArm(load_robot(name))


@cache
def reference_of(name):
    """The slowest test motion of a robot: circles at its first position, or the sine."""
    arm = arm_of(name)
    if arm.robot.work_area is None:
        return sine_references(arm.robot, [1.0])[1.0]
    position = next(iter(arm.robot.work_area.positions))
    return circle_references(arm, [position], [0.010], [0.001])[position, 0.010]


def reference_pose(name):
    robot = arm_of(name).robot
    return np.zeros(robot.n_joints) if robot.work_area is None else robot.work_area.home


@every_robot
def test_links_have_inertia_in_every_direction_that_joints_move(name):
    mass = arm_of(name).mass_matrix(reference_pose(name)[None])[0]
    np.testing.assert_allclose(mass, mass.T)
    assert np.linalg.eigvalsh(mass).min() > 0


@every_robot
def test_it_rests_where_it_is_put(name):
    robot = arm_of(name).robot
    plant = Plant(robot, 1)
    plant.rest(reference_pose(name)[None])
    start = plant.state()
    controls = np.zeros((1, 200, plant.model.nu))
    plant.split_controls(controls)[0][:] = robot.drive.motor_angle(reference_pose(name))
    plant.drive(controls)
    np.testing.assert_allclose(plant.state().motor_position, start.motor_position, atol=1e-8)


@every_robot
def test_its_drives_can_hold_it_and_have_torque_to_spare(name):
    arm = arm_of(name)
    drive = arm.robot.drive
    q = reference_of(name).q[::50]
    load = drive.motor_torque(arm.holding_torque(q))
    assert np.all(np.abs(load) + arm.robot.friction.static < 0.9 * drive.peak_torque)


@every_robot
def test_its_resonances_are_those_of_a_machine(name):
    arm = arm_of(name)
    if arm.robot.drive.is_rigid.any():
        assert arm.robot.drive.is_rigid.all()  # nothing to resonate
        return
    lowest = resonances(arm, reference_pose(name))[0]
    assert 2 < lowest < 200


@every_robot
@pytest.mark.parametrize("law", IDEAL)
def test_compensation_of_its_own_friction_makes_it_better(name, law):
    if CATALOGUE[law].needs_arm and arm_of(name).robot.tool is None:
        return
    reference = reference_of(name)
    setting = AgentSetting.of(arm_of(name).robot, references=[reference])
    runs = [Run(reference=reference, law=chosen) for chosen in (NoCompensation(), make_law(law, setting))]
    none, compensated = (motor_error(recording) for recording in simulate(runs))
    if law in ("lugre_static", "lugre_dynamic"):  # the others lead the reference on purpose
        assert np.sqrt(np.mean(compensated**2)) < 0.8 * np.sqrt(np.mean(none**2))
    assert np.isfinite(compensated).all()


@every_robot
@pytest.mark.slow
@pytest.mark.parametrize("law", LEARNED)
def test_every_family_learns_on_it(name, law):
    entry = CATALOGUE[law]
    if entry.needs_arm and arm_of(name).robot.tool is None:
        return
    reference = reference_of(name)
    learned = make_law(law, AgentSetting.of(arm_of(name).robot, references=[reference]))
    runs = [Run(reference=reference, law=chosen) for chosen in (NoCompensation(), learned)]
    none, compensated = (motor_error(recording) for recording in simulate(runs))
    if law != "ilc_tcp":
        assert np.sqrt(np.mean(compensated**2)) < np.sqrt(np.mean(none**2))


@every_robot
def test_environments_that_fit_run_it(name):
    robot = arm_of(name).robot
    ids = ["ffgym/JointMotion-v0"]
    ids += ["ffgym/OneAxis-v0"] if robot.n_joints == 1 else []
    ids += ["ffgym/CirclePath-v0"] if robot.work_area is not None else []
    for identity in ids:
        env = gym.make(identity, robot=name)
        check_env(env.unwrapped, skip_render_check=True)
        env.reset(seed=1)
        for _ in range(20):
            observation, reward, *_ = env.step(np.zeros(env.action_space.shape))
        assert np.isfinite(observation).all()
        assert np.isfinite(reward)
        env.close()


FOR_THE_SIX_AXES = ("rounded_square", "spiral", "tilted_circles", "low_circles")


@every_robot
def test_built_in_motions_fit_it(name):
    arm = arm_of(name)
    for motion in list_motions():
        if motion == "square" and name == "two_link":  # it is level, the arm upright
            with pytest.raises(FFGymError, match="plane with normal"):
                load_motion(arm, motion)
        elif motion in ("circles", "square", *FOR_THE_SIX_AXES) and arm.robot.work_area is None:
            with pytest.raises(FFGymError, match="no named points in its work area"):
                load_motion(arm, motion)
        elif motion in (*PROGRAMS, *FOR_THE_SIX_AXES) and name != "irb4600_60_205":  # its targets are made for that one
            with suppress(FFGymError):
                load_motion(arm, motion)
        else:
            reference = load_motion(arm, motion).reference
            assert reference.duration > 1
            assert np.any(reference.dq != 0)


@every_robot
def test_a_measured_recording_of_it_survives_its_file(name, tmp_path):
    robot = arm_of(name).robot
    (recording,) = simulate(
        [Run(reference=reference_of(name))], sensors=sensors_of(robot), record_dt=robot.servo.control_dt
    )
    write_recording(recording, tmp_path / "motion.csv")
    again = read_recording(tmp_path / "motion.csv")
    assert again.header == recording.header
    for column, values in recording.columns.items():
        np.testing.assert_array_equal(again[column], values)


@every_robot
def test_others_of_its_kind_are_drawn_and_simulated(name):
    robot = arm_of(name).robot
    drawn = replace(PlantDistribution(), payload=None).draw(robot, np.random.default_rng(0))
    plant = Plant(robot, 2)
    plant.become([1], [drawn])
    plant.rest(np.stack([reference_pose(name)] * 2))
    assert plant.fingerprint(0) != plant.fingerprint(1)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in LIKE_ANOTHER)) for name in ROBOTS]
)
def test_commands_run_it(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    robot = arm_of(name).robot
    small = ["--speeds-mm-s", "100"] if robot.work_area is not None else ["--frequencies-hz", "3"]
    assert main(["train", "bspline", "--robot", name, "--iterations", "1", *small]) == 0, capsys.readouterr().err
    assert main(["robot", "check", name, "--report", "check.html"]) == 0, capsys.readouterr().err
    assert main(["simulate", name, "sine", "--report", "motion.html"]) == 0, capsys.readouterr().err
    assert main(["export", name, "sine", "--out", "elsewhere"]) == 0, capsys.readouterr().err
    played = subprocess.run([sys.executable, "play.py"], cwd="elsewhere", capture_output=True, text=True, check=False)
    assert played.returncode == 0, played.stdout + played.stderr
    if robot.work_area is not None:
        position = next(iter(robot.work_area.positions))
        demo = ["demo", "--no-diagnosis", "--robot", name, "--positions", position, *small]
        assert main(demo) == 0, capsys.readouterr().err
