"""Servo and friction: what is recorded is what MuJoCo applies, and what the formulas say."""

from dataclasses import dataclass, replace
from typing import ClassVar

import mujoco
import numpy as np
import pytest

from ffgym.control import DynamicLuGreExact, FeedForwardLaw
from ffgym.paths import joint_reference, joint_sine
from ffgym.robot.model.names import friction_actuator, servo_actuator
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Plant
from ffgym.studies import circle_references
from tests.simulation.plant.driving import controls


@dataclass(frozen=True)
class ConstantTorque(FeedForwardLaw):
    """The same added torque on every motor."""

    value: float
    name: ClassVar[str] = "constant"

    def torque(self, reference):
        return np.full_like(reference.q, self.value)


@pytest.fixture(scope="module")
def fast_circle(arm):
    return circle_references(arm, ["p1"], [0.1], [0.001])["p1", 0.1]


@pytest.fixture(scope="module")
def recording(irb4600, arm, fast_circle):
    """A fast circle at every physics step."""
    run = Run(reference=fast_circle, law=DynamicLuGreExact(irb4600.friction))
    return simulate([run], arm=arm, record_dt=irb4600.physics_dt)[0]


def applied(robot, recording, rows):
    """Torque [N m] that MuJoCo's servos and friction actuators give at recorded states, (rows, N) each."""
    plant = Plant(robot, 1)
    model, at, ratio = plant.model, plant.addresses, robot.drive.gear_ratio
    data = mujoco.MjData(model)
    read = {name: recording.joint_array(name) for name in recording.families if name.split(".")[0] in _PER_JOINT}
    servos = [model.actuator(servo_actuator(joint)).id for joint in robot.joints]
    frictions = [model.actuator(friction_actuator(joint)).id for joint in robot.joints]
    efforts, resistances = [], []
    for k in rows:
        motor, motor_dq = read["motor.position"][k] / ratio, read["motor.velocity"][k] / ratio
        data.qpos[at.motor_qpos], data.qvel[at.motor_qpos] = motor, motor_dq
        data.qpos[at.deflection_qpos] = (read["link.position"][k] - motor)[at.is_elastic]
        data.qvel[at.deflection_qpos] = (read["link.velocity"][k] - motor_dq)[at.is_elastic]
        data.act[at.integral] = read["feedback.integral"][k] / robot.servo.integral_gain
        torque = read["feedforward.effort"][k] + read["compensation.effort"][k]
        setpoints = (read["reference.position"][k], read["reference.velocity"][k], torque)
        data.ctrl[:] = controls(plant, *setpoints)
        mujoco.mj_forward(model, data)
        efforts.append(data.actuator_force[servos].copy())
        resistances.append(-data.actuator_force[frictions])
    return np.array(efforts), np.array(resistances)


_PER_JOINT = ("motor", "link", "reference", "feedforward", "feedback", "compensation")


def test_recorded_motor_effort_is_the_force_of_mujocos_servo(irb4600, recording):
    rows = np.arange(0, len(recording), 13)
    effort, _ = applied(irb4600, recording, rows)
    np.testing.assert_allclose(recording.joint_array("motor.effort")[rows], effort, atol=1e-11)
    assert np.abs(effort).max() > 1


def test_feedback_is_pid_on_the_recorded_errors(irb4600, recording):
    servo = irb4600.servo
    error = recording.joint_array("reference.position") - recording.joint_array("motor.position")
    rate = recording.joint_array("reference.velocity") - recording.joint_array("motor.velocity")
    u_fb, u_i = recording.joint_array("feedback.effort"), recording.joint_array("feedback.integral")
    np.testing.assert_allclose(u_fb - u_i, servo.position_gain * error + servo.velocity_gain * rate, atol=1e-12)
    summed = np.cumsum(error[:-1], axis=0) * irb4600.physics_dt * servo.integral_gain
    np.testing.assert_allclose(u_i[1:], u_i[0] + summed, atol=1e-11)


def test_command_is_the_sum_of_feedback_and_feed_forwards(recording):
    parts = ("feedback.effort", "feedforward.effort", "compensation.effort")
    total = sum(recording.joint_array(part) for part in parts)
    np.testing.assert_allclose(recording.joint_array("command.effort"), total, atol=1e-12)


def test_integral_starts_at_gravity(irb4600, arm, recording):
    held = arm.gravity_torque(recording.joint_array("link.position")[:1])[0] / irb4600.drive.gear_ratio
    np.testing.assert_allclose(recording.joint_array("feedback.integral")[0], held, atol=1e-9)


