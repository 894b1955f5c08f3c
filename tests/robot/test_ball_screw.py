"""The ball screw against the published equation of its carriage: M ddq + F_v dq + F_c sign(dq) = force."""

import mujoco
import numpy as np
import pytest

from ffgym.control import NoCompensation
from ffgym.paths import joint_reference, joint_sine
from ffgym.recordings.metrics import motor_error
from ffgym.robot import RigidArm, compile_model, load_robot, motor_torque
from ffgym.simulation import Run, simulate
from scripts.tables.physics import free_of_servo

MASS, VISCOUS, COULOMB = 95.1089, 203.5034, 20.3935
"""[kg], [N s/m], [N]: Janot, Gautier, Brunot (2019), reference model with symmetric friction."""
LEAD = 0.0025
"""Of the screw [m]: 50000 steps a turn, of 0.05 um."""


@pytest.fixture(scope="module")
def ball_screw():
    return load_robot("ball_screw")


def test_force_of_a_motion_is_that_of_the_published_model(ball_screw):
    rng = np.random.default_rng(0)
    q, dq, ddq = rng.uniform(0, 0.2, (20, 1)), rng.uniform(-0.1, 0.1, (20, 1)), rng.uniform(-2, 2, (20, 1))
    force = motor_torque(RigidArm(ball_screw), q, dq, ddq).total * 2 * np.pi / LEAD
    np.testing.assert_allclose(force, MASS * ddq + VISCOUS * dq + COULOMB * np.sign(dq), rtol=1e-12)


def test_one_turn_of_the_motor_is_one_lead_of_the_screw(ball_screw):
    np.testing.assert_allclose(ball_screw.drive.joint_angle(np.array([[2 * np.pi]])), LEAD, rtol=1e-15)
    assert ball_screw.kinematics.types == ("slide",)


def test_servo_pulls_with_the_gains_of_the_machine(ball_screw):
    drive_gain, kp, kv = 35.15065, 160.18, 243.45  # N/V, 1/s, V/(m/s)
    turns = ball_screw.drive.gear_ratio
    np.testing.assert_allclose(ball_screw.servo.position_gain * turns**2, drive_gain * kv * kp, rtol=1e-5)
    np.testing.assert_allclose(ball_screw.servo.velocity_gain * turns**2, drive_gain * kv, rtol=1e-5)


def test_a_constant_push_speeds_the_carriage_up_as_the_published_model_says(ball_screw):
    model = compile_model(free_of_servo(ball_screw))
    data, push, duration = mujoco.MjData(model), 40.0, 1.5
    data.xfrc_applied[model.body("carriage").id, 0] = push
    while data.time < duration:
        mujoco.mj_step(model, data)
    final, time_constant = (push - COULOMB) / VISCOUS, MASS / VISCOUS
    gone = np.exp(-duration / time_constant)
    assert data.qvel[0] == pytest.approx(final * (1 - gone), rel=1e-3)
    assert data.qpos[0] == pytest.approx(
        final * (duration - time_constant * (1 - gone)), rel=5e-3
    )  # bristles bend first


def test_a_push_below_coulomb_friction_moves_the_carriage_by_micrometres(ball_screw):
    model = compile_model(free_of_servo(ball_screw))
    data = mujoco.MjData(model)
    data.xfrc_applied[model.body("carriage").id, 0] = 0.5 * COULOMB
    mujoco.mj_step(model, data, 4000)
    assert 1e-6 < data.qpos[0] < 3e-6


def test_servo_follows_a_sine_within_the_force_of_the_drive(ball_screw):
    path = joint_sine(np.array([0.02]), 1.0, 2.0, centre=np.array([0.1]), dt=ball_screw.servo.control_dt)
    (recording,) = simulate([Run(reference=joint_reference(ball_screw, path), law=NoCompensation())])
    settled = recording.slice(1.0)  # the sine begins at full speed
    error = motor_error(settled)[:, 0] * LEAD / (2 * np.pi)
    assert np.abs(error).max() < 1e-4  # m
    assert np.abs(settled["motor.effort.x"]).max() < 0.5 * ball_screw.drive.peak_torque[0]
