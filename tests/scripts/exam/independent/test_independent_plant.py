"""The independent plant obeys physics: energy, equations of motion, springs, friction, order of the integrator."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.robot import RigidArm, load_robot
from ffgym.robot.parts import Kinematics
from scripts.exam.independent.arm import bodies_of, inverse_dynamics, mass_and_bias, pose_of, tool_of
from scripts.exam.independent.drive import Cascade, Contact, Continuous, Orders
from scripts.exam.independent.machine import numbers_of, side_by_side, unsure, with_fault
from scripts.exam.independent.plant import Plant
from scripts.exam.independent.robots import draw_robot


@pytest.fixture
def rng():
    return np.random.default_rng(26)


def arm_of_three_kinds(rng):
    """A drawn robot with a sliding joint between hinges."""
    robot = draw_robot(4, elastic=False, rng=rng)
    known = robot.kinematics
    kinematics = Kinematics(
        position=known.position,
        axis=known.axis,
        range=known.range,
        max_speed=known.max_speed,
        types=("hinge", "hinge", "slide", "hinge"),
    )
    return replace(robot, kinematics=kinematics)


@pytest.mark.parametrize("name", ["one_axis", "two_link", "irb4600_60_205", "slide", "drawn"])
def test_torques_of_a_rigid_arm_are_those_of_the_simulation(name, rng):
    drawn = {"slide": arm_of_three_kinds, "drawn": lambda rng: draw_robot(7, elastic=True, rng=rng)}
    robot = drawn[name](rng) if name in drawn else load_robot(name)
    q, dq, ddq = rng.uniform(-1, 1, (3, 20, robot.n_joints))
    bodies, theirs = bodies_of(robot, 20), RigidArm(robot)
    expected = theirs.inverse_dynamics(q, dq, ddq, gravity=True)
    np.testing.assert_allclose(inverse_dynamics(bodies, q, dq, ddq), expected, atol=1e-9 * np.abs(expected).max())
    if robot.tool is not None:
        np.testing.assert_allclose(tool_of(bodies, pose_of(bodies, q)), theirs.tcp_position(q), atol=1e-12)


def test_mass_matrix_and_bias_are_the_parts_of_inverse_dynamics(rng):
    robot = arm_of_three_kinds(rng)
    q, dq, ddq = rng.uniform(-1, 1, (3, 5, 4))
    bodies = bodies_of(robot, 5)
    matrix, bias = mass_and_bias(bodies, q, dq)
    np.testing.assert_allclose(
        np.einsum("bij,bj->bi", matrix, ddq) + bias, inverse_dynamics(bodies, q, dq, ddq), rtol=1e-10
    )


def plant_of(numbers, servo, dt=0.0005):
    """Plant of bristles, with its clock at zero and without warming."""
    clock, warming = np.zeros(numbers.shape[0]), np.zeros(numbers.shape)
    return Plant(numbers, contact_of(numbers.presliding), servo, dt=dt, clock=clock, warming=warming)


def contact_of(stiffness, blocks=False):
    """Contact of bristles alone, or of blocks alone."""
    return Contact(stiffness=stiffness, has_blocks=np.full(stiffness.shape, blocks))


def free(robot):
    """Machine without friction, and a servo that does nothing."""
    numbers = numbers_of(robot)
    tiny = np.full(numbers.shape, 1e-12)
    numbers = replace(
        numbers,
        coulomb=tiny,
        breakaway=tiny,
        viscous=0 * tiny,
        rubbing=0 * tiny,
        damping=0 * tiny,
    )
    return numbers, Continuous(position=0 * tiny, speed=0 * tiny, integral=0 * tiny)


def let_go(numbers, servo, q, dt, steps, every):
    """Course of a machine that is let go at rest."""
    shape = numbers.shape
    orders = Orders(
        position=np.zeros((2 * steps + 1, *shape)),
        speed=np.zeros((2 * steps + 1, *shape)),
        ahead=np.zeros((2 * steps + 1, *shape)),
    )
    plant = plant_of(numbers, servo, dt)
    plant._at_rest = lambda q, orders: np.stack([q, 0 * q, q * numbers.gear_ratio, 0 * q, 0 * q, 0 * q])
    plant._memory = np.zeros((*shape, 1))
    return plant.run(q, orders, every)


def total_energy(numbers, course):
    """Energy of arm, rotors and springs at each row [J]."""
    found = []
    for q, dq, angle, speed in zip(course.q, course.dq, course.angle, course.speed, strict=True):
        stretched = q - angle / numbers.gear_ratio
        rotors = 0.5 * np.sum(numbers.rotor * speed**2)
        springs = 0.5 * np.sum(numbers.stiffness * stretched**2)
        matrix, _ = mass_and_bias(numbers.bodies, q, dq)
        kinetic = 0.5 * dq[0] @ matrix[0] @ dq[0]
        height = pose_of(numbers.bodies, q).centre[0] @ numbers.bodies.gravity @ numbers.bodies.mass[0]
        found.append(float(kinetic - height) + rotors + springs)
    return np.array(found)


@pytest.mark.parametrize("elastic", [False, True])
def test_an_arm_without_friction_keeps_its_energy(elastic, rng):
    robot = draw_robot(3, elastic=elastic, rng=rng)
    numbers, servo = free(robot)
    course = let_go(numbers, servo, rng.uniform(-0.5, 0.5, (1, 3)), 0.0005, 800, 40)
    found = total_energy(numbers, course)
    moved = 0.5 * np.sum(numbers.rotor * course.speed**2, axis=(1, 2)).max()
    assert moved > 1e-3
    assert np.ptp(found) < 1e-6 * moved


def test_the_integrator_is_of_fourth_order(rng):
    robot = draw_robot(2, elastic=True, rng=rng)
    numbers, servo = free(robot)
    q = np.array([[0.3, -0.4]])
    ends = [
        let_go(numbers, servo, q, dt, round(0.128 / dt), round(0.128 / dt)).q[-1]
        for dt in (0.0008, 0.0004, 0.0002, 0.00005)
    ]
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(orders - 4) < 0.4), orders


def still(robot, numbers, servo, seconds=1.5):
    """Last row of a machine that is to stand still."""
    steps = round(seconds / 0.0005)
    q = np.zeros(numbers.shape)
    zero = np.zeros((2 * steps + 1, *numbers.shape))
    return plant_of(numbers, servo).run(q, Orders(position=zero, speed=zero, ahead=zero), steps)


def servo_of(robot, shape):
    gains = (robot.servo.position_gain, robot.servo.velocity_gain, robot.servo.integral_gain)
    kp, kv, ki = (np.broadcast_to(gain, shape) for gain in gains)
    return Continuous(position=kp, speed=kv, integral=ki)


def test_springs_carry_gravity_at_rest(rng):
    robot = draw_robot(2, elastic=True, rng=rng)
    numbers = numbers_of(robot)
    numbers = replace(numbers, damping=numbers.damping * 10)
    course = still(robot, numbers, servo_of(robot, numbers.shape))
    q, angle = course.q[-1], course.angle[-1]
    carried = -numbers.stiffness * (q - angle / numbers.gear_ratio)
    expected = inverse_dynamics(numbers.bodies, q, 0 * q, 0 * q)
    np.testing.assert_allclose(carried, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())
    np.testing.assert_allclose(
        course.torque[-1] * numbers.gear_ratio, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max()
    )


def test_play_gives_way_by_its_width(rng):
    robot = draw_robot(1, elastic=True, rng=rng)
    plain = replace(numbers_of(robot), damping=numbers_of(robot).damping * 10)
    loose = with_fault(plain, 0, gap=2e-4)
    both = side_by_side([plain, loose])
    course = still(robot, both, servo_of(robot, both.shape))
    bent = (course.q - course.angle / both.gear_ratio)[-1, :, 0]
    if abs(bent[0]) < 1e-7:
        pytest.skip("the axis that was drawn carries nothing")
    assert abs(bent[1] - bent[0]) == pytest.approx(2e-4, rel=0.01)  # round edges


@pytest.mark.parametrize("blocks", [False, True])
def test_friction_goes_from_one_sliding_direction_to_the_other_as_it_is_described(blocks):
    stiffness, strength = np.array([[70.0]]), np.array([[0.5]])
    surface = contact_of(stiffness, blocks)
    _, memory = surface.move(surface.at_rest(np.ones((1, 1)), strength), np.array([[-1.0]]), strength)
    for k in range(1, 40):
        force, memory = surface.move(memory, np.array([[0.001]]), strength)
        assert force.item() == pytest.approx(0.5 - np.exp(-70.0 * 0.001 * k / 0.5), abs=0.006)


def test_the_way_of_bristles_can_be_cut_into_pieces():
    surface, strength = contact_of(np.array([[70.0]])), np.array([[0.5]])
    whole, _ = surface.move(np.zeros((1, 1, 1)), np.array([[0.01]]), strength)
    memory = np.zeros((1, 1, 1))
    for _ in range(10):
        force, memory = surface.move(memory, np.array([[0.001]]), strength)
    np.testing.assert_allclose(force, whole, rtol=1e-12)


def test_blocks_and_bristles_stand_side_by_side():
    stiffness, strength, way = np.full((1, 2), 70.0), np.full((1, 2), 0.5), np.full((1, 2), 0.004)
    surface = Contact(stiffness=stiffness, has_blocks=np.array([[False, True]]))
    force, _ = surface.move(surface.at_rest(np.ones((1, 2)), strength), -way, strength)
    for column, blocks in enumerate((False, True)):
        alone = contact_of(stiffness, blocks)
        expected, _ = alone.move(alone.at_rest(np.ones((1, 2)), strength), -way, strength)
        assert force[0, column] == expected[0, column]
    assert force[0, 0] != force[0, 1]


def test_a_cascade_brings_motors_to_their_set_points(rng):
    robot = draw_robot(2, elastic=True, rng=rng)
    numbers = numbers_of(robot)
    shape = numbers.shape
    servo = Cascade(
        rate=np.full(shape, 30.0),
        speed=0.8 * servo_of(robot, shape).speed,
        reset=np.full(shape, 0.05),
        period=0.001,
        steps_of_turn=2.0**20,
        corner=200.0,
        rise=0.0007,
        delay=1,
        share_ahead=0.9,
    )
    steps = 3000
    t = np.arange(2 * steps + 1) * 0.00025
    ramp = np.clip((t - 0.1) / 0.4, 0, 1)
    wanted = (ramp**3 * (10 - 15 * ramp + 6 * ramp**2))[:, None, None] * 0.2 * numbers.gear_ratio
    orders = Orders(position=wanted, speed=np.gradient(wanted, 0.00025, axis=0), ahead=np.zeros_like(wanted))
    course = plant_of(numbers, servo).run(np.zeros(shape), orders, steps)
    np.testing.assert_allclose(course.angle[-1], 0.2 * numbers.gear_ratio, rtol=0.02)


def test_friction_that_depends_on_direction_does_so_by_the_same_torque_at_any_speed(rng):
    """Forwards and backwards, fast and slowly, beside a machine whose friction does not depend on direction."""
    robot = draw_robot(1, elastic=False, rng=rng)
    plain = numbers_of(robot)
    both = side_by_side([plain, with_fault(plain, 0, asymmetry=-0.1)])
    steps, dt = 3000, 0.0005
    rate = np.repeat([1.0, -1.0, 0.2, -0.2], 2 * steps // 4 + 1)[: 2 * steps + 1, None, None]
    rate = np.broadcast_to(rate, (len(rate), *both.shape)) * robot.kinematics.max_speed * both.gear_ratio
    wanted = np.cumsum(rate, axis=0) * dt / 2
    ahead = np.zeros_like(wanted)
    servo = servo_of(robot, both.shape)
    torque = (
        plant_of(both, servo, dt)
        .run(np.zeros(both.shape), Orders(position=wanted, speed=rate, ahead=ahead), 1)
        .torque[..., 0]
    )
    for part in range(4):
        settled = slice(part * steps // 4 + steps // 6, (part + 1) * steps // 4 - 5)
        more = np.mean(np.diff(torque[settled], axis=1))
        assert more == pytest.approx(-0.1 * both.coulomb[0, 0], rel=0.02), part


def test_what_is_recorded_of_a_motor_is_what_its_resolver_reads(rng):
    """Of a rigid joint, whose true angle is that of the link."""
    robot = draw_robot(1, elastic=False, rng=rng)
    numbers = with_fault(numbers_of(robot), 0, resolver=2e-3)
    shape, dt = numbers.shape, 0.0005
    rate = np.full((4001, *shape), 0.2) * robot.kinematics.max_speed * numbers.gear_ratio
    rate = rate * np.linspace(0, 1, len(rate))[:, None, None]
    orders = Orders(position=np.cumsum(rate, axis=0) * dt / 2, speed=rate, ahead=np.zeros_like(rate))
    course = plant_of(numbers, servo_of(robot, shape), dt).run(np.zeros(shape), orders, 1)
    true = course.q * numbers.gear_ratio
    assert np.ptp(true) > 2 * np.pi
    np.testing.assert_allclose(course.angle - true, 2e-3 * np.sin(true), atol=1e-9)
    np.testing.assert_allclose(np.gradient(course.angle, dt, axis=0)[5:-5], course.speed[5:-5], rtol=2e-3, atol=1e-3)


def test_an_uncertain_machine_is_off_by_the_share_that_is_told(rng):
    robot = draw_robot(6, elastic=True, rng=rng)
    nominal = numbers_of(robot)
    off = np.concatenate([unsure(robot, 0.02, rng).viscous / nominal.viscous - 1 for _ in range(200)])
    assert np.std(off) == pytest.approx(0.02, rel=0.1)
