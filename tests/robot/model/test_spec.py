"""The MuJoCo model of a robot: rotors, servos and friction are where the description says, options do what they say."""

from dataclasses import fields, replace

import mujoco
import numpy as np
import pytest

from ffgym.robot import ModelOptions, build_spec, compile_model, load_robot, physics_fingerprint
from ffgym.robot.model.names import deflection_joint, friction_actuator, motor_joint, servo_actuator

BARE = ModelOptions(looks=False)


def mass_matrix(model, data):
    mujoco.mj_forward(model, data)
    matrix = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, matrix)
    return matrix


def at_random(model, seed=0):
    """Data of a model in a random state."""
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    data.qpos = rng.uniform(-0.5, 0.5, model.nq)
    data.qvel = rng.uniform(-0.5, 0.5, model.nv)
    data.act = rng.uniform(-0.005, 0.005, model.na)
    data.ctrl = rng.uniform(-50, 50, model.nu)
    return data


@pytest.mark.parametrize("name", ["irb4600_60_205", "one_axis"])
@pytest.mark.parametrize("seed", range(3))
def test_the_rotor_adds_gear_ratio_squared_times_its_inertia_to_the_motor_hinge_alone(name, seed):
    robot = load_robot(name)
    with_rotor, without = (compile_model(robot, ModelOptions(looks=False, servo=servo)) for servo in (True, False))
    qpos = np.random.default_rng(seed).uniform(-1, 1, with_rotor.nq)
    data, bare = mujoco.MjData(with_rotor), mujoco.MjData(without)
    data.qpos = bare.qpos = qpos
    added = mass_matrix(with_rotor, data) - mass_matrix(without, bare)
    expected = np.zeros(with_rotor.nv)
    for i, joint in enumerate(robot.joints):
        reflected = robot.drive.gear_ratio[i] ** 2 * robot.drive.rotor_inertia[i]
        expected[with_rotor.joint(motor_joint(joint)).dofadr[0]] = reflected
    np.testing.assert_allclose(added, np.diag(expected), atol=1e-11)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("gain", [1.0, 100.0])
def test_the_servo_gives_proportional_integral_velocity_and_feedforward_torque_up_to_its_peak(irb4600, seed, gain):
    model = compile_model(irb4600, BARE)
    data = at_random(model, seed)
    servo, drive = irb4600.servo, irb4600.drive
    forces, expected = [], []
    for i, joint in enumerate(irb4600.joints):
        actuator, hinge = model.actuator(servo_actuator(joint)), model.joint(motor_joint(joint))
        columns = int(model.actuator_ctrladr[actuator.id]) + np.arange(3)
        motor = data.qpos[hinge.qposadr[0]] * drive.gear_ratio[i]
        motor_dq = data.qvel[hinge.dofadr[0]] * drive.gear_ratio[i]
        errors = np.array([0.02, -0.3, 1.5]) * gain  # rad, rad/s, N m
        data.ctrl[columns] = [motor + errors[0], motor_dq + errors[1], errors[2]]
        integral = data.act[actuator.actadr[0]]
        torque = servo.position_gain[i] * errors[0] + servo.velocity_gain[i] * errors[1]
        torque += servo.integral_gain[i] * integral + errors[2]
        expected.append(np.clip(torque, -drive.peak_torque[i], drive.peak_torque[i]))
    mujoco.mj_forward(model, data)
    forces = [data.actuator_force[model.actuator(servo_actuator(joint)).id] for joint in irb4600.joints]
    np.testing.assert_allclose(forces, expected, rtol=1e-9)
    assert np.any(np.abs(forces) == drive.peak_torque) == (gain > 1)


def test_the_servo_integrates_its_position_error(irb4600):
    model = compile_model(irb4600, BARE)
    data = at_random(model)
    data.act[:] = 0
    actuator, hinge = model.actuator(servo_actuator("j2")), model.joint(motor_joint("j2"))
    data.ctrl[model.actuator_ctrladr[actuator.id]] = data.qpos[hinge.qposadr[0]] * 120 + 0.03
    mujoco.mj_step(model, data)
    assert data.act[actuator.actadr[0]] == pytest.approx(0.03 * irb4600.physics_dt, rel=1e-9)


def test_the_friction_actuator_gives_the_torque_of_the_lugre_formula(irb4600):
    model = compile_model(irb4600, BARE)
    data = at_random(model, 3)
    mujoco.mj_forward(model, data)
    still = mujoco.MjData(model)
    for i, joint in enumerate(irb4600.joints):
        actuator, hinge = model.actuator(friction_actuator(joint)), model.joint(motor_joint(joint))
        z, dof = data.act[actuator.actadr[0]], hinge.dofadr[0]
        motor_dq = data.qvel[dof] * irb4600.drive.gear_ratio[i]
        f = irb4600.friction
        one = replace(
            f, **{field.name: getattr(f, field.name)[i : i + 1] for field in fields(f) if field.name != "arm_share"}
        )
        viscous = data.qfrc_passive[dof] / irb4600.drive.gear_ratio[i]
        assert viscous == pytest.approx(-f.viscous[i] * motor_dq, rel=1e-9)
        given = -data.actuator_force[actuator.id] - viscous
        assert given == pytest.approx(one.torque(np.array([z]), np.array([motor_dq]))[0], rel=1e-9)
    assert np.all(still.act == 0)


