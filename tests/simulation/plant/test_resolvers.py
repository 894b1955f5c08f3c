"""Servos that differentiate the speed from resolvers (thesis 2.2.1): resolution, ripple, and what is recorded."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

from ffgym.control import NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS
from ffgym.envs import EpisodeRecorder
from ffgym.robot import ModelOptions, RigidArm, load_robot
from ffgym.robot.model.names import servo_actuator
from ffgym.simulation import Run, simulate
from ffgym.simulation.export import export_run
from ffgym.simulation.export.play import main as play
from ffgym.simulation.plant import Machine, Plant, load_machine, save_machine
from ffgym.studies import circle_references
from tests.simulation.plant.driving import controls

DT = 0.00025
STEP = 2 * np.pi / 2**16


def reading(robot, period, bits=16):
    """The robot with servos that read resolvers of so many bits."""
    sensors = replace(robot.sensors, encoder_bits=bits)
    return replace(robot, drive=replace(robot.drive, resolver_period=period), sensors=sensors)


@pytest.fixture(scope="module")
def circle(arm):
    return Run(reference=circle_references(arm, ["p1"], [0.1], [0.001])["p1", 0.1], law=NoCompensation())


def coast(period, bits, speed, steps):
    """True and read states of a motor that turns at `speed` [rad/s] without torque: (steps, 2) each."""
    none = np.zeros(1)
    joint = load_robot("one_axis")
    joint = replace(joint, servo=replace(joint.servo, position_gain=none, velocity_gain=none, integral_gain=none))
    plant = Plant(reading(joint, period, bits), 1, options=ModelOptions(friction=False))
    plant.rest(np.zeros((1, 1)), np.full((1, 1), speed))
    qpos, qvel, _, read = plant.advance_with_readings(controls(plant, position=np.zeros((1, steps, 1))))
    return np.concatenate([qpos[0], qvel[0]], axis=1), read[0]


@pytest.mark.parametrize(("period", "bits"), [(DT, 16), (2 * DT, 16), (2 * DT, 14), (8 * DT, 12)])
def test_the_speed_has_the_resolution_of_a_step_in_a_period_and_the_ripple_of_rounding(period, bits):
    step, speed = 2 * np.pi / 2**bits, 1.234
    _, read = coast(period, bits, speed, 8000)
    counts = read[:, 1] * period / step
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    whole, part = divmod(speed * period / step, 1)
    assert set(np.round(counts)) == {whole, whole + 1}
    assert np.mean(read[:, 1]) == pytest.approx(speed, abs=2 * step / (8000 * DT))
    assert np.std(read[:, 1]) == pytest.approx(step / period * np.sqrt(part * (1 - part)), rel=0.03)


def test_readings_hold_for_a_period_and_are_rounded_angles_at_its_start():
    true, read = coast(4 * DT, 16, 2.0, 41)
    for k in range(3, 40):
        taken = 4 * ((k + 1) // 4) - 1
        assert read[k, 0] == np.round(true[taken, 0] / STEP) * STEP


def test_a_fine_resolver_at_every_step_knows_the_speed():
    true, read = coast(DT, 30, 1.7, 100)
    np.testing.assert_allclose(read, true, atol=1e-4)


def test_the_servo_acts_on_what_it_reads(irb4600):
    robot = reading(irb4600, 2 * DT)
    plant = Plant(robot, 1)
    home = irb4600.work_area.home
    plant.rest(home[None])
    moving = controls(plant, irb4600.drive.motor_angle(home) + 0.01)
    force = plant.batch.bind("actuator_force")
    servos = [plant.model.actuator(servo_actuator(joint)).id for joint in robot.joints]
    for _ in range(7):
        before = plant.reading()[0]
        integral = plant.state().integral[0]
        plant.drive(moving[None, None])
        servo = robot.servo
        u = (
            servo.position_gain * (moving[0::3] - before[:6])
            + servo.velocity_gain * (moving[1::3] - before[6:])
            + servo.integral_gain * integral
        )
        np.testing.assert_allclose(force[0, servos], np.clip(u, -robot.drive.peak_torque, robot.drive.peak_torque))


def test_recorded_signals_are_those_of_the_servo(irb4600, circle):
    recording = simulate([circle], machine=reading(irb4600, 2 * DT), record_dt=2 * DT)[0]
    position, velocity = (recording.joint_array(f"motor.{name}") for name in ("position", "velocity"))
    np.testing.assert_allclose(position / STEP, np.round(position / STEP), atol=1e-6)
    np.testing.assert_allclose(velocity[1:], np.diff(position, axis=0) / (2 * DT), atol=1e-6)
    servo = irb4600.servo
    error = recording.joint_array("reference.position") - position
    rate = recording.joint_array("reference.velocity") - velocity
    integral = recording.joint_array("feedback.integral")
    feedback = servo.position_gain * error + servo.velocity_gain * rate + integral
    np.testing.assert_allclose(recording.joint_array("feedback.effort"), feedback, atol=1e-12)
    sparse = simulate([circle], machine=reading(irb4600, 2 * DT))[0]
    np.testing.assert_array_equal(sparse.joint_array("motor.velocity"), velocity[::2])


def test_without_a_period_everything_is_as_before(irb4600, circle):
    assert Machine.of(reading(irb4600, 0.0)).physics(ModelOptions()) == Machine.of(irb4600).physics(ModelOptions())
    prints = {
        Machine.of(robot).physics(ModelOptions())
        for robot in (irb4600, reading(irb4600, DT), reading(irb4600, 2 * DT), reading(irb4600, DT, 14))
    }
    assert len(prints) == 4
    together = simulate([circle, circle], machine=[irb4600, reading(irb4600, 2 * DT)])
    alone = simulate([circle], machine=irb4600)[0]
    for name in alone.columns:
        np.testing.assert_array_equal(together[0][name], alone[name])
    assert np.abs(together[1].joint_array("motor.position") - alone.joint_array("motor.position")).max() > 1e-6


def test_a_resolver_reads_angles_with_their_errors(irb4600):
    wave = EFFECTS["resolver_ripple"].on(irb4600, amplitude=1e-3, cycles=2.0, phase=0.3)
    plant = Plant(Machine(robot=reading(irb4600, DT), effects=(wave,)), 1)
    plant.rest(irb4600.work_area.home[None])
    moving = controls(plant, irb4600.drive.motor_angle(irb4600.work_area.home) + 0.02)
    for _ in range(2):
        true = plant.state().motor_position
        seen = true + wave.error(true, np.zeros_like(true)).angle
        np.testing.assert_allclose(plant.reading()[:, :6], np.round(seen / STEP) * STEP)
        plant.drive(np.tile(moving, (1, 80, 1)))
    assert np.abs(plant.state().motor_position - true).max() > 10 * STEP


def test_going_back_restores_readings(irb4600):
    plant = Plant(reading(irb4600, 4 * DT), 1)
    home = irb4600.work_area.home
    plant.rest(home[None])
    rows = np.tile(controls(plant, irb4600.drive.motor_angle(home) + 0.01), (1, 6, 1))
    plant.drive(rows)
    saved = plant.save()
    plant.drive(rows)
    first = plant.batch.state.copy()
    plant.restore(saved)
    plant.drive(rows)
    np.testing.assert_array_equal(plant.batch.state, first)


def test_episodes_record_what_the_servo_reads(irb4600):
    recorder = EpisodeRecorder(record_dt=DT)
    circles = {"positions": ["p1"], "speeds": [0.1], "radii": [0.001]}
    env = gym.make("ffgym/CirclePath-v0", plant=reading(irb4600, 2 * DT), recorder=recorder, **circles)
    env.reset(seed=1)
    while not recorder.recordings:
        env.step(np.zeros(env.action_space.shape))
    position = recorder.recordings[0].joint_array("motor.position")
    np.testing.assert_allclose(position / STEP, np.round(position / STEP), atol=1e-6)
    assert np.ptp(position, axis=0).max() > 100 * STEP


def test_an_export_names_the_period_that_it_lacks(irb4600, tmp_path):
    robot = reading(irb4600, 2 * DT)
    reference = circle_references(RigidArm(robot), ["p1"], [0.1], [0.001])["p1", 0.1]
    export_run(tmp_path / "out", Run(reference=reference, law=NoCompensation()))
    assert "drive.resolver_period = 0.0005 s" in (tmp_path / "out" / "README.txt").read_text(encoding="utf-8")
    assert play(tmp_path / "out") == 0


def test_a_period_that_is_no_multiple_of_the_physics_step_is_one_error(irb4600):
    with pytest.raises(FFGymError, match=r"drive\.resolver_period = 0\.0003 s must be a whole multiple"):
        reading(irb4600, 0.0003)
    with pytest.raises(FFGymError, match=r"drive\.resolver_period = 0\.00025 s.*physics_dt = 0\.0005"):
        Plant(reading(irb4600, DT), 1, options=ModelOptions(physics_dt=0.0005))
    with pytest.raises(FFGymError, match=r"drive\.resolver_period"):
        reading(irb4600, -0.1)


def test_drives_of_a_batch_do_not_depend_on_each_other(irb4600, circle):
    def drives(delay, period):
        real = load_robot("irb4600_60_205_servo_drives")
        return replace(real, drive=replace(real.drive, torque_delay=np.full(6, delay), resolver_period=period))

    machines = [drives(5e-4, DT), drives(0.0, 0.0), drives(7.3e-4, 2 * DT), drives(0.0, 4 * DT)]
    together = simulate([circle] * 4, machine=machines)
    for machine, beside in zip(machines, together, strict=True):
        alone = simulate([circle], machine=machine)[0]
        for name in alone.columns:
            np.testing.assert_array_equal(beside[name], alone[name], err_msg=name)


def test_drives_are_written_into_machine_files_and_left_out_again(irb4600, tmp_path):
    real = load_robot("irb4600_60_205_servo_drives")
    for robot, named in ((real, "irb4600_60_205"), (irb4600, "irb4600_60_205_servo_drives")):
        path = save_machine(Machine(robot=robot), tmp_path / "m.toml", title="t", source="s", robot=named)
        assert load_machine(path).physics(ModelOptions()) == Machine(robot=robot).physics(ModelOptions())
