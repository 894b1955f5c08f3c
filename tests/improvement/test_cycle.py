"""The whole cycle with the real diagnosis, on one axis: it ends, and what it found compensates on other motions."""

from contextlib import contextmanager

import numpy as np
import pytest

from ffgym.agents.lugre import dynamic_lugre
from ffgym.agents.model import model_law
from ffgym.diagnosis import diagnose
from ffgym.effects import EFFECTS
from ffgym.improvement import Plan
from ffgym.improvement.rounds import improve_in_rounds
from ffgym.paths import joint_reference, multisine
from ffgym.recordings.metrics import motor_error_rms
from ffgym.robot import RigidArm
from ffgym.simulation import Run, SimulatedRig, sensors_of
from ffgym.simulation.plant import Machine

NUMBERS = {"torque_offset"}
"""Effects that stand for numbers which are fitted beside causes: the zero point of the torque signal."""


@contextmanager
def quiet(title, unit):
    yield lambda done, total: None


@pytest.fixture(scope="module")
def rig(one_axis):
    hidden = EFFECTS["coulomb_level"].on(one_axis, change=0.4)
    machine = Machine(robot=one_axis, effects=(hidden,))
    return SimulatedRig(arm=RigidArm(one_axis), machine=machine, sensors=sensors_of(one_axis), name="axis")


@pytest.fixture(scope="module")
def rounds(rig, tmp_path_factory):
    nominal = Machine(robot=rig.robot)
    plan = Plan(nominal=nominal, robot=rig.robot.name, rounds=4, n_threads=1)

    def ask(machine, recordings, prior, most):
        return diagnose(machine, recordings, prior=prior, most=most)

    return improve_in_rounds(rig, plan, tmp_path_factory.mktemp("cycle"), ask, quiet)


def test_the_cycle_ends_when_recordings_do_not_falsify_the_model_any_more(rounds, rig):
    assert rounds[-1].diagnosis.verdict == "none"
    named = {effect.name for effect in rounds[-1].machine.effects} - NUMBERS
    assert named == {effect.name for effect in rig.machine.effects}


def test_the_extended_model_compensates_on_a_motion_that_no_round_recorded(rounds, rig):
    robot = rig.robot
    path = multisine(np.zeros(1), np.full((2, 1), 0.04), [0.37, 1.1], np.zeros((2, 1)), 4.0, ramp=0.5, dwell=0.2)
    reference = joint_reference(robot, path)
    laws = [dynamic_lugre(robot), model_law(rounds[-1].machine, rig.arm)]
    before, after = (motor_error_rms(one)[0] for one in rig.run([Run(reference=reference, law=law) for law in laws]))
    assert after < 0.3 * before
