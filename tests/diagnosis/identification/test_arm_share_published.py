"""Share of friction behind the elasticity on a measured robot, with encoders behind three gearboxes, see FFGYM_DATA."""

import os
from pathlib import Path

import numpy as np
import pytest

from ffgym.diagnosis.identification.friction import identify_friction
from ffgym.diagnosis.identification.friction_data import friction_torque
from ffgym.diagnosis.resampling import Pool, bootstrap
from ffgym.logs import read_log
from ffgym.robot import RigidArm, load_robot

pytestmark = pytest.mark.skipif(
    not os.environ.get("FFGYM_DATA"), reason="set FFGYM_DATA to the folder with the published recordings"
)


@pytest.fixture(scope="module")
def runs():
    """Two runs of 10 s of the KUKA KR300."""
    arm, folder = RigidArm(load_robot("kuka_kr300_r2500")), Path(os.environ["FFGYM_DATA"]) / "kuka_kr300_2020"
    return {run: friction_torque(arm, read_log(folder / f"{run}.npz", "kuka_kr300_2020")) for run in ("A", "C")}


def test_motions_without_constant_speeds_do_not_tell_it(runs):
    found = identify_friction(list(runs.values()), n_resamples=10)
    statuses = [joint.arm.estimate.status for joint in found.joints if joint.arm is not None]
    assert statuses == ["not excited"] * 3 + ["not measured"] * (len(statuses) - 3)
    assert found.friction.arm_share is None


def share_of_coulomb(torque, joint):
    """Part of link minus motor that turns with the direction, over what the described Coulomb torque would bend.

    Estimate and 90 % interval, shape (3,). Least squares on all rows above 3 rad/s of the motor, beside load, delay,
    acceleration, a constant and a wave per motor turn.
    """
    signals, robot = torque.signals, torque.signals.robot
    drive, friction = robot.drive, robot.friction
    stiffness, gear = drive.joint_stiffness[joint], drive.gear_ratio[joint]
    driven = drive.joint_torque(signals.torque - drive.rotor_inertia * signals.motor_ddq)
    load = driven - gear * friction.steady_torque(signals.motor_dq)
    direction = gear * friction.coulomb * np.sign(signals.motor_dq)
    turn = signals.q[:, joint] * gear
    columns = [
        *(-column[:, joint] / stiffness for column in (direction, load)),
        signals.dq[:, joint],
        signals.ddq[:, joint],
        *(np.ones_like(turn), np.sin(turn), np.cos(turn)),
    ]
    rows = torque.counts(joint) & (np.abs(signals.motor_dq[:, joint]) > 3.0)
    table, deflection = np.stack(columns, axis=1)[rows], (torque.links - signals.q)[rows, joint]
    block = np.unique(np.arange(len(rows))[rows] // 62, return_inverse=True)[1]  # a quarter of a second

    def solve(counts):
        root = np.sqrt(counts[block])
        return np.linalg.lstsq(root[:, None] * table, root * deflection, rcond=None)[0][:1]

    pool = Pool(n_blocks=int(block.max()) + 1)
    drawn = bootstrap(solve, pool, np.random.default_rng(0), 200)
    return np.array([*solve(np.ones(pool.n_blocks)), *np.quantile(drawn, [0.05, 0.95])])


def test_what_turns_with_the_direction_there_contradicts_itself(runs):
    """Docs/identification.md tells these figures: the runs differ, and on one axis the sign is impossible."""
    found = {(run, j): share_of_coulomb(torque, j) for run, torque in runs.items() for j in range(3)}
    # no friction pulls the arm along
    assert found["A", 2][2] < 0
    assert found["C", 2][0] < 0
    assert found["A", 0][0] > 2 * found["C", 0][0]
