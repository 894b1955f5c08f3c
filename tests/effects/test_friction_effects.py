"""Friction effects: signs, limits, and that friction as a whole only takes energy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from ffgym.effects import EFFECTS, TorqueEffect
from tests.effects.effect_samples import as_strong_as_plausible, state_of, torques_at

LAWS = [n for n, e in EFFECTS.items() if e.code.startswith("F") and issubclass(e, TorqueEffect)]


def sliding(robot, speed, **more):
    """All motors turn at `speed` [rad/s], bristles fully bent."""
    return state_of(robot, motor_speed=speed, friction_sign=np.sign(speed), **more)


@pytest.mark.parametrize("name", LAWS)
@given(speed=st.floats(-300, 300), load=st.floats(-20, 20), angle=st.floats(-3, 3), warm=st.floats(0, 40))
def test_friction_as_a_whole_takes_energy(name, irb4600, speed, load, angle, warm):
    effect = as_strong_as_plausible(EFFECTS[name], irb4600, share=0.5)
    state = sliding(irb4600, speed, load_at_motor=load, joint_angle=angle, temperature=20.0 + warm)
    total = irb4600.friction.steady_torque(state.motor_speed) - torques_at(effect, state).motor
    assert np.all(total * state.motor_speed >= 0)


@pytest.mark.parametrize("name", LAWS)
def test_there_is_none_where_bristles_are_relaxed(name, irb4600):
    effect = as_strong_as_plausible(EFFECTS[name], irb4600)
    assert not np.any(torques_at(effect, state_of(irb4600, load_at_motor=5.0, temperature=50.0)).motor)


@pytest.mark.parametrize(("name", "sign"), [("viscous_drift", -1.0), ("coulomb_drift", 1.0)])
def test_a_drift_is_nothing_when_switched_on_and_63_percent_of_it_after_its_time(name, sign, irb4600):
    effect, friction = EFFECTS[name].on(irb4600, share=0.2, duration=1800.0), irb4600.friction
    whole = 0.2 * (friction.coulomb if name == "coulomb_drift" else 7.0 * friction.viscous)
    for running, share in ((0.0, 0.0), (1800.0, 1 - np.exp(-1.0)), (1e6, 1.0)):
        torque = torques_at(effect, sliding(irb4600, 7.0, running=running)).motor
        np.testing.assert_allclose(-torque, sign * share * whole, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("exponent", [0.3, 0.6, 1.0])
def test_what_a_warm_grease_loses_grows_with_a_power_of_the_speed(exponent, irb4600):
    effect = EFFECTS["viscous_drift"].on(irb4600, share=0.2, duration=1800.0, exponent=exponent)
    lost = [torques_at(effect, sliding(irb4600, speed, running=1e6)).motor for speed in (100.0, 10.0)]
    np.testing.assert_allclose(lost[0], 0.2 * irb4600.friction.viscous * 100.0, rtol=1e-4)
    np.testing.assert_allclose(lost[0] / lost[1], 10.0**exponent, rtol=1e-4)


@pytest.mark.parametrize("name", sorted(set(LAWS) - {"asymmetry"}))
def test_it_is_as_strong_backwards(name, irb4600):
    effect = as_strong_as_plausible(EFFECTS[name], irb4600)
    forwards, backwards = (
        torques_at(effect, sliding(irb4600, speed, load_at_motor=3.0, joint_angle=0.4, temperature=45.0)).motor
        for speed in (0.1, -0.1)
    )
    np.testing.assert_allclose(forwards, -backwards, rtol=1e-12)


def test_asymmetric_friction_pushes_the_same_way_in_both_directions(irb4600):
    effect = EFFECTS["asymmetry"].on(irb4600, coulomb=0.1, viscous=0.2)
    forwards, backwards = (torques_at(effect, sliding(irb4600, speed)).motor for speed in (10.0, -10.0))
    np.testing.assert_array_equal(forwards, backwards)
    np.testing.assert_allclose(-forwards, 0.1 * irb4600.friction.coulomb + 0.2 * irb4600.friction.viscous * 10.0)


def test_load_friction_is_a_share_of_the_load_whatever_its_sign(irb4600):
    effect = EFFECTS["load_friction"].on(irb4600, share=0.06)
    for load in (4.0, -4.0, 8.0):
        lost = -torques_at(effect, sliding(irb4600, 1.0, load_at_motor=load)).motor
        np.testing.assert_allclose(lost, 0.06 * abs(load))


def test_warm_oil_is_thinner_by_the_exponential_and_nothing_changes_at_the_reference(irb4600):
    effect = EFFECTS["temperature_friction"].on(
        irb4600, viscous=0.8, scale=25.0, coulomb=0.0, breakaway=0.0, reference=30.0
    )
    for temperature, left in ((30.0, 1.0), (55.0, np.exp(-1)), (5.0, np.exp(1))):
        lost = -torques_at(effect, sliding(irb4600, 50.0, temperature=temperature)).motor
        np.testing.assert_allclose(lost, 0.8 * irb4600.friction.viscous * 50.0 * (left - 1), atol=1e-15)


def test_coulomb_and_breakaway_change_linearly_with_temperature(irb4600):
    effect = EFFECTS["temperature_friction"].on(irb4600, viscous=0.0, coulomb=-0.002, breakaway=0.001, reference=20.0)
    fast, crawling = (-torques_at(effect, sliding(irb4600, v, temperature=40.0)).motor for v in (100.0, 1e-9))
    np.testing.assert_allclose(fast, -0.04 * irb4600.friction.coulomb)
    np.testing.assert_allclose(crawling, -0.04 * irb4600.friction.coulomb + 0.02 * irb4600.friction.static)


def test_the_square_term_has_its_share_at_its_speed_and_a_quarter_of_the_torque_at_half_of_it(irb4600):
    effect = EFFECTS["nonlinear_viscous"].on(irb4600, share=-0.3, speed=200.0)
    full, half = (-torques_at(effect, sliding(irb4600, v)).motor for v in (200.0, 100.0))
    np.testing.assert_allclose(full, -0.3 * irb4600.friction.viscous * 200.0)
    np.testing.assert_allclose(half, full / 4)


def test_position_friction_has_its_period(irb4600):
    effect = EFFECTS["position_friction"].on(irb4600, share=0.2, cycles=8.0, phase=0.3)
    here, next_one, between = (
        torques_at(effect, sliding(irb4600, 1.0, joint_angle=0.1 + shift)).motor
        for shift in (0.0, np.pi / 4, np.pi / 8)
    )
    np.testing.assert_allclose(here, next_one, atol=1e-14)
    np.testing.assert_allclose(here, -between, atol=1e-14)


def test_another_exponent_leaves_height_and_width_of_the_stribeck_curve(irb4600):
    effect = EFFECTS["stribeck_exponent"].on(irb4600, exponent=0.7)
    for speed in (1e-15, irb4600.friction.stribeck_velocity, 1e3):
        np.testing.assert_allclose(torques_at(effect, sliding(irb4600, speed)).motor, 0.0, atol=1e-10)


def test_native_effects_are_shares_of_the_description(irb4600):
    friction = irb4600.friction
    higher = EFFECTS["coulomb_level"].on(irb4600, "j2", change=0.2).in_description(irb4600).friction
    np.testing.assert_allclose(higher.coulomb - friction.coulomb, [0, 0.2 * friction.coulomb[1], 0, 0, 0, 0])
    np.testing.assert_allclose(higher.static - friction.static, higher.coulomb - friction.coulomb)
    thicker = EFFECTS["viscous_level"].on(irb4600, change=0.5).in_description(irb4600).friction
    np.testing.assert_allclose(thicker.viscous, 1.5 * friction.viscous)
    peak = EFFECTS["stribeck_peak"].on(irb4600, level=0.5, velocity=1.0).in_description(irb4600).friction
    np.testing.assert_allclose(peak.static, friction.static + 0.5 * friction.coulomb)
    np.testing.assert_allclose(peak.stribeck_velocity, 2 * friction.stribeck_velocity)
    brush = EFFECTS["presliding"].on(irb4600, stiffness=0.5, damping=-0.5).in_description(irb4600).friction
    np.testing.assert_allclose(brush.bristle_stiffness, 1.5 * friction.bristle_stiffness)
    np.testing.assert_allclose(brush.bristle_damping, 0.5 * friction.bristle_damping)


def aged(effect, robot, memory, duration, dt=0.001, speed=0.0):
    state = state_of(robot, motor_speed=speed, friction_sign=np.sign(speed))
    for _ in range(round(duration / dt)):
        _, memory = effect.torques(state, memory, dt)
    return memory


def test_stiction_grows_with_the_time_of_rest_and_slip_uses_it_up(irb4600):
    effect = EFFECTS["dwell_stiction"].on(irb4600, share=0.3, time=0.5, slip=0.02)
    fresh = np.zeros((6, 1))
    for rest in (0.1, 0.5, 2.0):
        np.testing.assert_allclose(aged(effect, irb4600, fresh, rest), 1 - np.exp(-rest / 0.5), rtol=1e-9)
    restarted = sliding(irb4600, 1e-9)
    peaks = [
        -effect.torques(restarted, aged(effect, irb4600, fresh, rest), 1e-3)[0].motor[0] for rest in (0.1, 0.5, 2.0)
    ]
    assert np.all(np.diff(peaks) > 0)
    assert peaks[-1] < 0.3 * irb4600.friction.static[0]
    after = aged(effect, irb4600, np.ones((6, 1)), 0.1, speed=2.0)
    assert np.all(after < 0.03)


def test_ageing_solves_its_equation(irb4600):
    effect = EFFECTS["dwell_stiction"].on(irb4600, share=0.3, time=0.5, slip=0.02)
    mine = aged(effect, irb4600, np.full((6, 1), 0.8), 0.05, dt=0.05, speed=0.3)
    exact = solve_ivp(lambda _, c: (1 - c) / 0.5 - c * 0.3 / 0.02, (0, 0.05), [0.8], rtol=1e-10, atol=1e-12).y[0, -1]
    np.testing.assert_allclose(mine, exact, rtol=1e-8)
