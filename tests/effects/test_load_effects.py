"""What the arm carries, and what a motor must hold for it."""

import numpy as np

from ffgym.effects import EFFECTS
from ffgym.paths import joint_reference, multisine
from ffgym.robot import RigidArm
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine
from tests.effects.effect_samples import state_of


def held(robot, q, **effects):
    """Torque with which servos hold the pose `q`, link side [N m], (N,)."""
    still = multisine(q, np.full((1, 6), 1e-6), [2.0], np.zeros((1, 6)), 0.1, ramp=0.05, dwell=0.05)
    machine = Machine(robot=robot, effects=tuple(EFFECTS[name].on(robot, **values) for name, values in effects.items()))
    recording = simulate([Run(reference=joint_reference(robot, still))], machine=machine, n_threads=1)[0]
    return robot.drive.joint_torque(recording.joint_array("command.effort")[0])


def test_a_payload_weighs_on_all_joints_by_their_lever(irb4600, corners):
    q, offset = corners["p1"], np.array([0.05, -0.02, 0.1])
    more = held(irb4600, q, payload={"mass": 10.0, "offset": offset}) - held(irb4600, q)
    _, rotation, jacobian = RigidArm(irb4600).pose_and_jacobian(q[None])
    lever = rotation[0] @ offset
    linear = jacobian[0, :3] + np.cross(jacobian[0, 3:].T, lever).T
    # the arm sags a little more, which changes levers by some tenths of a millimetre
    np.testing.assert_allclose(more, linear.T @ [0, 0, 10.0 * 9.81], rtol=2e-2, atol=0.3)


def test_a_payload_has_the_inertia_of_its_body(irb4600):
    heavy = EFFECTS["payload"].on(irb4600, mass=4.0, radius=0.2).in_description(irb4600).tool
    point = EFFECTS["payload"].on(irb4600, mass=4.0).in_description(irb4600).tool
    np.testing.assert_allclose(heavy.inertia - point.inertia, 4.0 * 0.04 * np.array([1, 1, 1, 0, 0, 0]), atol=1e-12)
    np.testing.assert_array_equal(heavy.com, point.com)


def test_a_rotor_is_heavier_by_its_share_on_its_joint_only(irb4600):
    drive = EFFECTS["rotor_inertia"].on(irb4600, "j4", change=0.2).in_description(irb4600).drive
    np.testing.assert_allclose(drive.rotor_inertia / irb4600.drive.rotor_inertia, [1, 1, 1, 1.2, 1, 1])


def test_motors_hold_what_the_gravity_term_pulls(irb4600, corners):
    q = corners["p1"]
    pulled = held(irb4600, q, gravity_term={"sine": 40.0, "cosine": -20.0, "stiffness": 30.0, "neutral": 0.2})
    expected = 40.0 * np.sin(q) - 20.0 * np.cos(q) + 30.0 * (q - 0.2)
    np.testing.assert_allclose(pulled - held(irb4600, q), expected, rtol=1e-2, atol=0.2)


def test_cables_rub_by_the_area_of_their_loop(irb4600):
    effect = EFFECTS["cable_pull"].on(irb4600, stiffness=20.0, hysteresis=5.0, width=0.1)
    t = np.linspace(0, 2, 4001)
    q = 0.5 * np.sin(2 * np.pi * t)
    dt, memory, torque = t[1], np.zeros((6, 1)), []
    for angle, speed in zip(q, np.diff(q, prepend=0.0) / dt, strict=True):
        added, memory = effect.torques(state_of(irb4600, joint_angle=angle, joint_speed=speed), memory, dt)
        torque.append(added.link)
    area = -np.trapezoid(np.array(torque)[2000:], q[2000:], axis=0)
    np.testing.assert_allclose(area, 4 * 5.0 * (0.5 - 0.1), rtol=1e-3)
