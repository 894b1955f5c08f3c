"""Recordings of protocols show what the protocol is for, by the plainest method there is."""

import numpy as np
import pytest

from ffgym.simulation import SimulatedRig
from ffgym.simulation.protocols import plan_session, record
from ffgym.simulation.protocols.one_by_one import SlowTriangles, SpeedLadder, Table61
from ffgym.simulation.protocols.rests import Holds
from tests.simulation.protocols.protocol_samples import arm_of


def recorded(robot, protocol):
    arm = arm_of(robot)
    return arm, list(record(plan_session(arm, [protocol]), SimulatedRig(arm=arm)))


def middle(recording, label):
    """Rows of the middle half of a phase."""
    rows = np.flatnonzero(recording.mask(label=label))
    return rows[len(rows) // 4 : -len(rows) // 4]


def test_half_the_difference_of_a_ladder_is_friction_although_gravity_acts():
    speeds = (0.05, 0.3, 2.0, 10.0)
    arm, (recording,) = recorded("two_link", SpeedLadder(joints=("elbow",), speeds=speeds, longest=2.0))
    torque = recording["motor.effort.elbow"]
    forwards, back = (
        np.array([torque[middle(recording, f"joint 2 step {i} {way}")].mean() for i in range(1, 5)])
        for way in ("forwards", "back")
    )
    friction = arm.robot.friction.steady_torque(np.outer(speeds, [1.0, 1.0]))[:, 1]
    np.testing.assert_allclose((forwards - back) / 2, friction, rtol=0.02)
    assert np.abs(forwards + back).min() > 0.5  # gravity, which cancels


def test_half_the_sum_of_a_hold_is_gravity_although_friction_acts():
    arm, recordings = recorded("two_link", Holds(poses=3, rest=1.0))
    for recording in recordings:
        rows = [middle(recording, f"rest from {side}") for side in ("below", "above")]
        below, above = (recording.joint_array("motor.effort")[part].mean(axis=0) for part in rows)
        pose = arm.robot.drive.joint_angle(recording.joint_array("motor.position")[rows[0][:1]])
        load = arm.robot.drive.motor_torque(arm.holding_torque(pose))[0]
        np.testing.assert_allclose((below + above) / 2, load, atol=0.05)


@pytest.mark.parametrize("number", [1, 12])
def test_torque_less_inertia_of_a_sine_is_the_friction_of_the_thesis(number):
    arm, (recording,) = recorded("one_axis", Table61(records=(number,), least=2.0, periods=1))
    dq = recording["motor.velocity.j1"]
    inertia = arm.mass_matrix(np.zeros((1, 1)))[0, 0, 0] + arm.robot.drive.rotor_inertia[0]
    friction = recording["motor.effort.j1"] - inertia * np.gradient(dq, recording.dt)
    sliding = np.abs(dq) > 0.9 * np.abs(dq).max()
    np.testing.assert_allclose(friction[sliding], arm.robot.friction.steady_torque(dq[sliding, None])[:, 0], rtol=0.03)


def test_triangles_within_the_bristles_come_back_as_a_spring_and_larger_ones_slip():
    _, recordings = recorded("one_axis", SlowTriangles(sizes=(0.3, 8.0), period=1.0, periods=2))
    friction = [recording["friction.effort.j1"] for recording in recordings[:2]]
    angle = [recording["motor.position.j1"] for recording in recordings[:2]]
    small, large = (np.corrcoef(f, q)[0, 1] for f, q in zip(friction, angle, strict=True))
    assert small > 0.95
    assert large < 0.8
    assert np.abs(friction[0]).max() < 0.6 * arm_of("one_axis").robot.friction.coulomb[0]
