"""Draws of robots, and simulations that become them."""

from dataclasses import fields, replace

import mujoco.batch
import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS
from ffgym.robot import ModelOptions, RigidArm, compile_model, model_field, static_deflection
from ffgym.robot.parts import Spring
from ffgym.simulation.plant import LogUniform, Machine, Plant, PlantDistribution, Uniform, with_payload
from tests.simulation.plant.driving import controls


def hold(plant, q, steps):
    """Controls that hold joint angles (B, N) for a number of physics steps."""
    position = np.repeat((q * plant.robot.drive.gear_ratio)[:, None], steps, axis=1)
    return controls(plant, position, shape=position.shape)


@pytest.fixture
def drawn(irb4600):
    return [PlantDistribution().draw(irb4600, np.random.default_rng(seed)) for seed in range(3)]


def test_a_simulation_that_becomes_a_robot_has_exactly_its_compiled_model(irb4600, drawn):
    plant = Plant(irb4600, 4)
    plant.become([1, 3], drawn[:2])
    plant.become([3], drawn[2:])  # a second draw leaves nothing of the first
    nominal = compile_model(irb4600, ModelOptions(looks=False))
    wanted = [nominal, compile_model(drawn[0], ModelOptions(looks=False)), nominal]
    wanted.append(compile_model(drawn[2], ModelOptions(looks=False)))
    for i, model in enumerate(wanted):
        own = plant.batch.get_model(i)
        for name in mujoco.batch.MODEL_FIELDS:
            np.testing.assert_array_equal(model_field(own, name), model_field(model, name), err_msg=f"{i} {name}")


def test_a_drawn_robot_rests_under_its_own_gravity_and_stays_there(irb4600, drawn, corners):
    plant = Plant(irb4600, 3)
    plant.become(range(3), drawn)
    start = np.tile(corners["p2"], (3, 1))
    plant.rest(start)
    for i, robot in enumerate(drawn):
        sag = static_deflection(RigidArm(robot), start[:1])[0]
        np.testing.assert_allclose(plant.state().link_position[i], start[0] + sag, atol=1e-12)
    before = plant.state()
    plant.drive(hold(plant, start, 200))
    np.testing.assert_allclose(plant.state().link_position, before.link_position, atol=1e-10)


def test_a_simulation_in_a_batch_of_drawn_robots_equals_the_robot_alone(irb4600, drawn, corners):
    start = np.tile(corners["p1"], (3, 1))
    together = Plant(irb4600, 3)
    together.become(range(3), drawn)
    alone = Plant(drawn[1], 1)
    for plant, rows in ((together, start), (alone, start[:1])):
        plant.rest(rows)
        plant.drive(hold(plant, rows + 1e-3, 400))
    np.testing.assert_array_equal(together.batch.state[1], alone.batch.state[0])


def test_going_back_to_the_nominal_robot_restores_every_bit(irb4600, drawn, corners):
    changed, fresh = Plant(irb4600, 1), Plant(irb4600, 1)
    changed.become([0], drawn[:1])
    changed.become([0], [irb4600])
    for plant in (changed, fresh):
        plant.rest(corners["p1"][None])
        plant.drive(hold(plant, corners["p1"][None] + 1e-3, 100))
    np.testing.assert_array_equal(changed.batch.state, fresh.batch.state)


def test_draws_stay_within_their_distributions_and_follow_the_seed(irb4600):
    same = [PlantDistribution().draw(irb4600, np.random.default_rng(7)) for _ in range(2)]
    np.testing.assert_array_equal(same[0].friction.viscous, same[1].friction.viscous)
    ratios = []
    for seed in range(200):
        robot = PlantDistribution().draw(irb4600, np.random.default_rng(seed))
        ratios.append(robot.friction.coulomb / irb4600.friction.coulomb)
        np.testing.assert_allclose(
            robot.friction.static / robot.friction.coulomb, irb4600.friction.static / irb4600.friction.coulomb
        )
        damping = robot.drive.joint_damping / np.sqrt(robot.drive.joint_stiffness)
        np.testing.assert_allclose(damping, irb4600.drive.joint_damping / np.sqrt(irb4600.drive.joint_stiffness))
    ratios = np.array(ratios)
    assert ratios.min() >= 0.7
    assert ratios.max() <= 1.4
    assert 0.9 < np.exp(np.log(ratios).mean()) < 1.1
    assert np.abs(np.corrcoef(np.log(ratios).T) - np.eye(6)).max() < 0.3  # joints are independent


