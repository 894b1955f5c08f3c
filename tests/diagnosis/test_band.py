"""The band that a log is compared in: of a rigid model, where its motion lies and what repeats with its motors."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.band import choose_cutoff, compute_motion_bandwidth
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.settings import settings
from ffgym.paths import joint_reference, multisine
from ffgym.recordings import Recording
from ffgym.robot import load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine

FREQUENCIES = [0.2, 0.5]


def rigid(robot):
    return replace(robot, drive=replace(robot.drive, joint_stiffness=np.full(robot.n_joints, np.inf)))


@pytest.fixture(scope="module")
def swing():
    """Both joints of a small arm whose joints are rigid swing slowly; rows of 10 ms."""
    robot = rigid(load_robot("two_link"))
    centre = robot.kinematics.range.mean(axis=1)
    amplitude, phases = np.array([[0.2, 0.25], [0.06, 0.08]]), np.array([[0.0, 1.5], [2.0, 0.5]])
    motion = multisine(centre, amplitude, FREQUENCIES, phases, 30.0, ramp=2.0, dwell=0.2)
    return simulate([Run(reference=joint_reference(robot, motion))], machine=Machine(robot=robot), n_threads=1)[0]


def logged(recording, added=lambda recording, joint: 0.0):
    """Angles and torques every 10 ms with noise, and what is added to the torques."""
    rng = np.random.default_rng(3)
    names = recording.header.joints
    columns = {"timestamp": recording.t}
    for j, joint in enumerate(names):
        n = len(recording.t)
        columns[f"motor.position.{joint}"] = recording[f"motor.position.{joint}"] + rng.normal(scale=2e-5, size=n)
        columns[f"motor.effort.{joint}"] = (
            recording[f"motor.effort.{joint}"] + rng.normal(scale=0.01, size=n) + added(recording, j)
        )
    every = round(0.01 / recording.dt)
    return Recording({name: values[::every] for name, values in columns.items()}, recording.header)


def vibration(recording, joint):
    """A flexible mode at 15 Hz that the rigid model does not know, as loud as friction."""
    return 1.5 * np.sin(2 * np.pi * 15.0 * recording.t + joint) * (1 + 0.3 * np.sin(1.3 * recording.t))


def ripple(recording, joint):
    """Torque that repeats with the turns of each motor."""
    angle = recording.joint_array("motor.position")[:, joint]
    return 1.5 * np.sin(2.0 * angle)


def test_the_bandwidth_of_a_motion_is_that_of_its_fastest_sine_whatever_the_noise(swing):
    log = assemble_log(rigid(load_robot("two_link")), [logged(swing)])
    assert max(FREQUENCIES) <= compute_motion_bandwidth(log) < 2 * max(FREQUENCIES)


@pytest.mark.parametrize(
    ("added", "is_narrow"), [(lambda recording, joint: 0.0, False), (vibration, True), (ripple, False)]
)
def test_a_rigid_model_is_compared_below_what_it_cannot_know_but_ripple_is_kept(swing, added, is_narrow):
    robot = rigid(load_robot("two_link"))
    log = assemble_log(robot, [logged(swing, added)])
    cutoff = choose_cutoff(log, Machine(robot=robot))
    if is_narrow:
        assert settings().sampling.lowest_cutoff <= cutoff < 10.0
    else:
        assert cutoff == log.sampling.cutoff


def test_an_elastic_model_knows_its_modes_and_keeps_the_usual_band(swing):
    robot = load_robot("two_link")
    log = assemble_log(robot, [logged(swing, vibration)])
    assert choose_cutoff(log, Machine(robot=robot)) == log.sampling.cutoff
