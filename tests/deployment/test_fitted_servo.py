"""Gains that were found, in the file of a controller and in plans: they keep more of the gain than documented ones."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ffgym.diagnosis.identification.controller as controller_module
from ffgym.agents import elastic_feedforward
from ffgym.cli.main import main
from ffgym.control import NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.deployment import plan_setpoints, read_controller, read_plan, read_servo, write_controller
from ffgym.diagnosis.identification import identify_controller
from ffgym.diagnosis.identification.servo_equation import ServoLog
from ffgym.diagnosis.identification.servo_gains import GAINS, fit_servo
from ffgym.paths import cartesian_reference, circle_test, joint_reference, joint_sine
from ffgym.robot import RigidArm, RobotDescription
from tests.deployment.drive_samples import FACTORS, RESPONSE, log_of_drive, probe, run_stream, with_other_gains
from tests.deployment.test_planning import mean_error, stream


def missed(planned: RobotDescription, real: RobotDescription, *, law: bool = True) -> float:
    """RMS of what the link misses along a slow sine [rad], planned for one robot and sent to another."""
    reference = joint_reference(planned, joint_sine([0.3], 0.5, 2.0))
    plan = plan_setpoints(reference, elastic_feedforward(planned) if law else NoCompensation(), response=RESPONSE)
    _, emulated = run_stream(plan, real, planned)
    truth = emulated.truth(plan.name)
    assert emulated.began is not None
    late = truth.t - emulated.began - RESPONSE.delay  # the filter is compensated
    moving = (late > 0.5) & (late < reference.t[-1] - 0.2)
    error = truth.joint_array("link.position")[:, 0] - np.interp(late, reference.t, reference.q[:, 0])
    return float(np.std(error[moving]))


def test_a_plan_with_gains_that_were_found_keeps_more_of_the_gain(one_axis: RobotDescription) -> None:
    real = replace(with_other_gains(one_axis), friction=one_axis.friction)
    log = log_of_drive(probe(one_axis, 2.0), real, one_axis)
    logs = [ServoLog.of(log, RigidArm(one_axis), feedforward=True)]
    found = fit_servo(logs, one_axis.servo, RESPONSE, np.random.default_rng(0), joints=one_axis.joints)
    none = missed(one_axis, real, law=False)
    documented, fitted, known = (missed(each, real) for each in (one_axis, replace(one_axis, servo=found.servo), real))
    assert none - fitted > 0.95 * (none - known)
    assert none - documented < 0.85 * (none - known)


def test_without_torque_it_says_so_and_documented_gains_hold(
    one_axis: RobotDescription, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []
    monkeypatch.setattr(controller_module, "identify_response", lambda logs, arm, **_: asked.append(arm.robot.servo))
    log = log_of_drive(probe(one_axis, 1.2), one_axis, one_axis)
    without = log.derive({name: x for name, x in log.columns.items() if not name.startswith("motor.effort")})
    found = identify_controller([without], RigidArm(one_axis))
    assert found.servo is None
    assert "has no motor torque (motor.effort)" in found.no_torque
    assert asked == [one_axis.servo]


@pytest.mark.slow
def test_gains_of_six_axes_are_found_with_delay_and_filter_and_keep_nine_tenths_of_the_gain(
    irb4600: RobotDescription,
) -> None:
    real = replace(with_other_gains(irb4600), friction=irb4600.friction)
    found = identify_controller([log_of_drive(probe(irb4600, 2.0), real, irb4600)], RigidArm(irb4600))
    assert found.servo is not None
    assert found.response.response.delay == pytest.approx(RESPONSE.delay, abs=0.3e-3)
    for joint in found.servo.estimates:
        for estimate, factor in zip(joint, FACTORS.values(), strict=True):
            assert estimate.low < factor * estimate.prior < estimate.high
    errors = []
    for robot, response in ((irb4600, RESPONSE), (replace(irb4600, servo=found.servo.servo), found.response.response)):
        assert robot.work_area is not None
        path = circle_test(robot.position("p1"), 0.04, normal=robot.work_area.normal, dt=0.004, name="circles")
        reference = cartesian_reference(RigidArm(robot), path)
        plan = plan_setpoints(reference, elastic_feedforward(robot), response=response)
        errors.append(mean_error(stream(plan, real, RESPONSE, reference)[1]))
    without = plan_setpoints(reference, NoCompensation(), response=RESPONSE)
    none = mean_error(stream(without, real, RESPONSE, reference)[1])
    documented, fitted = errors
    assert none - fitted > 0.95 * none
    assert none - documented < 0.8 * none


@pytest.fixture
def controller(one_axis: RobotDescription, tmp_path: Path) -> Path:
    """File of a controller with other gains than documented."""
    servo = with_other_gains(one_axis).servo
    ends = {name: np.stack([0.9 * getattr(servo, name), 1.1 * getattr(servo, name)], axis=1) for name in GAINS}
    write_controller(
        tmp_path / "controller.toml",
        RESPONSE,
        source="identified from log.npz",
        servo=servo,
        joints=one_axis.joints,
        gain_intervals=ends,
        documented=["j1.integral_gain"],
    )
    return tmp_path / "controller.toml"


def test_gains_come_back_from_the_file_of_a_controller(controller: Path, one_axis: RobotDescription) -> None:
    servo = read_servo(controller, one_axis)
    assert servo is not None
    for name in GAINS:
        np.testing.assert_array_equal(getattr(servo, name), getattr(with_other_gains(one_axis).servo, name))
    assert servo.control_dt == one_axis.servo.control_dt
    assert read_controller(controller) == RESPONSE
    write_controller(controller, RESPONSE, source="manual")
    assert read_servo(controller, one_axis) is None


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('joints = ["j1"]', 'joints = ["axis"]', r"joints = \['axis'\] of \[servo\] must be \['j1'\]"),
        ("velocity_gain = [", "velocity_gain = [-", r"servo.velocity_gain = \[-0.48.*\] must be > 0"),
        ("position_gain = [", "position_gain = [1.0, ", r"position_gain.*shape"),
        ("position_gain = [", "damping = [", r"Unknown entries of \[servo\]: damping"),
        ("integral_gain = [", 'integral_gain = ["much", ', r"integral_gain must be numbers"),
    ],
)
def test_mistakes_in_gains_are_named(
    old: str, new: str, message: str, controller: Path, one_axis: RobotDescription
) -> None:
    controller.write_text(controller.read_text().replace(f"\n{old}", f"\n{new}"))
    with pytest.raises(FFGymError, match=rf"controller.toml: .*{message}"):
        read_servo(controller, one_axis)


def test_a_plan_takes_the_gains_of_the_controller_and_those_of_the_description_where_it_is_told(
    controller: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plans = {}
    for gains in ("controller", "description"):
        out = tmp_path / f"{gains}.npz"
        options = ["--controller", str(controller), "--gains", gains, "--out", str(out)]
        assert main(["plan", "one_axis", "sine", *options]) == 0
        assert f"gains of the servo: those of the {gains}" in capsys.readouterr().out
        plans[gains] = read_plan(out)
        assert plans[gains].meta["gains"] == gains
    one, other = (plans[gains].correction for gains in ("controller", "description"))
    assert np.abs(one - other).max() > 0.02 * np.abs(one).max()