@pytest.mark.parametrize("group", [f.name for f in fields(PlantDistribution)])
def test_each_group_changes_its_own_parameters_only(irb4600, group):
    nothing = {f.name: None for f in fields(PlantDistribution)}
    value = 0.7 if group == "arm_share" else 1.3  # a share, not a factor
    loop = dict.fromkeys(("torque_lag", "torque_delay", "torque_rate"), np.full(6, 1e-3))
    nominal = replace(irb4600, drive=replace(irb4600.drive, **loop))
    robot = PlantDistribution(**(nothing | {group: Uniform(value, value)})).draw(nominal, np.random.default_rng(0))
    changed = set()
    for part in ("friction", "drive", "bodies", "tool"):
        for f in fields(getattr(robot, part)):
            if not np.array_equal(getattr(getattr(robot, part), f.name), getattr(getattr(nominal, part), f.name)):
                changed.add(f.name)
    wanted = {
        "friction_level": {"coulomb", "static"},
        "joint_stiffness": {"joint_stiffness", "joint_damping"},
        "link_inertia": {"mass", "inertia"},
        "payload": {"mass", "com", "inertia"},
    }
    assert changed == wanted.get(group, {group})


def test_factors_of_a_torque_loop_need_one(irb4600):
    with pytest.raises(FFGymError, match=r"no drive\.torque_lag"):
        PlantDistribution(torque_lag=Uniform(0.5, 2.0)).draw(irb4600, np.random.default_rng(0))


def test_a_payload_is_a_point_mass_at_the_tcp(irb4600, arm, corners):
    loaded = RigidArm(with_payload(irb4600, 5.0))
    q, ddq = corners["p3"][None], np.array([[0.3, -0.2, 0.4, 0.1, -0.5, 0.6]])
    jacobian = arm.jacobian(q)[0, :3]
    extra = loaded.inverse_dynamics(q, 0 * q, ddq, gravity=True) - arm.inverse_dynamics(q, 0 * q, ddq, gravity=True)
    expected = 5.0 * jacobian.T @ (jacobian @ ddq[0] - irb4600.gravity)
    np.testing.assert_allclose(extra[0], expected, rtol=1e-9)


def test_a_payload_on_a_tool_without_mass_is_a_small_ball_and_more_can_be_added(irb4600):
    bare = replace(irb4600, tool=replace(irb4600.tool, mass=0.0, com=np.zeros(3), inertia=np.zeros(6)))
    assert with_payload(bare, 0.0) is bare
    loaded = with_payload(with_payload(bare, 2.0), 1.0).tool
    assert loaded.mass == 3.0
    np.testing.assert_allclose(loaded.com, bare.tool.tcp, rtol=1e-15)
    np.testing.assert_allclose(loaded.inertia[:3], 0.4 * 2.0 * 0.01**2, rtol=1e-12)
    assert PlantDistribution().draw(bare, np.random.default_rng(0)).tool.mass > 0


def test_a_batch_holds_robots_of_one_make_only(irb4600):
    spring = Spring(
        name="balance",
        bodies=("frame", "lower_arm"),
        start=np.array([-0.2, 0.0, 0.1]),
        end=np.array([-0.2, 0.0, 0.3]),
        length=0.15,
        stiffness=(2e4, 0.0, 0.0),
    )
    sliding = replace(irb4600.kinematics, types=("slide", *["hinge"] * 5))
    plant = Plant(replace(irb4600, springs=(spring,)), 1)
    for name, other in {
        "kinematics.types": replace(plant.robot, kinematics=sliding),
        "bodies of springs": replace(plant.robot, springs=(replace(spring, bodies=("frame", "forearm")),)),
        "having a tool": replace(plant.robot, tool=None, geoms=()),
    }.items():
        with pytest.raises(FFGymError, match=f"differ in {name}"):
            plant.become([0], [other])