def test_options_leave_out_what_they_say(irb4600):
    def model(**options):
        return compile_model(irb4600, ModelOptions(**options))

    def names(kind, count, built):
        return [getattr(built, kind)(i).name for i in range(count)]

    whole = model()
    assert (whole.nv, whole.nu, whole.na, whole.nactuator) == (12, 18, 12, 12)
    assert whole.opt.timestep == irb4600.physics_dt
    assert whole.ngeom > 20
    rigid = model(flexible=False)
    assert names("joint", rigid.njnt, rigid) == [motor_joint(j) for j in irb4600.joints]
    smooth = model(friction=False)
    assert names("actuator", smooth.nactuator, smooth) == [servo_actuator(j) for j in irb4600.joints]
    free = model(servo=False)
    assert names("actuator", free.nactuator, free) == [friction_actuator(j) for j in irb4600.joints]
    assert free.nu == 0
    np.testing.assert_array_equal(whole.opt.gravity, irb4600.gravity)
    np.testing.assert_array_equal(model(gravity=False).opt.gravity, 0)
    assert model(physics_dt=1e-4).opt.timestep == 1e-4
    assert model(looks=False).ngeom == 0


def test_names_come_from_the_description(irb4600):
    joints = tuple(f"axis{i}" for i in range(6))
    links = tuple(f"part{i}" for i in range(6))
    model = compile_model(replace(irb4600, joints=joints, links=links, geoms=()), BARE)
    bodies = [model.body(i).name for i in range(model.nbody)]
    assert bodies[:4] == ["world", "base", "part0_rotor", "part0"]
    assert bodies[-1] == "tool"
    found = [model.joint(i).name for i in range(model.njnt)]
    assert found == [name for j in joints for name in (motor_joint(j), deflection_joint(j))]


def test_both_hinges_of_a_joint_turn_about_its_axis(irb4600):
    model = compile_model(irb4600, BARE)
    for joint, axis in zip(irb4600.joints, irb4600.kinematics.axis, strict=True):
        for name in (motor_joint(joint), deflection_joint(joint)):
            np.testing.assert_allclose(model.joint(name).axis, axis, atol=1e-15)


def test_looks_change_no_motion(irb4600):
    states = []
    for looks in (True, False):
        model = compile_model(irb4600, ModelOptions(looks=looks))
        data = at_random(model)
        mujoco.mj_step(model, data, 50)
        states.append(np.concatenate([data.qpos, data.qvel, data.act]))
    np.testing.assert_array_equal(*states)


def test_equal_descriptions_have_equal_fingerprints():
    for options in (None, BARE, ModelOptions(flexible=False)):
        prints = {physics_fingerprint(compile_model(load_robot("irb4600_60_205"), options)) for _ in range(2)}
        assert len(prints) == 1
    assert physics_fingerprint(compile_model(load_robot("one_axis"))) not in prints


def nudged(robot):
    """Copies of a robot with one number changed in its last digits, by what was changed."""
    for group, names in {
        "bodies": ("mass", "com", "inertia"),
        "drive": ("gear_ratio", "rotor_inertia", "joint_stiffness", "joint_damping", "peak_torque"),
        "friction": ("coulomb", "static", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping"),
        "servo": ("position_gain", "velocity_gain", "integral_gain"),
        "kinematics": ("position", "range"),
        "tool": ("mass", "com", "inertia", "tcp"),
    }.items():
        for name in names:
            part = getattr(robot, group)
            value = np.array(getattr(part, name), dtype=float)
            value[(0,) * value.ndim] *= 1 + 1e-9
            yield f"{group}.{name}", replace(robot, **{group: replace(part, **{name: value})})
    yield "base_mass", replace(robot, base_mass=robot.base_mass * (1 + 1e-9))
    yield "gravity", replace(robot, gravity=robot.gravity * (1 + 1e-9))


def test_every_changed_number_changes_the_fingerprint(irb4600):
    seen = {"none": physics_fingerprint(compile_model(irb4600, BARE))}
    for what, robot in nudged(irb4600):
        if what != "kinematics.position":  # its first number is zero
            seen[what] = physics_fingerprint(compile_model(robot, BARE))
    seen["flexible"] = physics_fingerprint(compile_model(irb4600, replace(BARE, flexible=False)))
    seen["physics_dt"] = physics_fingerprint(compile_model(irb4600, replace(BARE, physics_dt=2.5e-4 + 1e-12)))
    assert len(set(seen.values())) == len(seen)


def test_a_spec_can_be_edited_before_it_is_compiled(irb4600):
    spec = build_spec(irb4600, BARE)
    spec.body("tool").mass = 20.0
    extra = spec.compile().body_mass.sum() - compile_model(irb4600, BARE).body_mass.sum()
    assert extra == pytest.approx(20.0 - irb4600.tool.mass)
