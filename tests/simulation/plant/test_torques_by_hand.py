"""Effects of constant torque on an arm of two links, whose rest, forces and readings can be written down by hand."""

from dataclasses import dataclass, replace

import mujoco
import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS, ResolverEffect, ResolverError, TorqueEffect, Torques, parameter
from ffgym.robot import ModelOptions, load_robot
from ffgym.simulation.plant import Machine, Plant
from ffgym.simulation.plant.forces import Forces
from tests.simulation.plant.driving import controls

DT = 0.00025
RATIO = 100.0
WEIGHTLESS = ModelOptions(gravity=False, looks=False)


@dataclass(frozen=True, kw_only=True, eq=False)
class Pushing(TorqueEffect):
    """Constant torques at all places; it remembers how often it was asked."""

    name = "pushing"
    title = equation = signature = way_in = "a test"
    side = "link"
    motor: np.ndarray = parameter("a", unit="N m", low=0.0, high=1.0, source="a test")  # noqa: RUF009
    spring: np.ndarray = parameter("b", unit="N m", low=0.0, high=1.0, source="a test")  # noqa: RUF009
    link: np.ndarray = parameter("c", unit="N m", low=0.0, high=1.0, source="a test")  # noqa: RUF009

    def initial_memory(self, state):
        return np.zeros((*state.motor_angle.shape, 1))

    def torques(self, state, memory, dt):
        return Torques(motor=self.motor, spring=self.spring, link=self.link), memory + 1.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Turning(TorqueEffect):
    """A constant torque on motors alone."""

    name = "turning"
    title = equation = signature = way_in = "a test"
    side = "motor"
    motor: np.ndarray = parameter("a", unit="N m", low=0.0, high=1.0, source="a test")  # noqa: RUF009

    def torques(self, state, memory, dt):
        return Torques(motor=self.motor + 0.0 * state.motor_angle), memory


@dataclass(frozen=True, kw_only=True, eq=False)
class Leading(ResolverEffect):
    """A resolver that reads a share more than there is."""

    name = "leading"
    title = equation = signature = way_in = "a test"
    side = "motor"
    share: np.ndarray = parameter("a", unit="1", low=0.0, high=1.0, source="a test")  # noqa: RUF009

    def error(self, motor_angle, motor_speed):
        return ResolverError(angle=self.share * motor_angle, speed=self.share * motor_speed)


@dataclass(frozen=True, kw_only=True, eq=False)
class Branching(Leading):
    """One of which no code can be made."""

    name = "branching_resolver"

    def error(self, motor_angle, motor_speed):
        moving = bool(np.any(motor_speed != 0))
        return super().error(motor_angle, motor_speed if moving else 0.0 * motor_speed)


PUSH = {"motor": [0.5, -0.3], "spring": [20.0, 30.0], "link": [-50.0, 70.0]}
SHARE = np.array([0.01, 0.02])


def by_numpy(machines, options=None):
    """Plant of machines without code, so that the engine's arrays show what is written."""
    plant = Plant(Machine.of(machines[0]), len(machines), options=options, n_threads=1)
    plant.become(range(len(machines)), machines)
    if plant._forces is not None:
        vars(plant._forces)["_compiled"] = (None, np.ones(len(machines), dtype=np.bool_))
    return plant


def pushed(robot, size=1.0):
    return Machine(robot=robot, effects=(Pushing.on(robot, **{k: size * np.array(v) for k, v in PUSH.items()}),))


def leading(robot):
    return Machine(robot=robot, effects=(Leading.on(robot, share=SHARE),))


def reading(robot, period=2 * DT, bits=20):
    drive = replace(robot.drive, resolver_period=period)
    return replace(robot, drive=drive, sensors=replace(robot.sensors, encoder_bits=bits))


def test_springs_and_servos_hold_constant_torques_at_rest(two_link):
    plant = by_numpy([pushed(two_link), pushed(two_link, 2.0), Machine(robot=two_link)], WEIGHTLESS)
    plant.rest(np.zeros((3, 2)))
    state = plant.state()
    for row, size in enumerate((1.0, 2.0, 0.0)):
        motor, spring, link = (size * np.array(PUSH[name]) for name in ("motor", "spring", "link"))
        deflection = (spring + link) / two_link.drive.joint_stiffness
        np.testing.assert_allclose(state.link_position[row], deflection, rtol=1e-9, atol=1e-15)
        servo = two_link.servo.integral_gain * state.integral[row]
        np.testing.assert_allclose(servo, -(motor + link / RATIO), rtol=1e-9, atol=1e-15)
    plant.drive(controls(plant, np.zeros((3, 40, 2))))
    np.testing.assert_allclose(plant.state().link_position, state.link_position, atol=1e-12)


