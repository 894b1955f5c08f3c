"""Equations of the workcell: what each of them must do, whatever its numbers."""

import numpy as np
import pytest

from ffgym.effects import EFFECTS, State
from ffgym.paths import joint_reference, multisine
from ffgym.robot import ModelOptions
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Climate, Machine
from ffgym.workcell.equations import (
    EQUATIONS,
    ColdOil,
    GearError,
    GearLosses,
    OneWayFriction,
    ResolverEccentricity,
    SlipElements,
    SlowStribeck,
    SmoothHysteresis,
)

WARM = Climate(ambient=20.0, rise=np.array([18.0]), time_constant=1200.0, running_since=7200.0)
COARSE = ModelOptions(looks=False, physics_dt=0.001)
DT = 1e-3

by_name = pytest.mark.parametrize("kind", EQUATIONS.values(), ids=EQUATIONS.keys())


def state_of(**given):
    """A state of one motor in which all that is not `given` is zero; arrays have shape (T, 1)."""
    rows = max((np.size(value) for value in given.values()), default=1)
    values = {name: 0.0 for name in State.names() if name not in ("link_angle", "link_speed")} | given
    return State(**{name: np.broadcast_to(np.reshape(value, (-1, 1)), (rows, 1)) for name, value in values.items()})


def along(effect, states):
    """Torques of an effect along a list of states, and what it remembers in the end."""
    memory, torques = effect.initial_memory(states[0]), []
    for state in states:
        torque, memory = effect.torques(state, memory, DT)
        torques.append(torque)
    return torques, memory


def swing(amplitude, turns, frequency=1.0, samples=2000):
    """Positions and speeds of a sine, (T,) each, so slow or fast as `samples` of DT say."""
    phase = 2 * np.pi * turns * frequency * np.arange(samples) / samples
    rate = 2 * np.pi * turns * frequency / (samples * DT)
    return amplitude * np.sin(phase), amplitude * rate * np.cos(phase)


@pytest.fixture(scope="module")
def motion(irb4600, corners):
    amplitude = np.full((1, irb4600.n_joints), 0.004)
    return joint_reference(
        irb4600, multisine(corners["p1"], amplitude, [2.0], np.zeros((1, 6)), 0.5, ramp=0.2, dwell=0.1)
    )


def recorded(motion, machine):
    return simulate([Run(reference=motion)], machine=machine, options=COARSE, n_threads=1)[0]


@by_name
def test_it_vanishes_at_its_null_value(kind, motion, irb4600):
    nominal = recorded(motion, Machine(robot=irb4600, climate=WARM))
    null = kind.on(irb4600, **{name: known.neutral for name, known in kind.parameters().items()})
    assert null.is_null
    same = recorded(motion, Machine(robot=irb4600, effects=(null,), climate=WARM))
    for column in same.columns:
        np.testing.assert_allclose(same[column], nominal[column], rtol=0, atol=1e-12, err_msg=column)


@by_name
def test_it_changes_what_the_robot_does(kind, motion, irb4600):
    strong = {name: known.high if known.null is not None else known.low for name, known in kind.parameters().items()}
    nominal = recorded(motion, Machine(robot=irb4600, climate=WARM))
    other = recorded(motion, Machine(robot=irb4600, effects=(kind.on(irb4600, **strong),), climate=WARM))
    moved = other.joint_array("motor.position") - nominal.joint_array("motor.position")
    assert np.abs(moved).max() > 1e-6


def test_no_equation_is_one_of_the_library():
    assert not set(EQUATIONS) & set(EFFECTS)
    assert not {kind.equation for kind in EQUATIONS.values()} & {kind.equation for kind in EFFECTS.values()}


@pytest.mark.parametrize(
    "effect",
    [
        SlipElements(level=[0.1], travel=[0.03]),
        GearLosses(driving=[0.05], driven=[0.08]),
        SlowStribeck(level=[0.1], speed=[1.0]),
    ],
    ids=lambda effect: effect.name,
)
def test_friction_takes_energy_from_a_motor_that_swings(effect):
    angle, speed = swing(0.5, turns=2)
    load = 300 * np.sin(3 * angle)
    states = [
        state_of(motor_speed=v, friction_sign=np.tanh(20 * v), load_at_motor=x)
        for v, x in zip(speed, load, strict=True)
    ]
    torques, _ = along(effect, states)
    assert sum(float(torque.motor[0, 0]) * v for torque, v in zip(torques, speed, strict=True)) < 0


