"""A link that bends: sag, limits, resonances and energy, against computations of their own."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
import scipy

from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS
from ffgym.paths import joint_reference, multisine
from ffgym.robot import ModelOptions, RigidArm, load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine, Plant

FLEXIBLE = EFFECTS["link_flexibility"]


def machine_of(robot, joint, compliance, **more):
    return Machine(robot=robot, effects=(FLEXIBLE.on(robot, joint, compliance=compliance, **more),))


def at_rest(machine, q):
    """Model and data of a machine at rest, with motors at q."""
    plant = Plant(machine, 1, n_threads=1)
    plant.rest(np.asarray(q)[None])
    model = plant.batch.get_model(0)
    data = mujoco.MjData(model)
    data.qpos[:] = plant.batch.qpos[0]
    mujoco.mj_forward(model, data)
    return model, data


def test_a_link_sags_by_its_compliance_times_the_moment_of_what_lies_beyond_the_bend(two_link):
    compliance, length = 1e-6, 1.0
    _, data = at_rest(machine_of(two_link, "shoulder", compliance), [0.0, 0.0])
    # stretched out forwards: the second link's mass at 1.5 m and the tool's at 2.05 m, the bend a third along the first
    beyond = 9.81 * (50 * (length + 0.5 - length / 3) + 5 * (length + 1.0 + 0.05 - length / 3))
    assert abs(data.joint("shoulder_bend").qpos[0]) == pytest.approx(compliance * beyond, rel=1e-3)
    # and the tool hangs lower by that angle times its distance from the bend, beyond what the gearboxes give way
    _, stiff = at_rest(Machine(robot=two_link), [0.0, 0.0])
    lower = stiff.site("tcp").xpos[2] - data.site("tcp").xpos[2]
    assert lower == pytest.approx(compliance * beyond * (2.1 - length / 3), rel=5e-3)


@pytest.mark.parametrize("joint", range(6))
def test_every_link_of_six_axes_sags_about_the_axis_of_its_joint(joint, irb4600, corners):
    compliance = 1e-7
    name = irb4600.joints[joint]
    model, data = at_rest(machine_of(irb4600, name, compliance), corners["p1"])
    bend = data.joint(f"{name}_bend")
    np.testing.assert_allclose(bend.xaxis, data.joint(f"{name}_deflection").xaxis, atol=1e-12)
    np.testing.assert_allclose(bend.qpos, -compliance * bend.qfrc_bias, rtol=1e-6, atol=1e-15)
    # the moment of gravity about the bend, body by body
    beyond = [model.jnt_bodyid[model.joint(f"{name}_bend").id]]
    for body in range(beyond[0] + 1, model.nbody):
        if model.body_parentid[body] in beyond:
            beyond.append(body)
    weights = [np.cross(data.xipos[b] - bend.xanchor, [0.0, 0.0, -9.81 * model.body_mass[b]]) for b in beyond]
    assert bend.qpos[0] == pytest.approx(compliance * float(bend.xaxis @ np.sum(weights, axis=0)), rel=1e-5, abs=1e-14)


def test_encoders_of_links_stand_before_the_bend_and_the_tool_behind_it(irb4600, corners):
    swing = multisine(corners["p1"], np.full((1, 6), 2e-3), [2.0], np.zeros((1, 6)), 0.3, ramp=0.1, dwell=0.05)
    reference = joint_reference(irb4600, swing)
    machine = machine_of(irb4600, "j2", 1e-6)
    soft = simulate([Run(reference=reference)], machine=machine, n_threads=1)[0]
    seen = RigidArm(irb4600).tcp_position(soft.joint_array("link.position"))
    bent = soft.vector("tcp.position") - seen
    moment = 0.9e3  # about: that of the arm beyond a third of its lower part
    assert 0.5e-6 * moment < np.linalg.norm(bent[0]) < 3e-6 * moment
    assert bent[0][2] < 0


def test_a_stiff_link_is_as_one_that_does_not_bend_and_the_difference_is_as_its_compliance(irb4600, corners):
    swing = multisine(corners["p1"], np.full((1, 6), 2e-3), [2.0], np.zeros((1, 6)), 0.3, ramp=0.1, dwell=0.05)
    reference = joint_reference(irb4600, swing)

    def tool(machine):
        run = simulate([Run(reference=reference)], machine=machine, n_threads=1)[0]
        return run.vector("tcp.position"), run.joint_array("motor.effort")

    nominal = tool(Machine(robot=irb4600))
    near, nearer = (tool(machine_of(irb4600, "j2", compliance)) for compliance in (4e-8, 1e-8))
    for k in range(2):
        off, less = np.abs(near[k] - nominal[k]).max(), np.abs(nearer[k] - nominal[k]).max()
        assert less == pytest.approx(off / 4, rel=0.1)
    assert np.abs(nearer[0] - nominal[0]).max() < 3e-5


def test_no_compliance_leaves_the_model_as_it_was(irb4600):
    none = Machine(robot=irb4600, effects=(FLEXIBLE.on(irb4600, compliance=0.0),))
    options = ModelOptions(looks=False)
    assert none.physics(options) == Machine(robot=irb4600).physics(options)


def test_resonances_with_motors_held_are_those_of_three_masses_in_a_row(two_link):
    compliance = 1e-6
    machine = machine_of(two_link, "shoulder", compliance)
    model = machine.spec(ModelOptions(servo=False, friction=False, gravity=False, looks=False)).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    names = ("shoulder_deflection", "shoulder_bend", "elbow_deflection")
    free = [int(model.joint(name).dofadr[0]) for name in names]
    stiffness = np.diag([model.jnt_stiffness[model.joint(name).id].flat[0] for name in names])
    found = np.sqrt(scipy.linalg.eigh(stiffness, full[np.ix_(free, free)], eigvals_only=True))
    # bodies in a row: mass, place, inertia, and how many of the hinges turn them
    hinges, mass_matrix = (0.0, 1 / 3, 1.0), np.zeros((3, 3))
    bodies = [(55.0, 6 / 11, 11.13636364, 1), (50.0, 1.5, 10.0, 3), (5.0, 2.05, 0.01, 3)]
    for mass, place, inertia, count in bodies:
        arms = np.array([place - hinge for hinge in hinges[:count]])
        mass_matrix[:count, :count] += inertia + mass * np.outer(arms, arms)
    springs = np.diag([5e5, 1 / compliance, 2e5])
    expected = np.sqrt(scipy.linalg.eigh(springs, mass_matrix, eigvals_only=True))
    np.testing.assert_allclose(found, expected, rtol=1e-6)


@pytest.mark.parametrize("relaxation", [0.0, 2e-3])
def test_a_swinging_link_keeps_its_energy_but_for_its_damping(relaxation, two_link):
    drive = replace(two_link.drive, joint_damping=np.zeros(2))
    machine = machine_of(replace(two_link, drive=drive), "shoulder", 1e-6, relaxation=relaxation)
    options = ModelOptions(servo=False, friction=False, gravity=False, looks=False, physics_dt=2e-5)
    spec = machine.spec(options)
    spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    model = spec.compile()
    for joint, inertia in zip(two_link.joints, drive.reflected_inertia, strict=True):  # rotors, which turn freely
        model.dof_armature[model.joint(f"{joint}_motor").dofadr[0]] = inertia
    data = mujoco.MjData(model)
    data.joint("shoulder_bend").qpos[0] = 1e-3
    energy, lost, bend = [], 0.0, model.joint("shoulder_bend").dofadr[0]
    for _ in range(10000):
        mujoco.mj_step(model, data)
        energy.append(data.energy.sum())
        lost += options.physics_dt * relaxation / 1e-6 * data.qvel[bend] ** 2
    assert energy[0] == pytest.approx(0.5 * 1e6 * 1e-6, rel=1e-3)
    assert energy[-1] + lost == pytest.approx(energy[0], rel=0.01)
    assert (lost > 0.1 * energy[0]) == (relaxation > 0)


@pytest.mark.parametrize("tool", ["none", "without mass"])
def test_a_last_link_that_carries_nothing_does_not_bend(tool, two_link):
    robot = load_robot("one_axis")
    if tool == "without mass":
        robot = replace(two_link, tool=replace(two_link.tool, mass=0.0, inertia=np.zeros(6)))
    with pytest.raises(FFGymError, match="has no tool that weighs something"):
        machine_of(robot, robot.joints[-1], 1e-7)


def test_a_link_before_it_bends_whatever_the_tool_weighs(two_link):
    robot = replace(two_link, tool=replace(two_link.tool, mass=0.0, inertia=np.zeros(6)))
    _, data = at_rest(machine_of(robot, "shoulder", 1e-6), [0.0, 0.0])
    assert abs(data.joint("shoulder_bend").qpos[0]) == pytest.approx(1e-6 * 9.81 * 50 * (1.5 - 1 / 3), rel=1e-3)