def test_what_cannot_be_drawn_or_become_is_refused(irb4600, one_axis):
    with pytest.raises(FFGymError, match="must be a distribution"):
        PlantDistribution(viscous=1.2)
    with pytest.raises(FFGymError, match="must be in"):
        LogUniform(0.0, 1.0)
    with pytest.raises(FFGymError, match="must be > 0"):
        PlantDistribution(joint_stiffness=Uniform(-1.0, -1.0)).draw(irb4600, np.random.default_rng(0))
    with pytest.raises(FFGymError, match="no payload"):
        with_payload(one_axis, 1.0)
    with pytest.raises(FFGymError, match="differ in joints"):
        Plant(irb4600, 1).become([0], [one_axis])
    faster = replace(irb4600, servo=replace(irb4600.servo, position_gain=irb4600.servo.position_gain * 2))
    with pytest.raises(FFGymError, match=r"servo\.position_gain"):
        Plant(irb4600, 1).become([0], [faster])
    rigid = replace(irb4600, drive=replace(irb4600.drive, joint_stiffness=np.full(6, np.inf)))
    with pytest.raises(FFGymError, match="other elastic joints"):
        Plant(irb4600, 1).become([0], [rigid])
    lighter = replace(irb4600, drive=replace(irb4600.drive, rotor_inertia=0.9 * irb4600.drive.rotor_inertia))
    with pytest.raises(FFGymError, match="other elastic joints"):  # wherever it stands
        Plant(irb4600, 3).become([0, 1, 2], [lighter, lighter, rigid])


def test_a_joint_more_is_not_made_up_for_by_a_rigid_one(irb4600):
    base = EFFECTS["base_flexibility"].on(irb4600, compliance=[1e-7, 0.0, 0.0])
    stiffness = np.where(np.arange(6) == 0, np.inf, irb4600.drive.joint_stiffness)
    rigid = replace(irb4600, drive=replace(irb4600.drive, joint_stiffness=stiffness))
    with pytest.raises(FFGymError, match="joints of effects"):
        Plant(irb4600, 1).become([0], [Machine(robot=rigid, effects=(base,))])


def test_effects_remember_while_a_neighbour_becomes_another_and_a_plant_goes_back_to_what_it_was(irb4600, corners):
    kinds = {
        "torsional_hysteresis": {"lost_motion": 1e-4},
        "torque_delay": {"delay": 5e-4, "lag": 0.0},
        "cable_pull": {"stiffness": 10.0, "hysteresis": 10.0},
    }
    machine = Machine(robot=irb4600, effects=tuple(EFFECTS[k].on(irb4600, **values) for k, values in kinds.items()))
    stuck = EFFECTS["dwell_stiction"].on(irb4600, share=0.3)
    other = Machine(robot=irb4600, effects=(stuck, *machine.effects[1:]))
    q = np.stack([corners["p1"]] * 2)
    away = controls(Plant(irb4600, 2), 1.01 * irb4600.drive.motor_angle(q)[:, None].repeat(200, 1), shape=(2, 200, 6))
    ends = {}
    for what in ("undisturbed", "neighbour", "restored"):
        plant = Plant(machine, 2, n_threads=1)
        plant.rest(q)
        plant.drive(away)
        saved = plant.save()
        if what != "undisturbed":
            plant.become([0], [other])
            plant.rest(q[:1], ids=np.array([0]))
        if what == "restored":
            plant.drive(away)
            plant.restore(saved)
        plant.drive(away)
        ends[what] = plant.state().motor_position
    np.testing.assert_array_equal(ends["neighbour"][1], ends["undisturbed"][1])
    assert np.abs(ends["neighbour"][0] - ends["undisturbed"][0]).max() > 1e-6
    np.testing.assert_array_equal(ends["restored"], ends["undisturbed"])


def test_a_batch_that_cannot_become_what_is_asked_stays_as_it_was(irb4600, one_axis):
    plant = Plant(irb4600, 2)
    softer = replace(irb4600, drive=replace(irb4600.drive, joint_stiffness=irb4600.drive.joint_stiffness / 2))
    before = plant.fingerprint(0)
    with pytest.raises(FFGymError, match="differ in joints"):
        plant.become([0, 1], [softer, one_axis])
    with pytest.raises(FFGymError, match="1 robots for 2 simulations"):
        plant.become([0, 1], [softer])
    assert plant.robots == [irb4600, irb4600]
    assert plant.fingerprint(0) == before
    assert plant.batch.expanded("jnt_stiffness") is None


def test_a_robot_too_soft_for_gravity_is_refused(irb4600, corners):
    soft = replace(irb4600, drive=replace(irb4600.drive, joint_stiffness=irb4600.drive.joint_stiffness * 1e-3))
    with pytest.raises(FFGymError, match="too soft"):
        Plant(soft, 1).rest(corners["p1"][None])