def test_drive_gives_no_more_than_its_peak_torque(irb4600, fast_circle):
    peak = np.array([5.0, 12.0, 8.0, 0.6, 0.4, 1.0])
    weak = replace(irb4600, drive=replace(irb4600.drive, peak_torque=peak))
    reference = replace(fast_circle, robot=weak)
    recording = simulate([Run(reference=reference)], record_dt=weak.physics_dt)[0]
    effort, command = recording.joint_array("motor.effort"), recording.joint_array("command.effort")
    np.testing.assert_array_equal(effort, np.clip(command, -peak, peak))
    assert np.any(np.abs(command) > peak)
    rows = np.flatnonzero(np.any(np.abs(command) > peak, axis=1))[::7]
    np.testing.assert_allclose(effort[rows], applied(weak, recording, rows)[0], atol=1e-11)


def test_integral_winds_up_no_further_than_the_peak_torque(one_axis):
    strong = one_axis.drive.peak_torque[0]
    reference = joint_reference(one_axis, joint_sine([0.0], 1.0, 2.0))
    recording = simulate([Run(reference=reference, law=ConstantTorque(-3 * strong))])[0]
    integral = recording["feedback.integral.j1"]
    assert integral.max() == pytest.approx(strong, rel=0.01)  # MuJoCo stops at the first step beyond the limit
    assert np.ptp(integral[-500:]) < 1e-9
    assert np.abs(recording["motor.effort.j1"]).max() == strong
    rows = np.arange(0, len(integral), 50)
    np.testing.assert_allclose(recording.joint_array("motor.effort")[rows], applied(one_axis, recording, rows)[0])


def test_recorded_friction_is_what_resists_in_mujoco(irb4600, fast_circle, recording):
    """MuJoCo's bristle part plus its viscous damping, at states of the plant itself, is LuGre's formula."""
    plant = Plant(irb4600, 1)
    model, ratio = plant.model, irb4600.drive.gear_ratio
    plant.rest(fast_circle.q[:1])
    push = np.array([6.0, 8.0, 6.0, 1.0, 1.5, 1.5])
    n = 400
    torque = push * np.sin(np.arange(n) * 0.05)[None, :, None]
    qpos, qvel, act = plant.advance(controls(plant, fast_circle.q[0] * ratio, torque=torque))
    state = plant.unpack(qpos, qvel, act)
    expected = irb4600.friction.torque(state.bristle, state.motor_velocity)[0]
    data = mujoco.MjData(model)
    frictions = [model.actuator(friction_actuator(joint)).id for joint in irb4600.joints]
    motors = plant.addresses.motor_qpos
    for k in range(0, n, 11):
        data.qpos, data.qvel, data.act = qpos[0, k], qvel[0, k], act[0, k]
        mujoco.mj_forward(model, data)
        resisting = -data.actuator_force[frictions] - data.qfrc_passive[motors] / ratio
        np.testing.assert_allclose(resisting, expected[k], atol=1e-12)
    assert np.all(np.abs(expected).max(axis=0) > 0.5 * irb4600.friction.coulomb)
    # and the recording uses the same formula: its signs oppose the motion
    friction, speed = recording.joint_array("friction.effort"), recording.joint_array("motor.velocity")
    sliding = np.abs(speed) > 1.0
    assert np.all(friction[sliding] * speed[sliding] > 0)


def test_inertia_times_acceleration_is_motor_torque_minus_friction(one_axis):
    inertia = one_axis.drive.rotor_inertia[0] + one_axis.bodies.inertia[0, 2]
    reference = joint_reference(one_axis, joint_sine([1.0], 3.0, 1.0))
    recording = simulate([Run(reference=reference)], record_dt=one_axis.physics_dt)[0]
    speed, effort = recording["motor.velocity.j1"], recording["motor.effort.j1"]
    net = effort - recording["friction.effort.j1"]
    acceleration = np.diff(speed) / one_axis.physics_dt
    np.testing.assert_allclose(inertia * acceleration, net[:-1], rtol=0.002, atol=1e-3)


def test_at_rest_the_integral_holds_gravity_and_nothing_moves(irb4600, arm, corners):
    q = np.array(list(corners.values()))
    plant = Plant(irb4600, 4)
    plant.rest(q)
    n = round(0.5 / plant.physics_dt)
    position = (q * irb4600.drive.gear_ratio)[:, None]
    state = plant.unpack(*plant.advance(controls(plant, position, shape=(4, n, 6))))
    assert np.abs(state.motor_velocity).max() < 1e-8
    assert np.abs(state.link_velocity).max() < 1e-9
    held = irb4600.servo.integral_gain * state.integral[:, -1]
    gravity = arm.gravity_torque(state.link_position[:, -1]) / irb4600.drive.gear_ratio
    np.testing.assert_allclose(held, gravity, atol=1e-9)
    assert np.abs(held[:, 1]).min() > 4
