"""Springs that are much softer than described, whose swings are out of step with what slopes say."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.perturbation import replay_change
from ffgym.diagnosis.replay import replay
from ffgym.diagnosis.sensitivity import compute_sensitivities, compute_stiffness_sensitivities
from ffgym.diagnosis.variant import add_effect
from ffgym.effects.transmission.stiffness import JointStiffness
from tests.diagnosis.replay.replay_samples import nominal, recorded


@pytest.fixture(scope="module")
def run():
    """Replay on springs that hardly damp; the log begins in the middle of its motion, so that the arm swings."""
    robot = nominal().robot
    drive = replace(robot.drive, joint_damping=0.3 * robot.drive.joint_damping)
    light = replace(nominal(), robot=replace(robot, drive=drive))
    return replay(assemble_log(light.robot, [recorded({"m": nominal()})["m"]]), light)


def explained(column, parts):
    """Share of the torque of a change that a column explains at its best size."""
    rows, own = (np.concatenate([x["torque", j].ravel() for j in range(2)]) for x in (parts, column.parts))
    return float((rows @ own) ** 2 / ((rows @ rows) * (own @ own)))


@pytest.mark.parametrize("change", [-0.2, 0.2])
def test_a_spring_that_is_a_fifth_off_is_explained_by_replays_and_not_by_slopes(run, change):
    parts = replay_change(run, add_effect(run.machine, JointStiffness(change=np.array([change, 0.0]))))
    (slope,) = (
        column for column in compute_sensitivities(run, [JointStiffness], {}) if column.joint == run.robot.joints[0]
    )
    others = compute_stiffness_sensitivities(run, [0])
    assert {column.joint for column in others} == {run.robot.joints[0]}
    assert len({column.choice for column in (slope, *others)}) == 7
    assert max(explained(column, parts) for column in others) > 0.8
    assert explained(slope, parts) < 0.5
