"""Nothing is written for six joints: arms of one, two and three joints load, compile, simulate and move."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.control import NoCompensation, StaticLuGre, rigid_feedforward
from ffgym.core.errors import FFGymError
from ffgym.paths import CartesianPath, cartesian_reference, constant_velocity, joint_reference, joint_sine
from ffgym.recordings import Phase
from ffgym.recordings.metrics import motor_error_rms
from ffgym.robot import ModelOptions, RigidArm, compile_model, parse_robot, resonances
from ffgym.simulation import Run, simulate
from tests.robot.toml_entries import entry, small_motors

LENGTH, MASS, INERTIA = 0.5, 4.0, 0.1


def planar_arm(n, stiffness="20000.0", tool=False):
    """Description of a chain of n equal bars that swing about y in the vertical plane, hanging along x at q = 0."""
    each = "[{}]".format
    link = "link"
    joints, links = [f"hinge{i}" for i in range(n)], [f"bar{i}" for i in range(n)]
    text = f"[robot]\nname = 'bars'\ntitle = 'Chain of bars'\njoints = {joints}\nlinks = {links}\n"
    numbers = [
        ("kinematics.position", [[0.0, 0, 1.0]] + [[LENGTH, 0, 0]] * (n - 1), "m"),
        ("kinematics.axis", [[0.0, 1.0, 0.0]] * n, "1"),
        ("kinematics.range", [[-170.0, 170.0]] * n, "deg", link),
        ("kinematics.max_speed", [3.0] * n, "rad/s", link),
        ("base.mass", 5.0, "kg"),
        ("base.com", [0.0, 0.0, 0.0], "m"),
        ("links.mass", [MASS] * n, "kg", link),
        ("links.com", [[LENGTH / 2, 0.0, 0.0]] * n, "m", link),
        ("links.inertia", [[INERTIA / 10, INERTIA, INERTIA, 0, 0, 0]] * n, "kg m^2", link),
        ("drive.gear_ratio", [80.0] * n, "1"),
        ("drive.joint_stiffness", each(", ".join([stiffness] * n)), "N m/rad", link),
        ("drive.joint_damping", [20.0] * n, "N m s/rad", link),
        ("servo.control_dt", 0.002, "s"),
        ("simulation.gravity", [0.0, 0.0, -9.81], "m/s^2"),
    ]
    if tool:
        numbers += [
            ("flange.rotation", [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]], "1"),
            ("tool.mass", 1.0, "kg"),
            ("tool.com", [LENGTH, 0.0, 0.0], "m"),
            ("tool.inertia", [0.01, 0.01, 0.01, 0, 0, 0], "kg m^2"),
            ("tool.tcp", [LENGTH, 0.0, 0.0], "m"),
            ("work_area.tool_rotation", [[0.0, 0, 1.0], [0, 1.0, 0], [-1.0, 0, 0]], "1"),
            ("work_area.home", [-60.0] + [90.0] * (n - 2) + [60.0] * (n > 1), "deg", link),
        ]
    return parse_robot(text + small_motors(n) + "".join(entry(*number) for number in numbers), where="bars.toml")


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("stiffness", ["20000.0", "inf"])
def test_an_arm_of_any_number_of_joints_compiles_with_its_own_names(n, stiffness):
    robot = planar_arm(n, stiffness)
    model = compile_model(robot)
    assert model.nv == n * (1 if stiffness == "inf" else 2)
    assert model.nu == 3 * n
    assert model.joint(0).name == "hinge0_motor"
    assert model.body(f"bar{n - 1}").id == model.nbody - 1
    assert compile_model(robot, ModelOptions(flexible=False)).nv == n


@pytest.mark.parametrize("n", [1, 2])
def test_gravity_and_inertia_are_those_of_bars(n):
    arm = RigidArm(planar_arm(n))
    gravity = arm.gravity_torque(np.zeros((1, n)))[0]
    moments = [9.81 * MASS * sum(LENGTH * (k - j) + LENGTH / 2 for k in range(j, n)) for j in range(n)]
    np.testing.assert_allclose(gravity, np.negative(moments), rtol=1e-9)
    about_the_first = sum(INERTIA + MASS * (LENGTH * (k + 0.5)) ** 2 for k in range(n))
    assert arm.mass_matrix(np.zeros((1, n)))[0, 0, 0] == pytest.approx(about_the_first)


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("stiffness", ["20000.0", "inf"])
def test_an_arm_of_any_number_of_joints_follows_a_motion(n, stiffness):
    robot = planar_arm(n, stiffness)
    reference = joint_reference(robot, joint_sine([0.2 / (i + 1) for i in range(n)], 0.5, 1.0, dt=0.002))
    plain, helped = simulate(
        [Run(reference=reference, law=law) for law in (NoCompensation(), StaticLuGre(robot.friction))]
    )
    assert plain.header.joints == robot.joints
    assert plain.joint_array("motor.position").shape == (len(plain), n)
    assert not plain.has("tcp.position")
    error = np.abs(plain.joint_array("reference.position") - plain.joint_array("motor.position"))
    assert np.ptp(plain.joint_array("motor.position"), axis=0).min() > 0.1 * 80 / n
    assert 1e-4 < error.max() < 1.0
    assert np.all(motor_error_rms(helped) < 0.7 * motor_error_rms(plain))


def test_constant_speed_moves_only_the_joint_that_was_told_to():
    robot = planar_arm(2)
    path = constant_velocity([0.0, 0.5], 0.4, start=[-1.0, 1.0], dt=0.002)
    (recording,) = simulate([Run(reference=joint_reference(robot, path))])
    link = recording.joint_array("link.position")
    assert np.ptp(link[:, 0]) < 0.01
    assert np.ptp(link[:, 1]) == pytest.approx(0.5 * 0.6, abs=0.01)


def test_a_three_bar_arm_moves_its_tool_along_a_line():
    robot = planar_arm(3, tool=True)
    arm = RigidArm(robot)
    t = 0.002 * np.arange(251)
    x = 0.1 * t**2
    start = arm.tcp_position(robot.work_area.home[None])[0]
    zero = np.zeros_like(t)
    line = CartesianPath(
        name="line",
        t=t,
        position=start + np.stack([x, zero, zero], axis=1),
        velocity=np.stack([0.2 * t, zero, zero], axis=1),
        acceleration=np.stack([zero + 0.2, zero, zero], axis=1),
        phases=(Phase(label="all", kind="motion", start=0.0, end=0.5),),
    )
    rotation = arm.tcp_pose(robot.work_area.home[None])[1][0]
    reference = cartesian_reference(arm, line, rotation)
    np.testing.assert_allclose(arm.tcp_position(reference.q), line.position, rtol=0, atol=1e-9)
    twist = np.einsum("tij,tj->ti", arm.jacobian(reference.q), reference.dq)
    np.testing.assert_allclose(twist[:, 0], 0.2 * t, atol=1e-9)
    np.testing.assert_allclose(np.gradient(reference.dq, t, axis=0)[1:-1], reference.ddq[1:-1], atol=1e-3)
    (recording,) = simulate([Run(reference=reference)])
    assert np.abs(recording.vector("tcp.position") - recording.vector("tcp_reference.position")).max() < 0.02
    assert rigid_feedforward(arm, reference).shape == (251, 3)


def test_two_bars_resonate_at_two_frequencies():
    found = resonances(RigidArm(planar_arm(2)), np.zeros(2))
    assert found.shape == (2,)
    stiffer = replace(planar_arm(2), drive=replace(planar_arm(2).drive, joint_stiffness=np.full(2, 80000.0)))
    np.testing.assert_allclose(resonances(RigidArm(stiffer), np.zeros(2)), 2 * found, rtol=1e-9)


def test_reference_and_robot_must_have_the_same_number_of_joints():
    with pytest.raises(FFGymError, match=r"must be \(501, 2\)|must be \(\d+, 2\)"):
        joint_reference(planar_arm(2), joint_sine([0.1] * 3, 1.0, 1.0, dt=0.002))


@pytest.mark.parametrize("n", [1, 2, 3])
def test_an_arm_of_any_number_of_joints_stays_in_equilibrium_where_it_was_put(n):
    robot = planar_arm(n)
    centre = np.linspace(-1.0, 1.0, n)
    path = joint_sine(np.zeros(n), 1.0, 0.2, centre=centre, dt=0.002)
    (recording,) = simulate([Run(reference=joint_reference(robot, path))])
    np.testing.assert_allclose(recording.joint_array("motor.position") / 80, np.tile(centre, (201, 1)), atol=1e-9)
    sag = recording.joint_array("link.position")[-1] - centre
    expected = -RigidArm(robot).gravity_torque(recording.joint_array("link.position")[-1:])[0] / 20000.0
    np.testing.assert_allclose(sag, expected, atol=1e-9)
