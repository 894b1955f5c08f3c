"""Robots without looks are drawn by their joints."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from ffgym.robot import ModelOptions, builtin_robots, compile_model, load_robot, physics_fingerprint
from ffgym.robot.model.looks import stick_figure


def bare(name):
    return replace(load_robot(name), geoms=())


@pytest.mark.parametrize("name", builtin_robots())
def test_every_joint_has_a_ball_where_it_is(name):
    robot = bare(name)
    model = compile_model(robot)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    balls = model.geom_type == mujoco.mjtGeom.mjGEOM_SPHERE
    at = data.geom_xpos[balls]
    np.testing.assert_allclose(at, [data.body(link).xpos for link in robot.links], atol=1e-12)


def test_rods_join_the_joints_of_the_arm_and_end_at_its_tool(irb4600):
    rods = {geom.body: geom for geom in stick_figure(irb4600) if geom.type == "capsule"}
    for i, link in enumerate(irb4600.links[:-1]):
        if link in rods:
            np.testing.assert_array_equal(rods[link].end, irb4600.kinematics.position[i + 1])
    np.testing.assert_array_equal(rods["tool"].end, irb4600.tool.tcp)
    np.testing.assert_array_equal(rods["base"].end, irb4600.kinematics.position[0])


def test_joints_at_one_place_have_no_rod_between_them(irb4600):
    position = irb4600.kinematics.position.copy()
    position[3] = 0.0
    folded = replace(irb4600, kinematics=replace(irb4600.kinematics, position=position))
    assert irb4600.links[2] not in {geom.body for geom in stick_figure(folded) if geom.type == "capsule"}


def test_a_robot_with_looks_of_its_own_keeps_them(irb4600):
    assert compile_model(irb4600).ngeom == len(irb4600.geoms) + 1  # and the floor


def test_the_figure_weighs_nothing():
    robot = bare("irb4600_60_205")
    plain = compile_model(robot, ModelOptions(looks=False))
    drawn = compile_model(robot)
    np.testing.assert_array_equal(drawn.body_mass, plain.body_mass)
    assert not drawn.geom_contype.any()
    assert physics_fingerprint(plain) == physics_fingerprint(
        compile_model(load_robot("irb4600_60_205"), ModelOptions(looks=False))
    )
