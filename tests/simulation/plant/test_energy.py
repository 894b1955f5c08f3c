"""Conservation of energy in the simulated arm, with energies that share only the description with it."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.robot import ModelOptions
from ffgym.simulation.plant import Plant
from scripts.engine.second.arm import PinocchioArm
from scripts.tables.physics import free_of_servo
from tests.simulation.plant.driving import controls

DURATION = 0.2
BENT = 2e-3 * np.array([1, -1, 1, 1, -1, 1])


def swing(robot, corner, physics_dt):
    """States at t = 0 and then every millisecond, of an arm that is let go with bent springs."""
    plant = Plant(robot, 1, options=ModelOptions(friction=False, physics_dt=physics_dt, looks=False))
    plant.rest(corner[None])
    plant.batch.qpos[:, plant.addresses.deflection_qpos] += BENT
    n, every = round(DURATION / physics_dt), round(0.001 / physics_dt)
    first = plant.batch.qpos.copy(), plant.batch.qvel.copy(), plant.batch.act.copy()
    later = plant.advance(np.zeros((1, n, plant.model.nu)))
    return plant.unpack(*(np.vstack([a, b[0, every - 1 :: every]]) for a, b in zip(first, later, strict=True)))


def energies(robot, state):
    """Kinetic, gravitational and elastic energy [J], shape (T, 3)."""
    arm, drive = PinocchioArm(robot), robot.drive
    deflection = state.link_position - state.motor_position / drive.gear_ratio
    rotors = 0.5 * (drive.rotor_inertia * state.motor_velocity**2).sum(axis=1)
    links = [arm.kinetic_energy(q, dq) for q, dq in zip(state.link_position, state.link_velocity, strict=True)]
    height = [arm.potential_energy(q) for q in state.link_position]
    return np.stack([rotors + links, height, 0.5 * (drive.joint_stiffness * deflection**2).sum(axis=1)], axis=1)


@pytest.fixture(scope="module")
def loose(irb4600):
    """The six-axis arm without servo and damping."""
    return replace(free_of_servo(irb4600), drive=replace(irb4600.drive, joint_damping=np.zeros(6)))


def test_total_energy_drifts_little_and_in_proportion_to_the_step(loose, corners):
    steps = [0.00025, 0.000125, 0.0000625]
    parts = [energies(loose, swing(loose, corners["p2"], step)) for step in steps]
    exchanged = np.ptp(parts[-1], axis=0)
    assert exchanged[0] > 50  # the arm falls: more than 50 J become kinetic energy
    assert exchanged[2] > 2  # and the springs swing
    drift = np.array([np.abs(part.sum(axis=1) - part[0].sum()).max() for part in parts])
    assert drift[-1] < 1e-3 * exchanged[0]
    np.testing.assert_allclose(np.log2(drift[:-1] / drift[1:]), 1.0, atol=0.3)


def test_joint_damping_only_takes_energy(irb4600, corners):
    robot = free_of_servo(irb4600)
    total = energies(robot, swing(robot, corners["p2"], 0.0000625)).sum(axis=1)
    assert np.diff(total).max() < 1e-3
    assert total[-1] < total[0] - 1


def test_power_of_the_motors_is_the_change_of_energy(loose, corners):
    """Work of a known torque on every motor against the change of total energy."""
    plant = Plant(loose, 1, options=ModelOptions(friction=False, physics_dt=0.0000625, looks=False))
    plant.rest(corners["p1"][None])
    n = round(DURATION / plant.physics_dt)
    torque = np.array([6.0, 10, 6, 0.5, 0.5, 0.5]) * np.sin(2 * np.pi * 5 * np.arange(n) * plant.physics_dt)[:, None]
    state = plant.unpack(*(x[0] for x in plant.advance(controls(plant, torque=torque[None]))))
    total = energies(loose, state_rows(state, slice(None, None, 16))).sum(axis=1)
    work = np.cumsum(torque[1:] * np.diff(state.motor_position, axis=0), axis=0).sum(axis=1)
    gained = total - total[0]
    assert np.ptp(gained) > 50
    np.testing.assert_allclose(gained[1:], work[15::16][: len(gained) - 1], atol=0.005 * np.ptp(gained))


def state_rows(state, rows):
    return replace(state, **{name: getattr(state, name)[rows] for name in vars(state)})