@pytest.mark.parametrize("q", [[0.0, 0.0], [0.6, -1.1]])
def test_arms_with_and_without_effects_hang_in_balance_under_gravity(q, two_link):
    """Nothing moves when the engine goes on, and each joint's spring carries what hangs on it."""
    soft = replace(two_link, drive=replace(two_link.drive, joint_stiffness=np.array([3e4, 1e4])))
    plant = by_numpy([pushed(soft), Machine(robot=soft), pushed(soft, 2.0)])
    plant.rest(np.tile(q, (3, 1)))
    before = plant.state()
    bent = before.link_position - q
    assert np.abs(bent[1]).max() > 1e-3
    plant.drive(controls(plant, np.tile(RATIO * np.array(q), (3, 60, 1))))
    np.testing.assert_allclose(plant.state().link_position, before.link_position, rtol=0, atol=1e-11)
    # springs, effects between them and on links against gravity
    gravity = plant.batch.bind("qfrc_bias")[:, plant.addresses.deflection_qpos]
    for row, size in enumerate((1.0, 0.0, 2.0)):
        pushes = size * np.add(PUSH["spring"], PUSH["link"])
        np.testing.assert_allclose(soft.drive.joint_stiffness * bent[row], pushes - gravity[row], rtol=1e-6)


def test_joints_with_backlash_hang_at_an_edge_of_it_or_at_the_lowest_place_within(two_link):
    gap = 1e-3
    backlash = EFFECTS["backlash"].on(two_link, half_gap=gap)
    down, asides = np.array([-np.pi / 2, 0.0]), np.array([[5e-4, 2e-4], [5e-4, -6e-4]])
    q = np.stack([np.zeros(2), *(down + asides)])
    plant, tight = Plant(Machine(robot=two_link, effects=(backlash,)), 3, n_threads=1), Plant(two_link, 3, n_threads=1)
    for each in (plant, tight):
        each.rest(q)
    loose, bare = plant.state().link_position, tight.state().link_position
    np.testing.assert_allclose(loose[0], bare[0] - gap, rtol=0, atol=0.02 * gap)
    np.testing.assert_allclose(loose[1:], [down, down], rtol=0, atol=1e-9)
    plant.drive(controls(plant, RATIO * q[:, None].repeat(60, axis=1)))
    np.testing.assert_allclose(plant.state().link_position, loose, rtol=0, atol=1e-9)


def test_bases_that_give_way_carry_the_arms_on_them(two_link):
    """Each by its own compliance, of one for all and of different ones."""
    tilt = np.array([1e-6, 3e-6, 1e-6])
    first, other = (
        Machine(robot=two_link, effects=(EFFECTS["base_flexibility"].on(two_link, compliance=[0.0, c, 0.0]),))
        for c in tilt[:2]
    )
    plant = Plant(first, 3, n_threads=1)
    at, gravity, qpos = plant.addresses, plant.batch.bind("qfrc_bias"), plant.batch.bind("qpos")
    assert at.extra_qpos.size == 1
    for compliance in (np.full(3, 1e-6), tilt):
        plant.rest(np.array([[0.1, 0.2], [0.1, 0.2], [0.5, -0.3]]))
        np.testing.assert_allclose(qpos[:, at.extra_qpos], -compliance[:, None] * gravity[:, at.extra_qpos], rtol=1e-9)
        assert np.abs(qpos[:, at.extra_qpos]).min() > 1e-5
        plant.become([1], [other])


def test_the_first_robot_that_is_too_soft_is_named_with_its_stiffness(two_link):
    soft, softer = (
        replace(two_link, name=name, drive=replace(two_link.drive, joint_stiffness=np.full(2, stiffness)))
        for name, stiffness in (("soft", 20.0), ("softer", 10.0))
    )
    plant = Plant(two_link, 4, n_threads=1)
    plant.become([1, 2], [soft, softer])
    with pytest.raises(FFGymError, match=r"'soft' finds no equilibrium .* \[20\. 20\.\] N m/rad is too soft"):
        plant.rest(np.zeros((3, 2)), ids=np.array([1, 2, 3]))


