"""Signals of a recording: motion without delay, torque when it acts, sides and couplings as the header says."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification import signals_of
from ffgym.logs.preparation import LowPass
from ffgym.recordings import Header, Recording
from ffgym.robot import load_robot

DT = 0.001
T = DT * np.arange(4000)
W = 2 * np.pi * 2.0


@pytest.fixture(scope="module")
def robot():
    return load_robot("two_link")


def recorded(robot, q, torque, **header):
    """A recording of joint positions and motor torques, on the sides that the header says."""
    settings = {"torque_semantics": "motor_side", "hold": "sampled", "position_side": "motor"} | header
    position = q if settings["position_side"] == "link" else robot.drive.motor_angle(q)
    effort = robot.drive.joint_torque(torque) if settings["torque_semantics"] == "link_side" else torque
    columns = {"timestamp": T}
    for j, joint in enumerate(robot.joints):
        columns |= {f"motor.position.{joint}": position[:, j], f"motor.effort.{joint}": effort[:, j]}
    gears = {"gear_ratio": tuple(robot.drive.gear_ratio.tolist())}
    return Recording(columns, Header(robot=robot.name, joints=robot.joints, **gears, **settings))


def sway(t=T):
    return np.stack([np.sin(W * t), np.cos(W * t)], axis=1)


def test_motion_is_that_of_the_joints_without_delay(robot):
    signals = signals_of(robot, recorded(robot, 0.1 * sway(), sway()))
    rows = signals.valid
    rate = 0.1 * W * np.stack([np.cos(W * T), -np.sin(W * T)], axis=1)
    np.testing.assert_allclose(signals.q[rows], 0.1 * sway()[rows], atol=2e-6)
    np.testing.assert_allclose(signals.dq[rows], rate[rows], atol=2e-4)
    np.testing.assert_allclose(signals.ddq[rows], -0.1 * W**2 * sway()[rows], atol=4e-3)
    np.testing.assert_allclose(signals.motor_ddq, robot.drive.motor_angle(signals.ddq))
    np.testing.assert_allclose(signals.torque[rows], sway()[rows], atol=2e-5)


@pytest.mark.parametrize("header", [{"position_side": "link"}, {"torque_semantics": "link_side"}])
def test_sides_of_the_gearbox_make_no_difference_with_coupled_motors_too(robot, header):
    coupled = replace(robot, drive=replace(robot.drive, coupling=np.array([[0.0, 0.0], [30.0, 0.0]])))
    wanted = signals_of(coupled, recorded(coupled, sway(), sway()))
    signals = signals_of(coupled, recorded(coupled, sway(), sway(), **header))
    for name in ("q", "dq", "ddq", "torque"):
        np.testing.assert_allclose(getattr(signals, name), getattr(wanted, name), rtol=1e-9, atol=1e-6)


def test_a_held_torque_is_taken_half_a_sample_later_where_it_acts(robot):
    held = sway(T + DT / 2)  # what a smooth torque is in the middle of each hold
    rows = slice(200, -200)
    signals = signals_of(robot, recorded(robot, sway(), held, hold="zoh"))
    np.testing.assert_allclose(signals.torque[rows], sway()[rows], atol=1e-4)
    late = signals_of(robot, recorded(robot, sway(), held, hold="sampled"))
    assert np.abs(late.torque - sway())[rows].max() > 5e-3


def test_ends_that_the_filter_does_not_know_do_not_count(robot):
    signals = signals_of(robot, recorded(robot, sway(), sway()), LowPass(cutoff=10.0, settling=2.0))
    assert not signals.valid[:200].any()
    assert not signals.valid[-200:].any()
    assert signals.valid[200:-200].all()
    every = signals_of(robot, recorded(robot, sway(), sway()), LowPass(settling=0.0))
    assert every.valid.all()


def test_noise_above_the_cut_off_is_taken_away(robot):
    noise = 0.1 * np.random.default_rng(0).normal(size=(len(T), 2))
    signals = signals_of(robot, recorded(robot, sway(), noise))
    assert signals.torque.std() == pytest.approx(0.1 * np.sqrt(2 * 40.0 * DT), rel=0.2)


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ({"torque_semantics": "unspecified"}, "does not say what its torque is"),
        ({"hold": "unspecified"}, "does not say when its torque acts"),
    ],
)
def test_a_recording_that_does_not_say_what_its_torque_is_or_when_it_acts_is_refused(robot, header, message):
    with pytest.raises(FFGymError, match=message):
        signals_of(robot, recorded(robot, sway(), sway(), **header))


def test_other_gears_other_joints_and_uneven_times_are_refused(robot, one_axis):
    recording = recorded(robot, sway(), sway())
    other = replace(robot, drive=replace(robot.drive, gear_ratio=2 * robot.drive.gear_ratio))
    with pytest.raises(FFGymError, match="gear ratios"):
        signals_of(other, recording)
    with pytest.raises(FFGymError, match="2 joints, robot 'one_axis' 1"):
        signals_of(one_axis, recording)
    with pytest.raises(FFGymError, match=r"sampled unevenly, every 0\.001 to 0\.002 s"):
        signals_of(robot, recording.with_columns(timestamp=T + DT * (T > 2)))
    with pytest.raises(FFGymError, match="must lie below 500"):
        signals_of(robot, recording, LowPass(cutoff=600.0))
