"""Laws that act through set-points: the gain of the torque channel, what delay costs, what is recorded."""

import numpy as np
import pytest

from ffgym.agents import elastic_feedforward
from ffgym.control import CorrectionLimits, FeedForwardLaw, SetpointChannel, SetpointResponse
from ffgym.core.errors import FFGymError
from ffgym.paths import Reference, cartesian_reference, circle_test
from ffgym.recordings import Recording
from ffgym.recordings.metrics import motor_error, path_errors
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import Run, simulate

LATE = SetpointResponse.low_pass(20.0, delay=0.0093, damping=0.71)


def rms_um(recording: Recording) -> float:
    """Largest RMS path error of a circle [um]."""
    return max(error.rms for error in path_errors(recording)) * 1e6


@pytest.fixture(scope="module")
def circle(irb4600: RobotDescription) -> Reference:
    area = irb4600.work_area
    assert area is not None
    path = circle_test(irb4600.position("p1"), 0.04, radii=[0.003], normal=area.normal, dt=0.004, name="circle")
    return cartesian_reference(RigidArm(irb4600), path)


@pytest.fixture(scope="module")
def law(irb4600: RobotDescription) -> FeedForwardLaw:
    return elastic_feedforward(irb4600)


@pytest.fixture(scope="module")
def recordings(circle: Reference, law: FeedForwardLaw) -> dict[str, Recording]:
    """Recordings by the way the law acts."""
    channels = {
        "setpoint": SetpointChannel(),
        "late": SetpointChannel(response=LATE, known=SetpointResponse()),
        "compensated": SetpointChannel(response=LATE),
    }
    runs = {
        "none": Run(reference=circle),
        "torque": Run(reference=circle, law=law),
        **{name: Run(reference=circle, law=law, channel=channel) for name, channel in channels.items()},
    }
    return dict(zip(runs, simulate(list(runs.values())), strict=True))


def test_set_points_keep_the_gain_of_torques(recordings: dict[str, Recording]) -> None:
    none, torque, setpoint = (rms_um(recordings[name]) for name in ("none", "torque", "setpoint"))
    assert none - setpoint > 0.99 * (none - torque)


def test_delay_and_filter_cost_most_of_the_gain_unless_they_are_compensated(recordings: dict[str, Recording]) -> None:
    none, late, compensated = (rms_um(recordings[name]) for name in ("none", "late", "compensated"))
    assert late > 0.15 * none
    assert compensated < 0.03 * none


def test_recorded_set_points_are_those_that_the_servo_followed(
    recordings: dict[str, Recording], circle: Reference, irb4600: RobotDescription
) -> None:
    recording = recordings["setpoint"]
    correction = recording.joint_array("correction.position")
    program = recording.joint_array("reference.position") - correction
    np.testing.assert_allclose(program[::4], circle.motor_q, atol=1e-12)
    assert not recording.joint_array("compensation.effort").any()
    # the servo's torque from recorded signals, and motor errors without the correction
    servo = irb4600.servo
    error = recording.joint_array("reference.position") - recording.joint_array("motor.position")
    rate = recording.joint_array("reference.velocity") - recording.joint_array("motor.velocity")
    feedback = servo.position_gain * error + servo.velocity_gain * rate + recording.joint_array("feedback.integral")
    np.testing.assert_allclose(recording.joint_array("feedback.effort"), feedback, atol=1e-9)
    np.testing.assert_allclose(motor_error(recording), error - correction, atol=1e-12)
    # the integral that the engine kept is that of the error that is recorded
    kept = recording.joint_array("feedback.integral") / servo.integral_gain
    integral = np.cumsum(error * recording.dt, axis=0)
    drift = (kept - kept[0]) - (integral - integral[0])
    assert np.abs(drift).max() < 0.02 * np.abs(kept - kept[0]).max()


def test_limits_hold_for_what_is_sent(circle: Reference, law: FeedForwardLaw, irb4600: RobotDescription) -> None:
    torque = law.torque(circle)
    free = SetpointChannel().send(irb4600.servo, torque)
    limits = CorrectionLimits.even(6, size=0.5 * np.abs(free).max())
    sent = SetpointChannel(limits=limits).send(irb4600.servo, torque)
    assert np.abs(sent).max() <= limits.size[0]
    within = np.abs(free).max(axis=0) < limits.size
    assert within.any()
    np.testing.assert_allclose(sent[:, within], free[:, within], atol=1e-12)


def test_a_channel_of_another_kind_is_refused(circle: Reference) -> None:
    with pytest.raises(FFGymError, match="channel must be a SetpointChannel or None, got 'setpoint'"):
        Run(reference=circle, channel="setpoint")  # type: ignore[arg-type]
    with pytest.raises(FFGymError, match=r"must be SetpointResponse\(\)"):
        SetpointChannel(response=0.004)  # type: ignore[arg-type]