def test_rigid_joints_do_not_bend_and_their_servos_hold_all(two_link):
    rigid = replace(two_link, drive=replace(two_link.drive, joint_stiffness=np.array([np.inf, 2e5])))
    plant = by_numpy([pushed(rigid)], WEIGHTLESS)
    plant.rest(np.zeros((1, 2)))
    state = plant.state()
    np.testing.assert_allclose(state.link_position[0], [0.0, 100.0 / 2e5], rtol=1e-9)
    np.testing.assert_allclose(two_link.servo.integral_gain * state.integral[0], [0.0, -0.4], rtol=1e-9, atol=1e-12)


def test_torques_go_to_the_hinges_of_motors_and_deflections(two_link):
    plant = by_numpy([pushed(two_link), Machine(robot=two_link), pushed(two_link, 2.0)])
    plant.rest(np.zeros((3, 2)))
    plant.drive(controls(plant, np.zeros((3, 1, 2))))
    at, applied = plant.addresses, plant.batch.bind("qfrc_applied")
    hinge = RATIO * np.array(PUSH["motor"]) + PUSH["link"]
    behind = np.add(PUSH["spring"], PUSH["link"])
    for row, size in enumerate((1.0, 0.0, 2.0)):
        np.testing.assert_allclose(applied[row, at.motor_qpos], size * hinge)
        np.testing.assert_allclose(applied[row, at.deflection_qpos], size * behind)


def test_effects_are_asked_once_in_each_step_of_the_simulations_that_go_on(two_link):
    plant = by_numpy([pushed(two_link)] * 3)
    plant.rest(np.zeros((3, 2)))
    plant.drive(controls(plant, np.zeros((2, 5, 2))), np.array([0, 2]))
    plant.drive(controls(plant, np.zeros((1, 2, 2))), np.array([2]))
    memory, motor = plant._forces.copy_memories()
    assert memory[:, 0, 0].tolist() == [5.0, 0.0, 7.0]
    np.testing.assert_allclose(motor, RATIO * np.outer([1, 0, 1], PUSH["motor"]))
    # a rest begins anew, of those that rest
    plant.rest(np.zeros((1, 2)), ids=np.array([2]))
    memory, motor = plant._forces.copy_memories()
    assert memory[:, 1, 0].tolist() == [5.0, 0.0, 0.0]
    assert motor[:, 0].tolist() == [50.0, 0.0, 0.0]


def test_memories_are_kept_and_given_back(two_link):
    plant = by_numpy([pushed(reading(two_link))])
    plant.rest(np.zeros((1, 2)))
    plant.drive(controls(plant, np.zeros((1, 3, 2))))
    kept = plant._forces.copy_memories()
    plant.drive(controls(plant, np.ones((1, 4, 2))))
    assert plant._forces.copy_memories()[0][0, 0, 0] == 7.0
    plant._forces.remember(kept)
    for now, before in zip(plant._forces.copy_memories(), kept, strict=True):
        np.testing.assert_array_equal(now, before)


def test_neighbours_keep_what_they_remember_when_one_becomes_another(two_link):
    plant = by_numpy([pushed(reading(two_link))] * 3)
    plant.rest(np.full((3, 2), 0.1))
    plant.drive(controls(plant, np.zeros((3, 3, 2))))
    before = plant._forces.copy_memories()
    robot = reading(two_link)
    before_it = EFFECTS["backlash"].on(robot, half_gap=1e-4)  # in the order of effects on links
    both = Machine(robot=robot, effects=(Turning.on(robot, motor=0.1), *pushed(robot, 2.0).effects, before_it))
    plant.become([1], [both])
    after = plant._forces.copy_memories()
    of_pushing = next(memory for memory in after if memory.shape == (3, 2, 1))
    assert of_pushing[:, 0, 0].tolist() == [3.0, 0.0, 3.0]
    for now, then in zip(after[-4:], before[-4:], strict=True):  # motors, angles, speeds and counts
        np.testing.assert_array_equal(now[[0, 2]], then[[0, 2]])
        assert now.any()


def test_a_neighbour_may_begin_and_cease_to_read_a_resolver(two_link):
    plant = by_numpy([pushed(two_link)] * 2)
    plant.rest(np.zeros((2, 2)))
    for robot, reads in ((reading(two_link), True), (two_link, False)):
        plant.drive(controls(plant, np.zeros((2, 3, 2))))
        plant.become([1], [pushed(robot)])
        plant.rest(np.zeros((1, 2)), ids=np.array([1]))
        assert (plant.reading() is not None) is reads
        memory = plant._forces.copy_memories()[0]
        assert memory[0, 0, 0] > 0.0
        assert memory[1, 0, 0] == 0.0


