"""Effects along recordings: the same formulas, with and without memory."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.effects import EFFECTS, TorqueEffect, torques_along
from ffgym.effects.along import iterate_samples
from ffgym.paths import joint_reference, multisine
from ffgym.simulation import Run, simulate
from tests.effects.effect_samples import as_strong_as_plausible, state_of

TORQUES = [name for name, effect in EFFECTS.items() if issubclass(effect, TorqueEffect)]


@pytest.fixture(scope="module")
def measured(irb4600, corners):
    """States along a recording of a swing."""
    swing = multisine(corners["p1"], np.full((1, 6), 0.01), [3.0], np.zeros((1, 6)), 0.3, ramp=0.1, dwell=0.05)
    recording = simulate([Run(reference=joint_reference(irb4600, swing))], n_threads=1)[0]
    motor, speed = (recording.joint_array(f"motor.{of}") for of in ("position", "velocity"))
    drive = irb4600.drive
    bent = recording.joint_array("link.position") - drive.joint_angle(motor)
    load = -drive.joint_stiffness * bent
    return recording.dt, state_of(
        irb4600,
        motor_angle=motor,
        motor_speed=speed,
        joint_angle=drive.joint_angle(motor),
        joint_speed=drive.joint_angle(speed),
        deflection=bent,
        deflection_rate=np.gradient(bent, recording.dt, axis=0),
        load=load,
        load_at_motor=drive.motor_torque(load),
        friction_sign=np.tanh(speed / 0.1),
        motor_torque=recording.joint_array("motor.effort"),
        running=3600.0,
    )


@pytest.mark.parametrize("name", TORQUES)
def test_torques_along_a_recording_have_its_shape(name, irb4600, measured):
    dt, states = measured
    found = torques_along(as_strong_as_plausible(EFFECTS[name], irb4600), states, dt)
    given = [torque for torque in (found.motor, found.spring, found.link) if torque is not None]
    assert given
    for torque in given:
        assert torque.shape == states.motor_angle.shape
        assert np.isfinite(torque).all()
    assert max(np.abs(torque).max() for torque in given) > 1e-3


@pytest.mark.parametrize("name", ["torque_delay", "flexible_load", "cable_pull", "torsional_hysteresis"])
@pytest.mark.parametrize("share", [0.3, 1.0])
def test_a_memory_over_the_whole_recording_is_that_of_sample_by_sample(name, share, irb4600, measured):
    """A lag apart: between samples, commands are held in a simulation, and straight along a recording."""
    dt, states = measured
    effect = as_strong_as_plausible(EFFECTS[name], irb4600, share=share)
    if name == "torque_delay":
        effect = replace(effect, lag=np.zeros(irb4600.n_joints))
    at_once = effect.torques_over(states, dt)
    each = list(iterate_samples(states))
    memory, found = effect.initial_memory(each[0]), []
    for state in each:
        torques, memory = effect.torques(state, memory, dt)
        found.append(torques)
    for part in ("motor", "spring", "link"):
        stepped = [getattr(torques, part) for torques in found]
        if stepped[0] is None:
            assert getattr(at_once, part) is None
        else:
            np.testing.assert_allclose(getattr(at_once, part), stepped, rtol=1e-9, atol=1e-11)


def test_a_memory_is_carried_from_sample_to_sample(irb4600, measured):
    _, states = measured
    delayed = torques_along(EFFECTS["torque_delay"].on(irb4600, delay=0.002, lag=0.0), states, 0.001)
    u = states.motor_torque
    np.testing.assert_allclose(delayed.motor[2:], u[:-2] - u[2:], atol=1e-12)


@pytest.mark.parametrize("every", [1, 4])
def test_a_lag_delays_what_changes_slowly_by_itself_however_coarse_the_samples(every, irb4600, measured):
    """A ramp of torque, sampled every millisecond or every fourth, far longer than the lag."""
    dt, states = measured
    sample_dt, lag = every * dt, 0.0005
    ramp = sample_dt * np.arange(len(states.motor_torque))[:, None] + np.zeros(irb4600.n_joints)
    effect = EFFECTS["torque_delay"].on(irb4600, delay=0.0, lag=lag)
    added = effect.torques_over(states.with_values(motor_torque=ramp), sample_dt)
    assert added.motor[100:] == pytest.approx(-lag, rel=1e-6)
