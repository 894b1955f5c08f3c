"""Effects of motor and current loop."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS
from ffgym.paths import joint_reference, multisine
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine, Plant
from tests.effects.effect_samples import state_of, torques_at

DT = 0.00025


def given_by(effect, robot, commands):
    """Torque that the drive gives for commands (T,) of all motors, (T, N)."""
    memory = effect.initial_memory(state_of(robot, motor_torque=commands[0]))
    given = []
    for command in commands:
        added, memory = effect.torques(state_of(robot, motor_torque=command), memory, DT)
        given.append(command + added.motor)
    return np.array(given)


def test_a_whole_delay_is_an_exact_shift(irb4600):
    commands = np.random.default_rng(0).normal(size=60)
    given = given_by(EFFECTS["torque_delay"].on(irb4600, delay=3 * DT, lag=0.0), irb4600, commands)
    np.testing.assert_allclose(given[3:], np.tile(commands[:-3, None], 6), rtol=0, atol=1e-12)
    np.testing.assert_allclose(given[:3], commands[0])


def test_a_delay_between_steps_shifts_a_ramp_exactly(irb4600):
    ramp = np.arange(60.0)
    given = given_by(EFFECTS["torque_delay"].on(irb4600, delay=2.4 * DT, lag=0.0), irb4600, ramp)
    np.testing.assert_allclose(given[3:, 0], ramp[3:] - 2.4, atol=1e-10)


def test_a_lag_answers_a_step_with_its_exponential(irb4600):
    step = np.append(0.0, np.ones(40))
    given = given_by(EFFECTS["torque_delay"].on(irb4600, delay=0.0, lag=1e-3), irb4600, step)
    np.testing.assert_allclose(given[:, 2], 1 - np.exp(-np.arange(41) * DT / 1e-3), atol=1e-12)


def test_each_motor_has_its_own_delay(irb4600):
    commands = np.random.default_rng(1).normal(size=30)
    given = given_by(EFFECTS["torque_delay"].on(irb4600, "j3", delay=2 * DT, lag=0.0), irb4600, commands)
    np.testing.assert_allclose(given[2:, 2], commands[:-2], atol=1e-12)
    np.testing.assert_array_equal(given[:, 0], commands)


def test_a_delay_that_cannot_be_remembered_is_refused(irb4600, corners):
    machine = Machine(robot=irb4600, effects=(EFFECTS["torque_delay"].on(irb4600, delay=0.02, lag=0.0),))
    with pytest.raises(FFGymError, match=r"too long for effect torque_delay.*physics_dt"):
        Plant(machine, 1, n_threads=1).rest(corners["p1"][None])


def test_cogging_is_the_same_at_any_torque_and_ripple_is_a_share_of_it(irb4600):
    angles = np.linspace(0, 2 * np.pi, 7)[:, None]
    cogging = EFFECTS["cogging"].on(irb4600, amplitude=0.1, cycles=6.0)
    ripple = EFFECTS["torque_ripple"].on(irb4600, share=0.05, cycles=6.0, phase=0.5)
    idle, busy = (state_of(irb4600, motor_angle=angles, motor_torque=u) for u in (0.0, 4.0))
    np.testing.assert_array_equal(torques_at(cogging, idle).motor, torques_at(cogging, busy).motor)
    assert not torques_at(ripple, idle).motor.any()
    np.testing.assert_allclose(torques_at(ripple, busy).motor, 0.2 * np.sin(6 * angles + 0.5) + np.zeros(6))


def test_a_motor_gives_less_when_warm_and_near_its_peak(irb4600):
    effect = EFFECTS["torque_constant"].on(irb4600, error=0.05, saturation=0.2, magnets=-0.001, reference=20.0)
    peak = irb4600.drive.peak_torque
    warm = torques_at(effect, state_of(irb4600, motor_torque=0.5 * peak, temperature=60.0)).motor
    np.testing.assert_allclose(warm, 0.5 * peak * (0.05 - 0.04 - 0.2 / 4))


def test_at_rest_the_servo_makes_up_for_what_the_motor_does_not_give(irb4600, corners):
    swing = multisine(corners["p1"], np.full((1, 6), 1e-5), [2.0], np.zeros((1, 6)), 0.1, ramp=0.05, dwell=0.05)
    run = Run(reference=joint_reference(irb4600, swing))
    effects = {"torque_offset": {"offset": 0.1}, "torque_constant": {"error": 0.1, "saturation": 0.0, "magnets": 0.0}}
    held = {
        name: simulate(
            [run], machine=Machine(robot=irb4600, effects=(EFFECTS[name].on(irb4600, **values),)), n_threads=1
        )[0].joint_array("command.effort")[0]
        for name, values in effects.items()
    }
    nominal = simulate([run], n_threads=1)[0].joint_array("command.effort")[0]
    np.testing.assert_allclose(held["torque_offset"], nominal - 0.1, atol=1e-9)
    np.testing.assert_allclose(held["torque_constant"], nominal / 1.1, atol=1e-9)


def test_a_retuned_servo_answers_with_its_own_gains(irb4600, corners):
    swing = multisine(corners["p1"], np.full((1, 6), 2e-3), [2.0], np.zeros((1, 6)), 0.3, ramp=0.1, dwell=0.05)
    effect = EFFECTS["servo_gains"].on(irb4600, position=0.3, velocity=-0.2, integral=0.5)
    machine = Machine(robot=irb4600, effects=(effect,))
    recording = simulate([Run(reference=joint_reference(irb4600, swing))], machine=machine, n_threads=1)[0]
    error, rate = (
        recording.joint_array(f"reference.{of}") - recording.joint_array(f"motor.{of}")
        for of in ("position", "velocity")
    )
    servo = irb4600.servo
    expected = 1.3 * servo.position_gain * error + 0.8 * servo.velocity_gain * rate
    proportional = recording.joint_array("feedback.effort") - recording.joint_array("feedback.integral")
    np.testing.assert_allclose(proportional, expected, atol=1e-10)
    nominal = simulate([Run(reference=joint_reference(irb4600, swing))], n_threads=1)[0]
    assert np.abs(nominal["motor.position.j1"] - recording["motor.position.j1"]).max() > 1e-5