def test_servos_rest_where_their_resolvers_read_what_was_asked(two_link):
    plant = by_numpy([leading(two_link), Machine(robot=two_link)], WEIGHTLESS)
    asked = np.array([[0.3, -0.2], [0.3, -0.2]])
    plant.rest(asked)
    np.testing.assert_allclose(plant.servo_state()[0] / RATIO, asked, rtol=1e-12)
    true = plant.state().motor_position / RATIO
    np.testing.assert_allclose(true, [asked[0] / (1 + SHARE), asked[1]], rtol=1e-12)


@pytest.mark.parametrize("kinds", ["one reads", "all read", "none reads"])
def test_what_servos_know_is_the_reading_or_the_truth_with_its_error(kinds, two_link):
    coarse = reading(two_link, bits=6)
    robots = {"one reads": [coarse, two_link], "all read": [coarse, coarse], "none reads": [two_link, two_link]}[kinds]
    plant = by_numpy([leading(robot) for robot in robots], WEIGHTLESS)
    plant.rest(np.full((2, 2), 0.1), np.array([[0.02, 0.03], [0.02, 0.03]]))
    plant.drive(controls(plant, np.full((2, 5, 2), RATIO * 0.1)))
    state, known = plant.state(), plant.servo_state()
    for row, robot in enumerate(robots):
        angle, speed = (1 + SHARE) * state.motor_position[row], (1 + SHARE) * state.motor_velocity[row]
        if robot is coarse:  # taken one step before, at most
            steps = known[0, row] * 2**6 / (2 * np.pi)
            np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
            np.testing.assert_allclose(known[0, row], angle, atol=np.pi / 2**6 + np.abs(speed * 2 * DT).max())
        else:
            np.testing.assert_allclose(known[:2, row], [angle, speed], rtol=1e-12)
    if kinds == "none reads":
        assert plant.reading() is None
    else:
        np.testing.assert_array_equal(plant.reading(), np.concatenate([known[0], known[1]], axis=1))


def test_a_resolver_begins_with_the_speed_that_its_error_shows(two_link):
    plant = by_numpy([leading(reading(two_link, bits=24))], WEIGHTLESS)
    plant.rest(np.full((1, 2), 0.1), np.array([[0.02, 0.03]]))
    resolution = 2 * np.pi / 2**24 / (2 * DT)
    expected = (1 + SHARE) * RATIO * np.array([0.02, 0.03])
    np.testing.assert_allclose(plant.servo_state()[1, 0], expected, rtol=0, atol=1.01 * resolution)


def test_without_resolvers_no_readings_are_recorded(two_link):
    for machine in (Machine(robot=two_link), pushed(two_link), leading(two_link)):
        plant = by_numpy([machine])
        plant.rest(np.zeros((1, 2)))
        *state, readings = plant.advance_with_readings(controls(plant, np.zeros((1, 3, 2))))
        assert readings is None
        assert [len(each[0]) for each in state] == [3, 3, 3]


def test_servos_compare_set_points_with_what_they_know(two_link):
    plant = by_numpy([leading(two_link)], WEIGHTLESS)
    plant.rest(np.full((1, 2), 0.1), np.full((1, 2), 0.02))
    before = plant.state()
    row = controls(plant, np.full((1, 1, 2), 3.0), 5.0, 7.0)
    plant.drive(row)
    position, velocity, torque = plant.split_controls(plant.batch.bind("ctrl"))
    np.testing.assert_allclose(position, 3.0 - SHARE * before.motor_position, rtol=1e-12)
    np.testing.assert_allclose(velocity, 5.0 - SHARE * before.motor_velocity, rtol=1e-12)
    np.testing.assert_array_equal(torque, 7.0)


@pytest.mark.parametrize("ids", [None, [1], [0, 2]])
def test_what_is_recorded_is_the_state_after_each_step(ids, two_link):
    robot, rows = reading(two_link), range(3) if ids is None else ids
    machines = [Machine(robot=robot, effects=pushed(robot).effects + leading(robot).effects)] * 3
    whole, stepped = by_numpy(machines), by_numpy(machines)
    for plant in (whole, stepped):
        plant.rest(np.full((3, 2), 0.1))
    ids = None if ids is None else np.array(ids)
    wanted = controls(whole, RATIO * 0.1 + np.random.default_rng(0).normal(size=(len(rows), 6, 2)))
    found = whole.advance_with_readings(wanted, ids)
    for k in range(6):
        stepped.drive(wanted[:, k : k + 1], ids)
        now = [*(stepped.batch.bind(name) for name in ("qpos", "qvel", "act")), stepped.reading()]
        for recorded, value in zip(found, now, strict=True):
            np.testing.assert_array_equal(recorded[:, k], value[list(rows)])


