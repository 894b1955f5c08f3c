"""What cannot be right is said: a wrong sign, unit or mass in the sentences of a fit, or in one error."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification.rigid_body import RigidBodyOptions, identify_rigid_body
from ffgym.recordings import Recording
from ffgym.report.identification import RigidBodyReport, format_rigid_body, rigid_body_numbers
from ffgym.robot import load_robot
from tests.diagnosis.identification.rigid_body.recorded_arms import mistaken, recorded, rigid, swing

QUICK = RigidBodyOptions(resamples=2)


@pytest.fixture(scope="module")
def robot():
    return rigid(load_robot("two_link"))


@pytest.fixture(scope="module")
def recording(robot):
    return recorded(robot, swing(robot, 1), noise=0.02)


def with_torque(recording, change):
    """The recording with other torque of each motor, which `change` gives by the number of the motor."""
    names = [f"motor.effort.{joint}" for joint in recording.header.joints]
    changed = {name: change(j, recording[name]) for j, name in enumerate(names)}
    return Recording({**recording.columns, **changed}, recording.header)


def heavier(robot, factor):
    bodies = robot.bodies
    return replace(robot, bodies=replace(bodies, mass=factor * bodies.mass, inertia=factor * bodies.inertia))


def test_nothing_speaks_against_a_fit_of_a_description_that_is_off_by_a_third(robot, recording):
    assert identify_rigid_body(mistaken(robot), [recording], QUICK).doubts == ()


def test_torque_of_the_wrong_sign_is_left_unexplained_and_the_motor_named(robot, recording):
    turned = with_torque(recording, lambda j, torque: -torque if j == 1 else torque)
    fit = identify_rigid_body(robot, [turned], QUICK)
    (doubt,) = [doubt for doubt in fit.doubts if doubt.startswith("elbow: ")]
    assert "of its torque is left unexplained. Look for a wrong sign, unit, side" in doubt


@pytest.mark.parametrize("factor", [1e-3, 1e-9])
def test_masses_that_are_off_by_powers_of_ten_are_suspected(robot, recording, factor):
    fit = identify_rigid_body(heavier(robot, factor), [recording], QUICK)
    assert any("the largest spread that was tried, 10: masses or rotors" in doubt for doubt in fit.doubts)


def test_a_spread_that_is_given_is_no_reason_to_doubt(robot, recording):
    assert identify_rigid_body(robot, [recording], replace(QUICK, spread=10.0)).doubts == ()


def test_doubts_are_printed_and_kept_beside_those_of_the_logs(robot, recording):
    fit = identify_rigid_body(robot, [with_torque(recording, lambda j, torque: -torque)], QUICK)
    report = RigidBodyReport(fit=fit, held_out=[], doubts_of_logs=["run 1 has a clock that jumps"])
    assert rigid_body_numbers(report)["doubts"] == ["run 1 has a clock that jumps", *fit.doubts]
    text = " ".join(format_rigid_body(report).split())
    assert "note: run 1 has a clock that jumps" in text
    assert f"note: {fit.doubts[0]}" in text


def test_numbers_too_far_apart_for_floating_point_are_one_error(robot, recording):
    with pytest.raises(FFGymError, match="singular in floating point: description and recordings differ"):
        identify_rigid_body(heavier(robot, 1e8), [recording], QUICK)


@pytest.mark.parametrize("spread", [0.0, 1e-200, 1e12, np.nan])
def test_a_spread_without_meaning_is_refused(spread):
    with pytest.raises(FFGymError, match="spread"):
        RigidBodyOptions(spread=spread)


def test_a_motor_that_moves_without_torque_is_named(robot, recording):
    silent = with_torque(recording, lambda j, torque: 0 * torque if j == 1 else torque)
    with pytest.raises(FFGymError, match=r"motor\.effort of elbow is 0 wherever it moves"):
        identify_rigid_body(robot, [silent], QUICK)
