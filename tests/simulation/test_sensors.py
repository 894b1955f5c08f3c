"""Resolver and laser tracker."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.simulation import LaserTracker, Resolver, Run, Thermometer, TorqueSensor, sensors_of, simulate
from ffgym.simulation.plant import Climate, Machine
from ffgym.simulation.sensors import TRUTH
from ffgym.studies import circle_references

RESOLVER, TRACKER = Resolver(bits=16), LaserTracker(noise=20e-6, period=0.001)
KNOWN = {*TRUTH} - {"temperature"}
"""Truth that a recording of a machine without a temperature holds."""
TRACKED = ("tcp.position.x", "tcp.position.y", "tcp.position.z")


@pytest.fixture(scope="module")
def references(arm):
    fast = circle_references(arm, ["p1", "p2"], [0.1], [0.001, 0.003])
    return [fast["p1", 0.1], fast["p2", 0.1]]


def measured(arm, references, *sensors, seed=0, **options):
    return simulate([Run(reference=r) for r in references], arm=arm, sensors=sensors, seed=seed, **options)


@pytest.fixture(scope="module")
def exact(arm, references):
    return measured(arm, references)


def noise(recording, exact):
    return np.stack([recording[column] - exact[column] for column in TRACKED], axis=1)


@pytest.mark.parametrize("bits", [10, 16])
def test_resolver_rounds_motor_angles_to_steps_of_a_turn(arm, references, exact, bits):
    recording = measured(arm, references[:1], Resolver(bits=bits))[0]
    step = 2 * np.pi / 2**bits
    seen, true = recording.joint_array("motor.position"), exact[0].joint_array("motor.position")
    np.testing.assert_allclose(np.round(seen / step) * step, seen, atol=1e-12)
    assert np.abs(seen - true).max() <= 0.5 * step * (1 + 1e-9)
    assert np.abs(seen - true).max() > 0.4 * step
    assert recording.header.encoder_bits == bits


def test_resolver_speed_is_the_backward_difference_of_its_angle(arm, references):
    recording = measured(arm, references[:1], RESOLVER)[0]
    angle, speed = recording.joint_array("motor.position"), recording.joint_array("motor.velocity")
    np.testing.assert_allclose(speed[1:], np.diff(angle, axis=0) / 0.001, atol=1e-9)
    np.testing.assert_array_equal(speed[0], 0)
    assert any("backward difference" in text for text in recording.header.filters)


def test_resolver_leaves_what_the_drive_does_exact(arm, references, exact):
    recording = measured(arm, references[:1], RESOLVER)[0]
    for column in recording.columns:
        if not column.startswith(("motor.position", "motor.velocity")):
            np.testing.assert_array_equal(recording[column], exact[0][column])


@pytest.mark.parametrize(
    ("sensors", "hidden"),
    [((RESOLVER,), KNOWN), ((RESOLVER, TRACKER), KNOWN - {"tcp.position"}), ((), set())],
)
def test_a_measured_recording_holds_no_truth_that_no_sensor_sees(arm, references, exact, sensors, hidden):
    recording = measured(arm, references[:1], *sensors)[0]
    assert {*exact[0].families} - {*recording.families} == hidden


@pytest.mark.parametrize("scale", [20e-6, 1e-3])
def test_tracker_noise_is_white_with_the_given_deviation(arm, references, exact, scale):
    values = noise(measured(arm, references[:1], LaserTracker(noise=scale, period=0.001))[0], exact[0])
    n = values.size
    assert np.std(values) == pytest.approx(scale, rel=4 / np.sqrt(2 * n))
    assert np.abs(values.mean(axis=0)).max() < 4.5 * scale / np.sqrt(len(values))
    lagged = np.mean(values[1:] * values[:-1]) / scale**2
    assert abs(lagged) < 4 / np.sqrt(n)
    between_axes = np.corrcoef(values.T) - np.eye(3)
    assert np.abs(between_axes).max() < 4 / np.sqrt(len(values))


def test_tracker_sees_nothing_between_its_samples(arm, references):
    recording = measured(arm, references[:1], LaserTracker(noise=20e-6, period=0.002), record_dt=0.0005)[0]
    seen = ~np.isnan(recording["tcp.position.y"])
    np.testing.assert_array_equal(np.flatnonzero(seen), np.arange(0, len(recording), 4))
    np.testing.assert_array_equal(recording["tcp.timestamp"][seen], recording.t[seen])
    assert np.isnan(recording["tcp.timestamp"][~seen]).all()


def test_same_seed_gives_the_same_noise_and_another_seed_another(arm, references):
    first, again, other = (measured(arm, references[:1], TRACKER, seed=seed)[0] for seed in (1, 1, 2))
    assert first.equals(again)
    assert not np.array_equal(first["tcp.position.x"], other["tcp.position.x"])


def test_each_run_has_its_own_noise(arm, references, exact):
    first, second = measured(arm, [references[0], references[0]], TRACKER)
    assert not np.allclose(noise(first, exact[0]), noise(second, exact[0]))


def test_noise_of_a_run_depends_on_its_place_and_not_on_the_other_runs(arm, references, exact):
    one, two = references
    pair = measured(arm, [one, two], TRACKER, seed=3)
    twins = measured(arm, [two, two, one], TRACKER, seed=3)
    assert pair[1].equals(twins[1])
    alone = measured(arm, [one], TRACKER, seed=3)
    assert pair[0].equals(alone[0])
    n = min(len(pair[0]), len(twins[0]))
    assert n > 500
    # the stream is that of the place: another motion at place 0 gets the same draws
    np.testing.assert_allclose(noise(twins[0], exact[1])[:n, 0], noise(pair[0], exact[0])[:n, 0], atol=1e-15)


def test_noise_of_the_tracker_is_the_same_behind_a_resolver(arm, references):
    with_resolver = measured(arm, references[:1], RESOLVER, TRACKER)[0]
    without = measured(arm, references[:1], TRACKER)[0]
    np.testing.assert_array_equal(with_resolver["tcp.position.x"], without["tcp.position.x"])


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Resolver(bits=0), "resolver bits = 0"),
        (lambda: LaserTracker(noise=-1.0, period=0.001), "tracker noise = -1"),
        (lambda: LaserTracker(noise=20e-6, period=0.0), "tracker period = 0"),
        (lambda: Resolver(bits=16, noise=-1.0), "resolver noise = -1"),
        (lambda: TorqueSensor(noise=[-1.0]), "torque noise = .* must be >= 0"),
        (lambda: Thermometer(noise=np.nan, resolution=0.1), "thermometer noise must be finite"),
        (lambda: Thermometer(noise=0.1, resolution=0.0), "thermometer resolution = 0"),
    ],
)
def test_impossible_sensors_are_named(build, message):
    with pytest.raises(FFGymError, match=message):
        build()


def test_sensors_of_a_robot_are_those_of_its_description(irb4600, one_axis):
    assert sensors_of(irb4600) == (RESOLVER, TRACKER)
    assert sensors_of(one_axis) == (RESOLVER,)


def test_resolver_noise_comes_before_its_rounding_and_draws_nothing_if_it_is_zero(arm, references, exact):
    step, scale = 2 * np.pi / 2**16, 1e-3
    noisy = measured(arm, references[:1], Resolver(bits=16, noise=scale), TRACKER)[0]
    seen, true = noisy.joint_array("motor.position"), exact[0].joint_array("motor.position")
    np.testing.assert_allclose(np.round(seen / step) * step, seen, atol=1e-12)
    assert np.std(seen - true) == pytest.approx(scale, rel=0.02)
    quiet = measured(arm, references[:1], Resolver(bits=16, noise=0.0), TRACKER)[0]
    assert quiet.equals(measured(arm, references[:1], RESOLVER, TRACKER)[0])


def test_torque_noise_is_on_the_measured_torque_of_its_joint_only(arm, references, exact):
    scale = np.array([0.1, 0.0, 0.3, 0.0, 0.0, 0.02])
    recording = measured(arm, references[:1], TorqueSensor(noise=scale))[0]
    off = recording.joint_array("motor.effort") - exact[0].joint_array("motor.effort")
    np.testing.assert_allclose(off.std(axis=0), scale, rtol=0.05)
    np.testing.assert_array_equal(recording.joint_array("command.effort"), exact[0].joint_array("command.effort"))
    with pytest.raises(FFGymError, match=r"torque noise has shape \(2,\), must be \(6\)"):
        measured(arm, references[:1], TorqueSensor(noise=[0.1, 0.1]))


def test_only_a_thermometer_sees_the_temperature_of_a_machine(arm, irb4600, references):
    machine = Machine(robot=irb4600, climate=Climate(rise=np.full(6, 20.0), running_since=600.0))
    runs = [Run(reference=references[0])]
    exact, blind, seeing = (
        simulate(runs, arm=arm, machine=machine, sensors=sensors)[0]
        for sensors in ((), (RESOLVER,), (RESOLVER, Thermometer(noise=0.2, resolution=0.1)))
    )
    assert not blind.has("temperature")
    values = seeing.joint_array("temperature")
    off = values - exact.joint_array("temperature")
    assert np.std(off) == pytest.approx(np.hypot(0.2, 0.1 / np.sqrt(12)), rel=0.03)
    np.testing.assert_allclose(np.round(values / 0.1) * 0.1, values, atol=1e-12)


def test_a_thermometer_finds_nothing_on_a_machine_without_temperature(arm, references):
    thermometer = Thermometer(noise=0.2, resolution=0.1)
    assert measured(arm, references[:1], RESOLVER, thermometer)[0].equals(measured(arm, references[:1], RESOLVER)[0])
