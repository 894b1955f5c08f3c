"""Coupled axes, sliding joints, gearboxes that reverse, and springs between links, in simulation."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from ffgym.agents.elastic import elastic_law
from ffgym.control import NoCompensation, rigid_feedforward
from ffgym.paths import joint_reference, joint_sine, random_multisine
from ffgym.robot import ModelOptions, RigidArm, compile_model, static_deflection
from ffgym.robot.parts import Spring
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Plant
from scripts.tables.physics import free_of_servo

COUPLING = np.zeros((6, 6))
COUPLING[4, 3], COUPLING[5, 3], COUPLING[5, 4] = 30.0, -12.0, 20.0  # a wrist whose axes turn the motors behind them


@pytest.fixture(scope="module")
def coupled(irb4600):
    return replace(irb4600, drive=replace(irb4600.drive, coupling=COUPLING))


@pytest.fixture(scope="module")
def balanced(irb4600):
    """The robot with a gas-spring-like counterbalance behind its second axis."""
    spring = Spring(
        name="balance",
        bodies=("frame", "lower_arm"),
        start=np.array([-0.6, 0.1, 0.1]),
        end=np.array([-0.15, 0.0, 0.1]),
        length=0.2,
        stiffness=(8e3, 5e3, 2e4),
    )
    return replace(irb4600, springs=(spring,))


def sine(robot, amplitude=0.05, frequency=1.0, duration=1.0):
    path = joint_sine(
        np.full(robot.n_joints, amplitude), frequency, duration, centre=robot.work_area.home, dt=robot.servo.control_dt
    )
    return joint_reference(robot, path)


def of_joints(recording, family, robot):
    return np.stack([recording[f"{family}.{joint}"] for joint in robot.joints], axis=1)


def test_the_models_inertia_is_that_of_links_and_coupled_rotors(coupled):
    model = compile_model(coupled, ModelOptions(flexible=False, looks=False))
    data = mujoco.MjData(model)
    data.qpos[:] = coupled.work_area.home
    mujoco.mj_forward(model, data)
    inertia = np.zeros((6, 6))
    mujoco.mj_fullM(model, data, inertia)
    gear = coupled.drive.matrix
    links = RigidArm(coupled).mass_matrix(coupled.work_area.home[None])[0]
    np.testing.assert_allclose(inertia, links + gear.T @ np.diag(coupled.drive.rotor_inertia) @ gear, rtol=1e-12)


def test_rigid_feed_forward_drives_coupled_axes_along_the_reference(coupled):
    """No gravity, friction or feedback: only torques that are right for every motor keep the arm on its sine."""
    robot = free_of_servo(replace(coupled, gravity=np.zeros(3)))
    reference = sine(robot, duration=0.5)
    options = ModelOptions(flexible=False, friction=False, looks=False)
    (recording,) = simulate([Run(reference=reference)], options=options)
    miss = of_joints(recording, "motor.position", robot) - of_joints(recording, "reference.position", robot)
    wrong = replace(robot, drive=replace(robot.drive, coupling=None))
    other = rigid_feedforward(RigidArm(wrong), joint_reference(wrong, _path_of(reference)))
    assert np.abs(other - rigid_feedforward(RigidArm(robot), reference))[:, 3:].max() > 0.01
    assert np.abs(miss).max() < 0.02  # rad at the motor, after moving 3 to 6 rad


def _path_of(reference):
    robot = reference.robot
    return joint_sine(np.full(6, 0.05), 1.0, 0.5, centre=robot.work_area.home, dt=robot.servo.control_dt)


def test_a_resting_axis_is_rubbed_by_the_motor_that_another_axis_turns(coupled):
    amplitude = np.array([0, 0, 0, 0.1, 0, 0])
    path = joint_sine(amplitude, 1.0, 0.5, centre=coupled.work_area.home, dt=coupled.servo.control_dt)
    (recording,) = simulate([Run(reference=joint_reference(coupled, path))])
    friction = of_joints(recording, "friction.effort", coupled)
    level = coupled.friction.coulomb
    assert np.abs(friction[:, 5]).max() > 0.9 * level[5]
    assert np.abs(friction[:, 0]).max() < 0.3 * level[0]
    assert recording.header.coupling == tuple(map(tuple, COUPLING.tolist()))


@pytest.mark.parametrize("kind", ["coupled", "balanced"])
def test_it_rests_in_equilibrium(kind, request):
    robot = request.getfixturevalue(kind)
    plant = Plant(robot, 1)
    plant.rest(robot.work_area.home[None])
    start = plant.state()
    controls = np.zeros((1, 400, plant.model.nu))
    plant.split_controls(controls)[0][:] = robot.drive.motor_angle(robot.work_area.home)
    plant.drive(controls)
    np.testing.assert_allclose(plant.state().motor_position, start.motor_position, atol=1e-9)
    np.testing.assert_allclose(plant.state().link_position, start.link_position, atol=1e-9)


def test_elastic_feed_forward_leads_coupled_axes_and_balanced_arms(coupled, balanced):
    """With a soft wrist, so that motors lead far enough to turn each other."""
    soft = np.array([1, 1, 1, 0.05, 0.05, 0.05])
    for robot in (coupled, balanced):
        drive = robot.drive
        soft_drive = replace(
            drive, joint_stiffness=drive.joint_stiffness * soft, joint_damping=drive.joint_damping * soft
        )
        robot = replace(robot, drive=soft_drive)
        rng = np.random.default_rng(2)
        path = random_multisine(rng, robot.work_area.home, np.full(6, 0.2), 2.0, dt=robot.servo.control_dt)
        reference = joint_reference(robot, path)
        runs = [Run(reference=reference, law=law) for law in (NoCompensation(), elastic_law(RigidArm(robot)))]
        misses = []
        for recording in simulate(runs):
            wanted = robot.drive.joint_angle(of_joints(recording, "reference.position", robot))
            misses.append(of_joints(recording, "link.position", robot) - wanted)
        none, elastic = (np.sqrt(np.mean((miss - miss[0]) ** 2, axis=0)) for miss in misses)
        assert np.all(elastic < 0.0125 * none), elastic / none  # 0.4 to 1.1 % are left


def energy(spring, model, data):
    start, end = (data.site(f"{spring.name}_{end}").xpos for end in ("start", "end"))
    x = np.linalg.norm(end - start) - spring.length
    a, b, c = spring.stiffness
    return a * x**2 / 2 + b * x**3 / 3 + c * x**4 / 4


@pytest.mark.parametrize("length", [0.2, 0.9], ids=["pulls", "pushes"])
def test_spring_torque_is_the_gradient_of_its_energy(balanced, length):
    balanced = replace(balanced, springs=(replace(balanced.springs[0], length=length),))
    arm = RigidArm(balanced)
    model = compile_model(balanced, ModelOptions(flexible=False, looks=False))
    data = mujoco.MjData(model)
    rng = np.random.default_rng(1)
    for q in rng.uniform(-0.8, 0.8, size=(5, 6)):
        slope = np.zeros(6)
        for j in range(6):
            values = []
            for h in (1e-5, -1e-5):
                data.qpos[:] = q + h * np.eye(6)[j]
                mujoco.mj_kinematics(model, data)
                values.append(energy(balanced.springs[0], model, data))
            slope[j] = (values[0] - values[1]) / 2e-5
        np.testing.assert_allclose(arm.spring_torque(q[None])[0], slope, atol=1e-4)
        assert abs(slope[1]) > 40


def test_a_resting_plant_bends_as_static_deflection_says_which_springs_change(balanced, irb4600):
    q = balanced.work_area.home[None]
    plant = Plant(balanced, 1)
    plant.rest(q)
    bent = static_deflection(RigidArm(balanced), q)
    np.testing.assert_allclose(plant.state().link_position - q, bent, rtol=0, atol=1e-12)
    assert np.abs(bent - static_deflection(RigidArm(irb4600), q))[0, 1] > 1e-4


def test_springs_bend_an_arm_that_weighs_nothing(balanced):
    q = balanced.work_area.home[None]
    plant = Plant(balanced, 1, options=ModelOptions(gravity=False, looks=False), n_threads=1)
    plant.rest(q)
    link = plant.state().link_position
    carried = balanced.drive.joint_stiffness * (link - q)
    np.testing.assert_allclose(carried, -RigidArm(balanced).spring_torque(link), rtol=1e-6, atol=1e-6)
    assert abs(carried[0, 1]) > 40


def test_springs_can_be_left_out(balanced, irb4600):
    left_out = compile_model(balanced, ModelOptions(springs=False, looks=False))
    bare = compile_model(irb4600, ModelOptions(looks=False))
    assert left_out.ntendon == 0
    np.testing.assert_array_equal(left_out.body_mass, bare.body_mass)
    assert np.all(RigidArm(irb4600).spring_torque(np.zeros((3, 6))) == 0)


def test_servos_see_motor_angles_and_speeds(coupled):
    plant = Plant(coupled, 2)
    plant.rest(np.stack([coupled.work_area.home, coupled.work_area.home + 0.1]))
    plant.batch.bind("qvel")[:] = np.random.default_rng(0).normal(size=(2, plant.model.nv))
    state = plant.state()
    seen = np.stack([state.motor_position, state.motor_velocity, state.integral])
    np.testing.assert_allclose(plant.servo_state(), seen, rtol=1e-12)


@pytest.mark.parametrize("stiffness", [np.inf, 4e6], ids=["rigid", "elastic"])
def test_a_sliding_joint_is_to_its_motor_what_a_hinge_of_the_same_inertia_is(one_axis, stiffness):
    ratio, mass = 800.0, 90.0
    bodies = replace(one_axis.bodies, mass=np.array([mass]))
    drive = replace(one_axis.drive, gear_ratio=np.array([ratio]), joint_stiffness=np.array([stiffness]))
    kinematics = replace(one_axis.kinematics, axis=np.array([[1.0, 0, 0]]), max_speed=np.array([5.0]))
    slide = replace(one_axis, bodies=bodies, drive=drive, kinematics=replace(kinematics, types=("slide",)))
    inertia = np.array([[mass, mass, mass, 0, 0, 0]])
    hinge = replace(slide, bodies=replace(bodies, inertia=inertia), kinematics=kinematics)
    recordings = []
    for robot in (slide, hinge):
        path = joint_sine([0.01], 1.0, 0.4, dt=robot.servo.control_dt)
        recordings += simulate([Run(reference=joint_reference(robot, path))])
    for name in ("motor.position.j1", "motor.effort.j1", "feedforward.effort.j1", "link.position.j1"):
        np.testing.assert_allclose(recordings[0][name], recordings[1][name], rtol=1e-9, atol=1e-9)
    assert recordings[0].header.joint_types == ("slide",)


def test_a_gearbox_that_reverses_turns_the_motor_the_other_way_and_the_arm_the_same(irb4600):
    signs = np.array([-1, 1, -1, 1, 1, -1])
    reverse = replace(irb4600, drive=replace(irb4600.drive, gear_ratio=irb4600.drive.gear_ratio * signs))
    there, back = (simulate([Run(reference=sine(robot, duration=0.3))])[0] for robot in (irb4600, reverse))
    for family, sign in (("link.position", 1), ("motor.position", signs), ("motor.effort", signs)):
        np.testing.assert_allclose(
            of_joints(back, family, reverse) * sign, of_joints(there, family, irb4600), atol=1e-9
        )
