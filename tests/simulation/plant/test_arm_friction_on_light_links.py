"""Friction behind the elasticity of links that are too light for explicit steps of its bristles."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from ffgym.core.measures import rms
from ffgym.effects import EFFECTS
from ffgym.paths import joint_reference, multisine
from ffgym.robot import ModelOptions, RigidArm, build_spec, compile_model
from ffgym.robot.model.mjcf import mjcf_text
from ffgym.robot.model.names import deflection_joint, motor_joint
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine, Plant
from tests.simulation.plant.driving import controls

BARE = ModelOptions(looks=False)


def on_last(robot, share):
    return robot.with_arm_share([0.0] * (robot.n_joints - 1) + [share])


def added(robot, model):
    """Inertia that the deflection of each joint has beyond its link's [kg m^2]."""
    return np.array([model.dof_armature[model.joint(deflection_joint(j)).dofadr[0]] for j in robot.joints])


def swing(robot, q, effects=()):
    """Recording of all joints swinging at 1 and 5 Hz about q, with reversals at every speed."""
    sizes = np.array([[0.02] * 6, [0.01] * 6])
    reference = joint_reference(robot, multisine(q, sizes, [1.0, 5.0], np.zeros((2, 6)), 0.6, ramp=0.2, dwell=0.1))
    machine = Machine(robot=robot, effects=tuple(effects))
    return simulate([Run(reference=reference)], machine=machine, arm=RigidArm(robot), n_threads=1)[0]


@pytest.mark.parametrize("share", [0.25, 0.73, 1.0])
def test_a_light_link_bears_any_share_nearly_as_at_a_sixteenth_of_the_step(share, irb4600, corners):
    robot = irb4600.with_arm_share(share)
    short = replace(robot, physics_dt=robot.physics_dt / 16)
    assert not added(short, compile_model(short)).any()  # MuJoCo's own steps of the model as described
    found, known = swing(robot, corners["p1"]), swing(short, corners["p1"])
    for column in ("motor.effort.j6", "link.position.j6"):
        off = rms(found[column] - known[column])
        assert off < 0.025 * rms(known[column] - known[column].mean()), column


def test_the_last_joint_is_as_exact_as_without_a_share(irb4600, corners):
    off = {}
    for share in (0.0, 0.73):
        robot = irb4600.with_arm_share(share)
        known = swing(replace(robot, physics_dt=robot.physics_dt / 16), corners["p1"])["motor.effort.j6"]
        off[share] = rms(swing(robot, corners["p1"])["motor.effort.j6"] - known) / rms(known)
    assert off[0.73] < 2 * off[0.0] < 0.02


@pytest.mark.parametrize("dt", [2.5e-4, 1e-4])
def test_what_the_inertia_of_the_last_link_lacks_for_a_stable_step_is_added_to_its_deflection(dt, irb4600):
    robot = on_last(replace(irb4600, physics_dt=dt), 0.8)
    model = compile_model(robot)
    # inertia of the link against the one before, by the mass matrix of the model without what was added
    bare = compile_model(on_last(replace(irb4600, physics_dt=1e-5), 0.8))
    data, mass = mujoco.MjData(bare), np.zeros((bare.nv, bare.nv))
    mujoco.mj_forward(bare, data)
    mujoco.mj_fullM(bare, data, mass)
    along = np.zeros(bare.nv)
    along[[bare.joint(name("j6")).dofadr[0] for name in (motor_joint, deflection_joint)]] = 1.0
    inertia = 1 / (along @ np.linalg.solve(mass, along))
    slope = 0.8 * 50**2 * (2 * robot.friction.bristle_damping[5] + robot.friction.viscous[5])
    np.testing.assert_allclose(added(robot, model), [0, 0, 0, 0, 0, dt * slope / 2 - inertia], rtol=1e-9)


def test_heavy_links_and_small_shares_keep_their_model(irb4600):
    for share in (0.0, [0.9, 0.9, 0.9, 0.9, 0.9, 0.1]):
        assert not added(irb4600, compile_model(irb4600.with_arm_share(share))).any()
    assert added(irb4600, compile_model(on_last(irb4600, 0.12)))[-1] > 0
    without_rotors = build_spec(on_last(irb4600, 0.9), ModelOptions(servo=False)).compile()
    assert not added(irb4600, without_rotors).any()


def test_a_link_that_bends_carries_less_and_gets_more(irb4600, corners):
    robot, bends = on_last(irb4600, 0.73), EFFECTS["link_flexibility"]
    effects = [bends.on(robot, "j6", compliance=1e-6)]
    stiff, soft = (
        added(robot, Machine(robot=robot, effects=tuple(some)).spec(BARE).compile())[-1] for some in ([], effects)
    )
    assert soft > stiff + 0.01
    swing(robot, corners["p1"], effects)  # and stays stable


def test_a_simulation_that_becomes_a_robot_with_a_larger_share_is_that_robot(irb4600):
    plants = [Plant(on_last(irb4600, share), 1, options=BARE, n_threads=1) for share in (0.3, 0.9)]
    plants[0].become([0], [on_last(irb4600, 0.9)])
    q = 0.2 * np.sin(np.linspace(0, 3, 200))[None, :, None] * np.ones(6)
    ends = []
    for plant in plants:
        plant.rest(np.zeros((1, 6)))
        ends.append(plant.advance(controls(plant, q, np.zeros_like(q)))[0])
    np.testing.assert_array_equal(*ends)


def test_an_exported_model_has_what_was_added(irb4600):
    robot = on_last(irb4600, 0.73)
    model = mujoco.MjModel.from_xml_string(mjcf_text(build_spec(robot, BARE)))
    np.testing.assert_array_equal(added(robot, model), added(robot, compile_model(robot, BARE)))
