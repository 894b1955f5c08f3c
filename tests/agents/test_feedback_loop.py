"""The linear model of a motor's loop: against formulas where there are some, else against the simulator."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from ffgym.agents.bspline import StaticBSN
from ffgym.agents.feedback_loop import FeedbackLoop, nominal_bristles
from ffgym.agents.trials import SIGNALS, learning_signal
from ffgym.control import DynamicLuGreExact, FeedForwardLaw
from ffgym.control.setpoints import torque_at_rows
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths import joint_reference, joint_sine
from ffgym.robot import RigidArm
from ffgym.simulation import Run, simulate


@pytest.fixture(scope="module")
def without_friction():
    """Function that returns a robot with next to no friction."""

    def remove(robot):
        return replace(robot, friction=robot.friction.scale(bristle_stiffness=1e-9, bristle_damping=0, viscous=0))

    return remove


def loop_at_rest(robot, q, duration, dt, **options):
    """Loop of motors that stand still, and the times of its rows."""
    t = np.arange(round(duration / dt) + 1) * dt
    still = np.zeros((len(t), robot.n_joints))
    return FeedbackLoop.along(RigidArm(robot), q, still, still, dt, **options), t


def settled_gain(loop, t, frequency, signal="u_p"):
    """Complex gain from torque to loss at `frequency` [Hz], from the last ten of many periods, shape (N,)."""
    wave = np.exp(2j * np.pi * frequency * t)
    torque = np.broadcast_to(wave.imag[:, None, None], (len(t), loop.entry.shape[1], 1))
    last = t > t[-1] - 10 / frequency
    phasor = wave[last].conj()[:, None]
    return 2j * np.mean(loop.loss(torque, signal)[last, :, 0] * phasor, axis=0)


@pytest.mark.parametrize("frequency", [1.0, 5.0, 20.0])
def test_without_friction_a_rigid_motor_answers_as_its_transfer_function(one_axis, without_friction, frequency):
    robot = without_friction(one_axis)
    loop, t = loop_at_rest(robot, np.zeros(1), 20 / frequency + 2, 0.005 / frequency)
    s = 2j * np.pi * frequency
    gains, inertia = robot.servo, robot.drive.rotor_inertia + RigidArm(robot).mass_matrix(np.zeros((1, 1)))[0, 0]
    answer = gains.velocity_gain * s**2 + gains.position_gain * s
    expected = answer / (inertia * s**3 + answer + gains.integral_gain)
    np.testing.assert_allclose(settled_gain(loop, t, frequency), expected, rtol=2e-3)


@pytest.mark.parametrize("frequency", [2.0, 8.0, 30.0])
def test_without_friction_an_elastic_motor_answers_as_two_masses_on_a_spring(
    irb4600, arm, corners, without_friction, frequency
):
    robot, q = without_friction(irb4600), corners["p1"]
    loop, t = loop_at_rest(robot, q, 20 / frequency + 2, 0.005 / frequency)
    s, drive, gains, square = 2j * np.pi * frequency, robot.drive, robot.servo, robot.drive.gear_ratio**2
    link = np.diag(arm.mass_matrix(q[None])[0]) / square
    spring = (drive.joint_stiffness + drive.joint_damping * s) / square
    inertia = drive.rotor_inertia + link * spring / (link * s**2 + spring)
    answer = gains.velocity_gain * s + gains.position_gain
    expected = answer / (inertia * s**2 + answer + gains.integral_gain / s)
    np.testing.assert_allclose(settled_gain(loop, t, frequency), expected, rtol=5e-3)


def test_the_integral_takes_lasting_torque_out_of_u_p_and_keeps_it_in_u_c(irb4600, corners):
    loop, t = loop_at_rest(irb4600, corners["p1"], 20.0, 0.004)
    torque = np.ones((len(t), 6, 1))
    lasting = {signal: loop.loss(torque, signal)[-1, :, 0] for signal in SIGNALS}
    np.testing.assert_allclose(lasting["u_p"], 0, atol=1e-3)
    np.testing.assert_allclose(lasting["e_p"], 0, atol=1e-3)
    np.testing.assert_allclose(lasting["u_c"], 1, atol=1e-3)


def test_bristles_take_up_torque_where_a_motor_stands_and_not_where_it_slides(one_axis):
    t = np.arange(201) * 0.001
    torque = np.ones((len(t), 1, 1))

    def loss(speed):
        motor_dq = np.full((len(t), 1), speed)
        z = np.zeros_like(motor_dq) if speed == 0 else one_axis.friction.stribeck_level(motor_dq) / 69.9787
        return FeedbackLoop.along(RigidArm(one_axis), np.zeros(1), motor_dq, z, 0.001).loss(torque)[20:100].max()

    assert loss(0.0) < 0.5 * loss(5.0)


def soft_axis(one_axis, share):
    """The one-axis model with a spring, and a share of its friction behind it."""
    drive = replace(one_axis.drive, joint_stiffness=np.array([21.0]), joint_damping=np.array([0.017]))
    return replace(one_axis, drive=drive).with_arm_share(share)


def impedances(robot, frequency):
    """s = j w, torque over angle of a link that bristles hold, and of the spring before it, motor side."""
    s, drive, friction, square = 2j * np.pi * frequency, robot.drive, robot.friction, robot.drive.gear_ratio**2
    held = friction.bristle_stiffness + (friction.bristle_damping + friction.viscous) * s
    link = RigidArm(robot).mass_matrix(np.zeros((1, 1)))[0, 0] / square * s**2 + held
    return s, link, (drive.joint_stiffness + drive.joint_damping * s) / square


@pytest.mark.parametrize("frequency", [2.0, 8.0, 30.0])
def test_bristles_on_an_arm_at_rest_hold_it_as_a_spring(one_axis, frequency):
    robot = soft_axis(one_axis, 1.0)
    loop, t = loop_at_rest(robot, np.zeros(1), 20 / frequency + 2, 0.005 / frequency)
    s, link, spring = impedances(robot, frequency)
    drive, gains = robot.drive, robot.servo
    answer = gains.velocity_gain * s + gains.position_gain
    moved = drive.rotor_inertia * s**2 + link * spring / (link + spring) + answer + gains.integral_gain / s
    np.testing.assert_allclose(settled_gain(loop, t, frequency), answer / moved, rtol=5e-3)


@pytest.mark.parametrize("frequency", [2.0, 8.0, 30.0])
def test_torque_on_the_arm_reaches_the_feedback_through_its_spring(one_axis, frequency):
    robot = soft_axis(one_axis, 1.0)
    on_motor, t = loop_at_rest(robot, np.zeros(1), 20 / frequency + 2, 0.005 / frequency)
    on_arm, _ = loop_at_rest(robot, np.zeros(1), 20 / frequency + 2, 0.005 / frequency, on_arm=True)
    _, link, spring = impedances(robot, frequency)
    through = settled_gain(on_arm, t, frequency) / settled_gain(on_motor, t, frequency)
    np.testing.assert_allclose(through, spring / (link + spring), rtol=5e-3)


@dataclass(frozen=True, eq=False)
class Given(FeedForwardLaw):
    """Torque that is given, for one motion."""

    added: Array
    name: ClassVar[str] = "given"

    def torque(self, reference):
        return self.added


def misses_of_loops(robot, frequency, *believed):
    """Errors of the loops of believed robots, over what splines take off the simulator's feedback, shape (K,) each."""
    reference = joint_reference(robot, joint_sine([1.0], frequency, 2.0))
    network, friction = StaticBSN.zero(1), robot.friction
    splines = network.design_matrix(reference.motor_dq[:, 0], reference.motor_ddq[:, 0]).toarray()
    added = splines[:, np.flatnonzero(splines.sum(axis=0) > 2)[::7]]
    added[0] = 0.0
    base, size = DynamicLuGreExact(friction).torque(reference), 0.01
    laws = [Given(base + sign * size * column[:, None]) for column in added.T for sign in (-1, 1)]
    recordings = simulate([Run(reference=reference, law=law) for law in laws])
    signals = [learning_signal(recording, robot) for recording in recordings]
    measured = np.hstack([(less - more) / (2 * size) for less, more in zip(signals[::2], signals[1::2], strict=True)])

    motor_dq, dt = torque_at_rows(reference.motor_dq, 4), 0.001
    z, torque = nominal_bristles(friction, motor_dq, dt), torque_at_rows(added, 4)[:, None]
    predicted = [
        FeedbackLoop.along(RigidArm(each), reference.q.mean(axis=0), motor_dq, z, dt).loss(torque)[:, 0]
        for each in believed
    ]
    return [np.linalg.norm(each - measured, axis=0) / np.linalg.norm(measured, axis=0) for each in predicted]


@pytest.mark.parametrize("frequency", [1.0, 3.0])
def test_splines_take_off_the_feedback_what_they_do_in_the_simulator(one_axis, frequency):
    [miss] = misses_of_loops(one_axis, frequency, one_axis)
    assert len(miss) >= 4
    assert miss.max() < 0.03


def test_a_loop_that_knows_friction_on_the_arm_is_nearer_to_the_simulator(one_axis):
    robot = soft_axis(one_axis, 0.7)
    knowing, unaware = misses_of_loops(robot, 3.0, robot, soft_axis(one_axis, 0.0))
    assert knowing.max() < 0.06
    assert np.all(knowing < 0.5 * unaware)


def test_an_unknown_learning_signal_is_refused(one_axis):
    loop, t = loop_at_rest(one_axis, np.zeros(1), 0.1, 0.004)
    with pytest.raises(FFGymError, match="learning signal"):
        loop.loss(np.zeros((len(t), 1, 1)), "u")