def test_machines_whose_resolvers_have_no_code_are_told_from_the_others(two_link):
    odd = Machine(robot=two_link, effects=(Branching.on(two_link, share=SHARE),))
    plant = Plant(two_link, 3, n_threads=1)
    plant.become(range(3), [leading(two_link), odd, Machine(robot=two_link)])
    compiled, without_code = plant._forces._compiled
    assert compiled is not None
    assert without_code.tolist() == [False, True, False]


def test_forces_are_needed_by_torques_errors_and_readings_of_any_machine(two_link):
    plain = Machine(robot=two_link)
    assert not Forces.needed([plain, plain])
    for machine in (pushed(two_link), leading(two_link), Machine(robot=reading(two_link))):
        assert Forces.needed([plain, machine])


def test_only_effects_on_links_bend(two_link):
    turned = Machine(robot=two_link, effects=(Turning.on(two_link, motor=0.1),))
    plant = by_numpy([turned, pushed(two_link), Machine(robot=two_link)])
    assert plant._forces.bends.tolist() == [False, True, False]
    on_links = plant._forces.choose(slice(None)).on_links
    assert [type(effect) for effect in on_links.torque] == [Pushing]


def test_some_are_chosen_with_their_own_numbers(two_link):
    plant = by_numpy([pushed(two_link, size) for size in (1.0, 2.0, 3.0)])
    chosen = plant._forces.choose(np.array([0, 2]))
    assert chosen.everyone.tolist() == [[0], [2]]
    np.testing.assert_allclose(chosen.torque[0].motor[:, 0], [0.5, 1.5])
    assert chosen.present == (None,)  # all have it
    mixed = by_numpy([pushed(two_link), Machine(robot=two_link), pushed(two_link)])._forces
    assert mixed.choose(np.array([1, 2])).present[0].tolist() == [[False], [True]]
    assert all(len(values) == 2 for values in chosen.numbers.values())


# the plant itself


def test_control_steps_are_whole_numbers_of_physics_steps(two_link):
    assert Plant(two_link, 1, n_threads=1).n_substeps == 16
    one = Plant(two_link, 1, options=ModelOptions(physics_dt=two_link.servo.control_dt), n_threads=1)
    assert one.n_substeps == 1
    for dt in (0.0003, 0.006, 0.009):
        with pytest.raises(FFGymError, match=rf"physics_dt = {dt} s must divide control_dt = 0\.004 s exactly"):
            Plant(two_link, 1, options=ModelOptions(physics_dt=dt), n_threads=1)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"n_robots": 0}, "n_robots"),
        ({"n_threads": -1}, "n_threads"),
        ({"n_threads": 1025}, "n_threads"),
        ({"options": ModelOptions(servo=False)}, "needs its servos"),
    ],
)
def test_a_plant_of_nothing_is_refused(values, says, two_link):
    with pytest.raises(FFGymError, match=says):
        Plant(two_link, **{"n_robots": 1} | values)


def test_a_torque_loop_rests_at_the_torque_that_holds_the_arm_up_to_its_peak(two_link):
    drive = replace(two_link.drive, torque_lag=np.array([2e-3, 2e-3]))
    strong, weak = (replace(drive, peak_torque=np.full(2, peak)) for peak in (400.0, 0.01))
    plant = Plant(replace(two_link, drive=strong), 2, n_threads=1)
    plant.become([1], [replace(two_link, drive=weak)])
    plant.rest(np.zeros((2, 2)))
    commanded = two_link.servo.integral_gain * plant.state().integral
    given = plant.batch.bind("act")[:, plant.addresses.torque]
    assert np.abs(commanded).min() > 0.01
    np.testing.assert_allclose(given, [commanded[0], np.clip(commanded[1], -0.01, 0.01)], rtol=1e-12)


def test_a_servo_without_integral_rests_without_one(two_link):
    half = replace(two_link, servo=replace(two_link.servo, integral_gain=np.array([0.0, 0.5])))
    plant = Plant(half, 1, n_threads=1)
    plant.rest(np.zeros((1, 2)))
    integral = plant.state().integral[0]
    assert integral[0] == 0.0
    assert integral[1] != 0.0


