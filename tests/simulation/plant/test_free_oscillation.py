"""Sag and resonances of the simulated arm against what the description promises."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh

from ffgym.robot import ModelOptions, resonances, static_deflection
from ffgym.simulation.plant import Plant
from scripts.tables.physics import free_of_servo
from tests.simulation.plant.driving import controls


@pytest.mark.parametrize(("name", "sag"), [("p1", 1.9e-3), ("p2", 3.3e-3)])
def test_an_arm_let_go_with_straight_springs_settles_where_they_carry_gravity(irb4600, arm, corners, name, sag):
    motor_q = corners[name][None]
    plant = Plant(irb4600, 1)
    held = controls(plant, motor_q * irb4600.drive.gear_ratio, shape=(1, round(2.5 / plant.physics_dt), 6))
    plant.batch.qpos[0, plant.addresses.motor_qpos] = motor_q  # all deflections and integrals start at zero
    state = plant.unpack(*(x[:, -1] for x in plant.advance(held)))
    motor = state.motor_position / irb4600.drive.gear_ratio
    deflection = state.link_position - motor
    np.testing.assert_allclose(deflection, static_deflection(arm, motor), atol=1e-7)
    np.testing.assert_allclose(
        irb4600.drive.joint_stiffness * deflection, -arm.gravity_torque(state.link_position), atol=0.05
    )
    drop = arm.tcp_pose(state.link_position)[0] - arm.tcp_pose(motor)[0]
    assert drop[0, 2] == pytest.approx(-sag, rel=0.3)


@pytest.mark.parametrize("motors", ["locked", "free"])
def test_each_mode_of_the_simulated_arm_swings_at_its_resonance(irb4600, arm, corners, motors):
    """Start in each mode shape without damping, and count the periods."""
    q, drive = corners["p2"], irb4600.drive
    rotors = drive.rotor_inertia * (1e6 if motors == "locked" else 1.0)
    robot = replace(free_of_servo(irb4600), drive=replace(drive, rotor_inertia=rotors, joint_damping=np.zeros(6)))
    inertia = np.linalg.inv(arm.mass_matrix(q[None])[0]) + np.diag(1 / (drive.gear_ratio**2 * rotors))
    stiffness = np.diag(drive.joint_stiffness)
    shapes = eigh(stiffness, np.linalg.inv(inertia))[1]
    quiet = ModelOptions(friction=False, gravity=False, physics_dt=0.0000625, looks=False)
    plant = Plant(robot, 6, options=quiet)
    plant.rest(np.tile(q, (6, 1)))
    plant.batch.qpos[:, plant.addresses.deflection_qpos] = 1e-4 * (shapes / np.abs(shapes).max(axis=0)).T
    state = plant.unpack(*plant.advance(np.zeros((6, 8000, plant.model.nu))))
    deflection = state.link_position - state.motor_position / drive.gear_ratio
    seen = [_frequency(deflection[i] @ stiffness @ shapes[:, i], plant.physics_dt) for i in range(6)]
    np.testing.assert_allclose(seen, resonances(arm, q, motors), rtol=0.002)


def test_damping_of_the_springs_decays_the_lowest_mode_as_described(irb4600, arm, corners):
    """With damping proportional to stiffness, d = c K, a mode decays as exp(-c omega^2 t / 2)."""
    q, drive = corners["p2"], irb4600.drive
    time_constant = 8e-4
    heavy = replace(drive, rotor_inertia=drive.rotor_inertia * 1e6, joint_damping=time_constant * drive.joint_stiffness)
    robot = replace(free_of_servo(irb4600), drive=heavy)
    stiffness = np.diag(drive.joint_stiffness)
    squares, shapes = eigh(stiffness, arm.mass_matrix(q[None])[0])
    plant = Plant(robot, 1, options=ModelOptions(friction=False, gravity=False, physics_dt=0.0000625, looks=False))
    plant.rest(q[None])
    plant.batch.qpos[:, plant.addresses.deflection_qpos] = 1e-4 * shapes[:, 0] / np.abs(shapes[:, 0]).max()
    state = plant.unpack(*(x[0] for x in plant.advance(np.zeros((1, 8000, plant.model.nu)))))
    swing = (state.link_position - state.motor_position / drive.gear_ratio) @ stiffness @ shapes[:, 0]
    peaks = np.flatnonzero((swing[1:-1] > swing[:-2]) & (swing[1:-1] >= swing[2:])) + 1
    rate = -np.polyfit(peaks * plant.physics_dt, np.log(swing[peaks]), 1)[0]
    assert rate == pytest.approx(0.5 * time_constant * squares[0], rel=0.02)


def _frequency(signal, dt):
    """Mean frequency [Hz] between the first and the last upward zero crossing."""
    rows = np.flatnonzero((signal[:-1] < 0) & (signal[1:] >= 0))
    crossings = (rows + signal[rows] / (signal[rows] - signal[rows + 1])) * dt
    return (len(crossings) - 1) / (crossings[-1] - crossings[0])