def test_slip_elements_give_the_same_loop_at_any_speed():
    effect = SlipElements(level=[0.1], travel=[0.03])
    loops = []
    for samples in (1000, 4000):
        _, speed = swing(0.05, turns=2, samples=samples)
        torques, _ = along(effect, [state_of(motor_speed=v) for v in speed])
        torque = np.array([t.motor[0, 0] for t in torques])
        half = slice(samples // 2, None)  # the second turn
        loops.append(np.interp(np.linspace(0, 1, 50), np.linspace(0, 1, samples // 2), torque[half]))
        assert np.abs(torque).max() == pytest.approx(0.1, rel=1e-6)
    np.testing.assert_allclose(loops[0], loops[1], atol=4e-3)


def test_a_gear_loses_more_where_the_side_with_the_larger_share_drives():
    effect = GearLosses(driving=[0.02], driven=[0.06])
    lost = {
        load: -float(
            effect.torques(state_of(load_at_motor=load, friction_sign=1.0), np.zeros((1, 1, 0)), DT)[0].motor[0, 0]
        )
        for load in (5.0, -5.0)
    }
    assert lost == pytest.approx({5.0: 0.02 * 5.0, -5.0: 0.06 * 5.0})


def test_friction_by_direction_is_even_and_gone_at_rest():
    effect = OneWayFriction(level=[0.05], speed=[8.0])
    speed = np.array([-3.0, 0.0, 3.0])
    torque = effect.torques(state_of(motor_speed=speed, friction_sign=np.sign(speed)), np.zeros((3, 1, 0)), DT)[0].motor
    assert torque[0, 0] == torque[2, 0] < 0
    assert torque[1, 0] == 0


def test_warm_oil_is_thinner_and_the_description_holds_at_its_temperature():
    effect = ColdOil(viscous=[0.04], vogel=[900.0], reference=[38.0])
    state = state_of(temperature=np.array([10.0, 22.0, 38.0, 45.0]), motor_speed=5.0)
    braking = -effect.torques(state, np.zeros((4, 1, 0)), DT)[0].motor[:, 0]
    assert np.all(np.diff(braking) < 0)
    assert braking[2] == 0
    assert braking[1] > 0.04 * 5.0  # more than twice as thick 16 K below


def test_hysteresis_is_bounded_and_loses_energy_in_every_loop():
    effect = SmoothHysteresis(level=[20.0], yielding=[1e-4], exponent=[1.5])
    _, rate = swing(4e-4, turns=3)
    torques, memory = along(effect, [state_of(deflection_rate=v) for v in rate])
    spring = np.array([torque.spring[0, 0] for torque in torques])
    assert np.abs(spring).max() == pytest.approx(20.0, rel=0.02)
    assert np.abs(memory).max() <= 1
    assert spring[-len(rate) // 3 :] @ rate[-len(rate) // 3 :] < 0


def test_a_transmission_error_is_the_output_ahead_of_the_motor():
    effect = GearError(amplitude=[2e-5], cycles=[1.0], phase=[0.4])
    angle = np.linspace(0, 2 * np.pi, 50)
    resting = state_of(motor_angle=angle, joint_stiffness=5e5)
    spring = effect.torques(resting, np.zeros((50, 1, 0)), DT)[0].spring[:, 0]
    ahead = 2e-5 * (np.sin(angle + 0.4) + np.sin(3 * angle + 0.4) / 3)
    np.testing.assert_allclose(spring, 5e5 * ahead)


def test_a_transmission_error_makes_no_energy():
    effect = GearError(amplitude=[2e-5], cycles=[1.0], phase=[0.4])
    phase = np.linspace(0, 2 * np.pi, 20001)
    deflection, angle, stiffness = 1e-3 * np.sin(phase), 0.7 * np.sin(phase + 1.0), 5e5
    state = state_of(motor_angle=angle, deflection=deflection, load=-stiffness * deflection, joint_stiffness=stiffness)
    torques = effect.torques(state, np.zeros((len(phase), 1, 0)), DT)[0]
    on_spring = np.trapezoid(torques.spring[:, 0], deflection)
    on_motor = np.trapezoid(torques.motor[:, 0], angle)
    assert abs(on_spring) > 1e-4
    assert on_motor == pytest.approx(-on_spring, rel=1e-5)


def test_a_transmission_error_is_damped_as_fast_as_it_changes():
    effect = GearError(amplitude=[2e-5], cycles=[2.0], phase=[0.4])
    step, speed, damping = 1e-6, 30.0, 500.0
    before, after = (
        effect.torques(state_of(motor_angle=angle, joint_stiffness=1.0), np.zeros((1, 1, 0)), DT)[0].spring[0, 0]
        for angle in (0.7 - step, 0.7 + step)
    )
    moving = state_of(motor_angle=0.7, motor_speed=speed, joint_damping=damping)
    damped = effect.torques(moving, np.zeros((1, 1, 0)), DT)[0].spring[0, 0]
    assert damped == pytest.approx(damping * speed * (after - before) / (2 * step), rel=1e-6)


def test_a_resolver_reads_the_speed_of_the_angle_that_it_reads():
    effect = ResolverEccentricity(amplitude=[5e-4], phase=[0.3])
    t = np.linspace(0.0, 1.0, 10001)[:, None]
    angle, speed = 5.0 * np.sin(3.0 * t), 15.0 * np.cos(3.0 * t)
    error = effect.error(angle, speed)
    rate = np.gradient(error.angle[:, 0], t[:, 0])
    np.testing.assert_allclose(error.speed[1:-1, 0], rate[1:-1], atol=1e-5)


def test_the_second_stribeck_term_falls_by_its_share_of_the_speed():
    effect = SlowStribeck(level=[0.1], speed=[2.0])
    state = state_of(motor_speed=np.array([-4.0, 1.0, 2.0]), friction_sign=np.array([-1.0, 1.0, 1.0]))
    torque = effect.torques(state, np.zeros((3, 1, 0)), DT)[0].motor[:, 0]
    np.testing.assert_allclose(torque, [0.1 * np.exp(-2), -0.1 * np.exp(-0.5), -0.1 * np.exp(-1)])


def test_friction_by_direction_grows_with_the_speed():
    effect = OneWayFriction(level=[0.05], speed=[8.0])
    state = state_of(motor_speed=np.array([0.0, 8.0, 24.0]), friction_sign=1.0)
    torque = effect.torques(state, np.zeros((3, 1, 0)), DT)[0].motor[:, 0]
    np.testing.assert_allclose(torque, [-0.05, -0.05 * np.sqrt(2), -0.1])