def test_some_are_put_to_rest_and_others_left_alone(two_link):
    plant = Plant(two_link, 3, n_threads=1)
    plant.rest(np.full((3, 2), 0.2))
    before = plant.batch.state.copy()
    plant.rest(np.array([[0.5, 0.6]]), np.array([[0.1, 0.2]]), ids=np.array([1]))
    state = plant.state()
    np.testing.assert_allclose(state.motor_position[1], [50.0, 60.0])
    np.testing.assert_allclose(state.motor_velocity[1], [10.0, 20.0])
    np.testing.assert_array_equal(plant.batch.state[[0, 2]], before[[0, 2]])


def test_an_unstable_simulation_is_named_with_when_it_failed_and_may_go_on_from_rest(two_link):
    plant = Plant(two_link, 3, n_threads=1)
    plant.rest(np.zeros((3, 2)))
    plant.drive(controls(plant, np.zeros((3, 4, 2))))
    rows = controls(plant, np.zeros((3, 12, 2)))
    rows[1, 5] = rows[2, 1] = np.nan
    before = mujoco.get_mju_user_warning()
    with pytest.raises(FFGymError, match=r"Simulation 1 .*no number below 1e10 between t = 0\.001 s and 0\.004 s"):
        plant.drive(rows)
    assert mujoco.get_mju_user_warning() is before
    plant.rest(np.zeros((3, 2)))
    plant.drive(controls(plant, np.zeros((3, 4, 2))))
    # what went wrong before is not told again
    plant.drive(controls(plant, np.zeros((3, 4, 2))))
    plant.batch.bind("qvel")[2] = 1e12
    with pytest.raises(FFGymError, match=r"Simulation 2 .*became unstable.*physics step of 0\.00025 s"):
        plant.drive(controls(plant, np.zeros((3, 1, 2))))


def test_the_tool_of_a_machine_whose_base_gives_way_is_where_the_engine_has_it(irb4600):
    base = EFFECTS["base_flexibility"].on(irb4600, compliance=[1e-7, 0.0, 0.0])
    plant = Plant(Machine(robot=irb4600, effects=(base,)), 2, n_threads=1)
    assert plant.addresses.extra_qpos.size == 1
    rng = np.random.default_rng(0)
    qpos = rng.uniform(-0.2, 0.2, (3, plant.model.nq))
    points = plant.tcp_position(1, qpos)
    data = mujoco.MjData(plant.model)
    for k in range(3):
        data.qpos[:] = qpos[k]
        mujoco.mj_forward(plant.model, data)
        np.testing.assert_allclose(points[k], data.site("tcp").xpos, atol=1e-12)
    assert Plant(irb4600, 1, n_threads=1).tcp_position(0, qpos) is None


def test_each_simulation_has_the_fingerprint_of_its_own_machine(two_link):
    lighter = replace(two_link, drive=replace(two_link.drive, rotor_inertia=0.9 * two_link.drive.rotor_inertia))
    plant = Plant(two_link, 3, n_threads=1)
    plant.become([1, 2], [lighter, pushed(two_link)])
    alone = [Plant(machine, 1, n_threads=1).fingerprint() for machine in (two_link, lighter, pushed(two_link))]
    assert [plant.fingerprint(k) for k in range(3)] == alone
    assert len(set(alone)) == 3
    assert plant.fingerprint() == alone[0]


def test_forces_of_a_machine_that_is_gone_are_gone(two_link):
    plant = by_numpy([pushed(two_link), Machine(robot=two_link)])
    plant.rest(np.zeros((2, 2)))
    plant.drive(controls(plant, np.zeros((2, 2, 2))))
    applied = plant.batch.bind("qfrc_applied")
    assert applied[0].any()
    plant.become([0], [Machine(robot=two_link)])
    assert not applied.any()


def test_going_back_restores_machines_and_forces(two_link):
    robot = load_robot("two_link")
    plant = by_numpy([pushed(robot), pushed(robot, 2.0)])
    plant.rest(np.zeros((2, 2)))
    plant.drive(controls(plant, np.zeros((2, 3, 2))))
    saved = plant.save()
    state = plant.batch.state.copy()
    plant.become([0], [Machine(robot=robot)])
    plant.rest(np.ones((2, 2)))
    plant.restore(saved)
    np.testing.assert_array_equal(plant.batch.state, state)
    assert plant._forces.copy_memories()[0][:, 0, 0].tolist() == [3.0, 3.0]
    assert [machine.effects == () for machine in plant.machines] == [False, False]
