"""The load of a joint that is described as rigid is what its links ask for; effects that grow with it act there."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis import diagnose
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.residual_rows import compute_residuals, find_valid_rows
from ffgym.effects import EFFECTS
from ffgym.paths import joint_reference, multisine
from ffgym.robot import load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine

SHARE = 0.1


@pytest.fixture(scope="module")
def arm():
    """A small arm in the vertical plane whose joints are rigid."""
    robot = load_robot("two_link")
    return replace(robot, drive=replace(robot.drive, joint_stiffness=np.full(2, np.inf), joint_damping=np.zeros(2)))


@pytest.fixture(scope="module")
def recording(arm):
    """It loses a tenth of what its gearboxes carry."""
    centre = arm.kinematics.range.mean(axis=1)
    amplitude, phases = np.array([[0.2, 0.25], [0.06, 0.08]]), np.array([[0.0, 1.5], [2.0, 0.5]])
    reference = joint_reference(arm, multisine(centre, amplitude, [0.4, 0.9], phases, 8.0, ramp=1.0, dwell=0.2))
    machine = Machine(robot=arm, effects=(EFFECTS["load_friction"].on(arm, share=SHARE),))
    return simulate([Run(reference=reference)], machine=machine, n_threads=1)[0]


def left(arm, recording, share):
    """RMS that a model with such a loss leaves of each torque."""
    machine = Machine(robot=arm, effects=(EFFECTS["load_friction"].on(arm, share=share),))
    log = assemble_log(arm, [recording])
    residual = compute_residuals(log, predict(replay(log, machine)))["torque"]
    return np.sqrt(np.mean(residual[find_valid_rows(log)] ** 2, axis=0))


def test_simulation_and_replay_lose_the_same_share_of_the_load(arm, recording):
    assert np.all(left(arm, recording, SHARE) < 0.2 * left(arm, recording, 0.0))


def test_a_loss_that_grows_with_load_is_named_on_rigid_joints(arm, recording):
    rng, names = np.random.default_rng(1), ("motor.position", "motor.effort")
    columns = {"timestamp": recording.t}
    for family, noise in zip(names, (2e-5, 0.01), strict=True):
        for joint in arm.joints:
            values = recording[f"{family}.{joint}"]
            columns[f"{family}.{joint}"] = values + rng.normal(scale=noise, size=len(values))
    log = type(recording)({name: values[::4] for name, values in columns.items()}, recording.header)
    found = {(cause.effect, cause.joint): cause for cause in diagnose(arm, [log]).causes}
    assert set(found) == {("load_friction", joint) for joint in arm.joints}
    for cause in found.values():
        assert cause.parameters[0].value == pytest.approx(SHARE, rel=0.1)
