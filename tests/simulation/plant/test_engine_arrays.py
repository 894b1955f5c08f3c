"""What is read from the arrays of the engine, and written to them, joint by joint as written down by hand."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.effects import Torques
from ffgym.robot import ModelOptions, load_robot
from ffgym.robot.drive import Drive
from ffgym.simulation.plant import Plant
from ffgym.simulation.plant.engine_state import Addresses, PlantState, hinge_torques
from ffgym.simulation.plant.reading import EngineState, Reading
from tests.simulation.plant.driving import EngineTables

RATIO = np.array([2.0, -3.0, 5.0])
MOTOR = np.array([0, 1, 3])
"""Places of motors; those of springs of joints 1 and 2 are 2 and 4."""


@pytest.fixture
def at():
    """Three joints: a rigid one, an elastic one without servo, and an elastic one with all there is."""
    integral, torque, bristle, arm_bristle = (
        np.array(each) for each in ([1, -1, 4], [2, -1, 5], [0, 3, -1], [-1, 7, 6])
    )
    return Addresses(
        motor_qpos=MOTOR,
        deflection_qpos=np.array([2, 4]),
        is_elastic=np.array([False, True, True]),
        extra_qpos=np.array([], dtype=int),
        extra_joint=np.array([], dtype=int),
        integral=integral,
        has_integral=integral >= 0,
        torque=torque,
        has_torque=torque >= 0,
        bristle=bristle,
        has_bristle=bristle >= 0,
        arm_bristle=arm_bristle,
        has_arm_bristle=arm_bristle >= 0,
    )


@pytest.fixture
def drive():
    stiffness = np.array([np.inf, 100.0, 100.0])
    each = {"rotor_inertia": np.ones(3), "joint_damping": np.ones(3), "peak_torque": np.full(3, 1e3)}
    return Drive(gear_ratio=RATIO, joint_stiffness=stiffness, **each)


@pytest.fixture
def tables():
    """Two simulations."""
    widths = {"qpos": 5, "qvel": 5, "act": 8, "ctrl": 9, "qfrc_actuator": 5, "qacc": 5}
    return EngineTables(time=(2, 1), **{name: (2, width) for name, width in widths.items()})


@pytest.fixture
def own():
    """Numbers of three machines, other ones on each joint."""
    rng, names = np.random.default_rng(5), ("position_gain", "velocity_gain", "integral_gain", "viscous")
    numbers = {name: rng.uniform(0.5, 2.0, (2, 3)) for name in (*names, "reflected_inertia", "loop_decay")}
    limits = {"peak_torque": np.full((2, 3), 1e3), "loop_most": np.full((2, 3), np.inf)}
    return numbers | limits


MOTOR_TORQUE = np.array([[0.3, 0.5, 0.7], [0.2, 0.4, 0.6]])


@pytest.fixture
def reading(tables, at, drive, own):
    return Reading(EngineState(tables, at, drive), slice(None), own, MOTOR_TORQUE)


def test_a_state_has_each_joints_motion_where_the_engine_has_it(reading, tables):
    qpos, qvel, act = (tables.arrays[name] for name in ("qpos", "qvel", "act"))
    none = np.zeros(2)
    np.testing.assert_array_equal(reading.joint_angle, qpos[:, [0, 1, 3]])
    np.testing.assert_array_equal(reading.joint_speed, qvel[:, [0, 1, 3]])
    np.testing.assert_allclose(reading.motor_speed, qvel[:, [0, 1, 3]] * RATIO)
    np.testing.assert_array_equal(reading.deflection, np.stack([none, qpos[:, 2], qpos[:, 4]], axis=1))
    np.testing.assert_array_equal(reading.deflection_rate, np.stack([none, qvel[:, 2], qvel[:, 4]], axis=1))
    np.testing.assert_array_equal(reading.bristle, np.stack([act[:, 0], act[:, 3], none], axis=1))
    np.testing.assert_array_equal(reading.time, tables.arrays["time"])
    np.testing.assert_array_equal(reading.is_rigid, [True, False, False])


def test_servos_command_by_position_speed_and_integral_errors_and_feed_forward(reading, tables, own):
    qpos, qvel, act, ctrl = (tables.arrays[name] for name in ("qpos", "qvel", "act", "ctrl"))
    integral = {0: act[:, 1], 1: np.zeros(2), 2: act[:, 4]}
    for j, motor in enumerate(MOTOR):
        feedback = (
            own["position_gain"][:, j] * (ctrl[:, 3 * j] - RATIO[j] * qpos[:, motor])
            + own["velocity_gain"][:, j] * (ctrl[:, 3 * j + 1] - RATIO[j] * qvel[:, motor])
            + own["integral_gain"][:, j] * integral[j]
        )
        np.testing.assert_allclose(reading.feedback_torque[:, j], feedback, rtol=1e-14)
        np.testing.assert_allclose(reading.command[:, j], feedback + ctrl[:, 3 * j + 2], rtol=1e-14)


def test_torque_loops_go_towards_the_command_and_joints_without_one_are_there(reading, tables, own):
    command, act = reading.command, tables.arrays["act"]
    for j, before in ((0, act[:, 2]), (2, act[:, 5])):
        later = command[:, j] + (before - command[:, j]) * own["loop_decay"][:, j]
        np.testing.assert_allclose(reading.loop_torque[:, j], later, rtol=1e-13)
    np.testing.assert_array_equal(reading.loop_torque[:, 1], command[:, 1])


def test_without_torque_loops_the_command_acts(tables, at, drive, own):
    none = replace(at, torque=np.full(3, -1), has_torque=np.zeros(3, dtype=bool))
    state = Reading(EngineState(tables, none, drive), slice(None), own, MOTOR_TORQUE)
    np.testing.assert_array_equal(state.loop_torque, state.motor_torque)


def test_links_behind_a_rigid_joint_get_what_rotor_and_friction_leave(reading, tables, own):
    driven, acceleration, speed = (tables.arrays[name][:, 0] for name in ("qfrc_actuator", "qacc", "qvel"))
    rotor = own["reflected_inertia"][:, 0] * acceleration
    friction = RATIO[0] ** 2 * own["viscous"][:, 0] * speed
    np.testing.assert_allclose(reading.rigid_load[:, 0], driven + MOTOR_TORQUE[:, 0] - rotor - friction)


def test_viscous_friction_of_a_motor_without_bristles_is_no_actuator(tables, at, drive, own):
    smooth = replace(at, has_bristle=np.array([False, True, False]))
    state = Reading(EngineState(tables, smooth, drive), slice(None), own, MOTOR_TORQUE)
    driven, acceleration = (tables.arrays[name][:, 0] for name in ("qfrc_actuator", "qacc"))
    expected = driven + MOTOR_TORQUE[:, 0] - own["reflected_inertia"][:, 0] * acceleration
    np.testing.assert_allclose(state.rigid_load[:, 0], expected)


def test_elastic_joints_need_no_outputs_of_the_engine(tables, at, drive, own):
    elastic = replace(at, is_elastic=np.ones(3, dtype=bool), deflection_qpos=np.array([0, 2, 4]))
    for name in ("qfrc_actuator", "qacc"):
        del tables.arrays[name]
    state = Reading(EngineState(tables, elastic, drive), slice(None), own, MOTOR_TORQUE)
    assert state.rigid_load is None
    np.testing.assert_array_equal(state.deflection, tables.arrays["qpos"][:, [0, 2, 4]])


def test_some_simulations_are_read_as_all_are(tables, at, drive, own):
    rows = np.array([1])
    some = Reading(EngineState(tables, at, drive), rows, {k: v[rows] for k, v in own.items()}, MOTOR_TORQUE[rows])
    every = Reading(EngineState(tables, at, drive), slice(None), own, MOTOR_TORQUE)
    for name in ("time", "joint_angle", "deflection", "bristle", "command", "loop_torque", "rigid_load"):
        np.testing.assert_array_equal(getattr(some, name), getattr(every, name)[1:], err_msg=name)


def test_a_plant_state_adds_springs_to_motors_and_has_zeros_where_there_is_nothing(at, drive):
    qpos, qvel, act = np.arange(1.0, 6.0), np.arange(11.0, 16.0), np.arange(21.0, 29.0)
    state = PlantState.of(at, drive, qpos, qvel, act)
    assert state.motor_position.tolist() == [2.0 * 1, -3.0 * 2, 5.0 * 4]
    assert state.motor_velocity.tolist() == [2.0 * 11, -3.0 * 12, 5.0 * 14]
    assert state.link_position.tolist() == [1, 2 + 3, 4 + 5]
    assert state.link_velocity.tolist() == [11, 12 + 13, 14 + 15]
    assert state.bristle.tolist() == [21, 24, 0]
    assert state.arm_bristle.tolist() == [0, 28, 27]
    assert state.integral.tolist() == [22, 0, 25]
    assert qpos.tolist() == [1, 2, 3, 4, 5]  # it is a copy


def test_rigid_joints_have_no_address_of_a_deflection(at):
    assert at.deflection_of_joint.tolist() == [-1, 2, 4]


def test_layouts_with_another_address_have_another_key(at):
    assert replace(at).key == at.key
    assert replace(at, torque=np.array([2, -1, 6])).key != at.key
    # the same numbers, of other variables
    assert replace(at, extra_qpos=np.array([1]), extra_joint=np.array([], dtype=int)).key != (
        replace(at, extra_qpos=np.array([], dtype=int), extra_joint=np.array([1])).key
    )


def test_effects_turn_motors_through_the_gearbox_and_links_behind_it(drive):
    motor, spring, link = np.array([[1.0, 2.0, 3.0]]), np.full((1, 3), 0.5), np.full((1, 3), 7.0)
    on_motor, turning, behind = hinge_torques(drive, Torques(motor=motor, spring=spring, link=link))
    assert on_motor.tolist() == [[2.0, -6.0, 15.0]]
    assert turning.tolist() == [[9.0, 1.0, 22.0]]  # both turn the motor's hinge
    assert behind.tolist() == [[7.5, 7.5, 7.5]]
    assert hinge_torques(drive, Torques()) == (None, None, None)


def arm_with(integral_gain, coupling=None):
    """Three plants of an arm with a rigid joint that has a torque loop, and an elastic joint without."""
    robot = load_robot("two_link")
    drive = replace(
        robot.drive, joint_stiffness=np.array([np.inf, 2e5]), torque_lag=np.array([2e-3, 0.0]), coupling=coupling
    )
    servo = replace(robot.servo, integral_gain=np.array(integral_gain))
    return Plant(replace(robot, drive=drive, servo=servo), 3, n_threads=1)


@pytest.mark.parametrize(
    ("gain", "integral", "torque", "bristle"),
    [
        ([9.0, 0.0], [0, -1], [1, -1], [2, 3]),
        ([0.0, 9.0], [-1, 2], [0, -1], [1, 3]),
        ([0.0, 0.0], [-1, -1], [0, -1], [1, 2]),
    ],
)
def test_addresses_follow_the_order_of_the_model(gain, integral, torque, bristle):
    plant = arm_with(gain)
    at, model = plant.addresses, plant.model
    assert [model.joint(i).name for i in range(model.njnt)] == ["shoulder_motor", "elbow_motor", "elbow_deflection"]
    assert at.motor_qpos.tolist() == [0, 1]
    assert at.deflection_qpos.tolist() == [2]
    assert at.is_elastic.tolist() == [False, True]
    assert at.extra_qpos.size == at.extra_joint.size == 0
    for name, places in (("integral", integral), ("torque", torque), ("bristle", bristle), ("arm_bristle", [-1, -1])):
        assert getattr(at, name).tolist() == places, name
        assert getattr(at, f"has_{name}").tolist() == [place >= 0 for place in places], name


@pytest.mark.parametrize("coupling", [None, np.array([[0.0, 0.0], [20.0, 0.0]])])
@pytest.mark.parametrize("gain", [[9.0, 0.0], [0.0, 9.0], [0.0, 0.0]])
def test_servos_know_the_motors_of_their_own_simulation(gain, coupling):
    plant, rng = arm_with(gain, coupling), np.random.default_rng(0)
    qpos, qvel, act = (plant.batch.bind(name) for name in ("qpos", "qvel", "act"))
    for values in (qpos, qvel, act):
        values[:] = rng.normal(size=values.shape)
    # motors turn a hundred times as far, the second one also with the first joint
    known = plant.servo_state()
    for row in range(3):
        for values, seen in ((qpos, known[0]), (qvel, known[1])):
            with_first = 0.0 if coupling is None else 20.0 * values[row, 0]
            np.testing.assert_allclose(seen[row], [100 * values[row, 0], 100 * values[row, 1] + with_first], rtol=1e-14)
        integral = [act[row, 0] if gain[0] else 0.0, act[row, 2] if gain[1] else 0.0]
        assert known[2, row].tolist() == integral


def test_what_stands_first_in_the_model_is_there(two_link):
    """An address may be 0: bristles, where servos have neither integrals nor torque loops."""
    at = Plant(replace(two_link, servo=replace(two_link.servo, integral_gain=np.zeros(2))), 1, n_threads=1).addresses
    assert at.bristle.tolist() == [0, 1]
    assert at.has_bristle.all()
    assert not at.has_integral.any()
    assert not at.has_torque.any()


@pytest.mark.parametrize(("share", "place"), [([1.0, 0.0], [0, -1]), ([0.0, 1.0], [-1, 1])])
def test_bristles_on_links_alone_stand_in_the_order_of_joints(share, place, two_link):
    friction = replace(two_link.friction, arm_share=np.array(share))
    servo = replace(two_link.servo, integral_gain=np.zeros(2))
    at = Plant(replace(two_link, friction=friction, servo=servo), 1, n_threads=1).addresses
    assert at.arm_bristle.tolist() == place
    assert at.has_arm_bristle.tolist() == [each == 1.0 for each in share]
    assert at.has_bristle.tolist() == [each == 0.0 for each in share]


@pytest.mark.parametrize("friction", [True, False])
def test_without_friction_motors_have_no_bristles(two_link, friction):
    plant = Plant(two_link, 1, options=ModelOptions(friction=friction), n_threads=1)
    assert plant.addresses.has_bristle.tolist() == [friction, friction]
