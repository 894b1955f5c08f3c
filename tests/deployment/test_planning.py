"""Plans of set-points: what reaches the servos of an emulated controller, and what is left of the gain."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ffgym.agents import elastic_feedforward
from ffgym.control import CorrectionLimits, FeedForwardLaw, NoCompensation, SetpointResponse
from ffgym.core.errors import FFGymError
from ffgym.deployment import (
    EgmWire,
    EmulatedController,
    EmulatedRobot,
    Envelope,
    RsiWire,
    SetpointPlan,
    StreamSession,
    plan_probe,
    plan_setpoints,
    read_controller,
    record_session,
    run_in_lock_step,
    write_controller,
)
from ffgym.deployment.streams import axes_of
from ffgym.diagnosis.identification import identify_response
from ffgym.paths import Reference, cartesian_reference, circle_test
from ffgym.recordings import Recording
from ffgym.recordings.metrics import path_errors
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.simulation import Run, simulate

EGM_RESPONSES = [
    SetpointResponse.low_pass(20.0, delay=0.0117),
    SetpointResponse.low_pass(15.0, delay=0.0293, damping=0.71),
    SetpointResponse.low_pass(20.0, delay=0.0042, damping=1.0),
]


@cache
def circles(speed: float) -> Reference:
    """Test motion of the thesis at one position [m/s]."""
    robot = load_robot("irb4600_60_205")
    assert robot.work_area is not None
    path = circle_test(robot.position("p1"), speed, normal=robot.work_area.normal, dt=0.004, name="circles")
    return cartesian_reference(RigidArm(robot), path)


def stream(
    plan: SetpointPlan,
    robot: RobotDescription,
    response: SetpointResponse,
    reference: Reference | None = None,
    *,
    corrections: bool = False,
) -> tuple[Recording, Recording]:
    """Stream a plan to an emulated controller; returns the log of the stream and the truth of the robot.

    The truth has the tool path of a `reference`, as late as the controller.
    """
    wire = (RsiWire if corrections else EgmWire)(axes_of(robot))
    emulated = EmulatedRobot(
        robot,
        plan.program[0],
        cycle=wire.cycle,
        response=response,
        program=plan.program if corrections else None,
    )
    limits = CorrectionLimits.even(robot.n_joints, size=0.02, rate=5.0, acceleration=500.0)
    session = StreamSession(plan, wire, Envelope(correction=limits, torque=robot.drive.peak_torque), robot.drive)
    run_in_lock_step(session, EmulatedController(emulated, wire))
    assert session.state == "ended"
    assert session.cut_share == 0.0
    return record_session(session, robot), emulated.truth(plan.name, reference)


def mean_error(truth: Recording) -> float:
    """Mean over circles of the RMS path error [m]."""
    return float(np.mean([error.rms for error in path_errors(truth)]))


def torque_channel(reference: Reference, law: FeedForwardLaw) -> tuple[float, float]:
    """Mean RMS path error without and with a law that adds torque [m]."""
    recordings = simulate([Run(reference=reference), Run(reference=reference, law=law)])
    none, torque = (float(np.mean([error.rms for error in path_errors(each)])) for each in recordings)
    return none, torque


def test_a_stream_of_positions_keeps_the_gain_of_torques_behind_a_filter(irb4600: RobotDescription) -> None:
    law, reference = elastic_feedforward(irb4600), circles(0.1)
    none, torque = torque_channel(reference, law)
    response = EGM_RESPONSES[0]
    _, truth = stream(plan_setpoints(reference, law, response=response), irb4600, response, reference)
    _, unaware = stream(plan_setpoints(reference, law), irb4600, response, reference)
    assert none - mean_error(truth) > 0.95 * (none - torque)
    # a filter that nobody compensates makes circles smaller by more than friction does
    assert none - mean_error(unaware) < 0.9 * (none - torque)


def test_corrections_of_a_program_are_sent_early_by_the_delay(irb4600: RobotDescription) -> None:
    law, reference = elastic_feedforward(irb4600), circles(0.04)
    none, torque = torque_channel(reference, law)
    response = SetpointResponse.low_pass(20.0, delay=0.0117)
    plans = [plan_setpoints(reference, law, response=each, sends="corrections") for each in (response, None)]
    aware, late = (stream(plan, irb4600, response, reference, corrections=True)[1] for plan in plans)
    assert none - mean_error(aware) > 0.95 * (none - torque)
    assert none - mean_error(late) < 0.6 * (none - torque)


def test_a_plan_without_law_is_the_program(irb4600: RobotDescription) -> None:
    reference = circles(0.1)
    plan = plan_setpoints(reference, NoCompensation())
    np.testing.assert_allclose(plan.correction, 0.0, atol=1e-12)
    assert np.array_equal(plan.program, reference.q)
    with pytest.raises(FFGymError, match="Unknown kind of set-points 'torques'"):
        plan_setpoints(reference, NoCompensation(), sends="torques")  # type: ignore[arg-type]


def test_a_plan_that_is_cut_to_its_limits_says_so(irb4600: RobotDescription) -> None:
    limits = CorrectionLimits.even(6, size=1e-4)
    plan = plan_setpoints(circles(0.1), elastic_feedforward(irb4600), limits=limits)
    assert plan.largest_correction.max() <= 1e-4 * (1 + 1e-12)
    assert max(plan.meta["beyond_limits"]["size"]) > 1
    assert set(plan.meta["beyond_limits"]) == {"size"}


def test_delay_and_filter_are_found_from_a_log_of_a_stream(one_axis: RobotDescription) -> None:
    response = SetpointResponse.low_pass(12.0, delay=0.0171, damping=0.8)
    probe = plan_probe(RigidArm(one_axis), np.random.default_rng(1), duration=1.6)
    more = {name: 1.2 * getattr(one_axis.friction, name) for name in ("coulomb", "static")}
    friction = replace(one_axis.friction, **more)
    log, _ = stream(probe, replace(one_axis, friction=friction), response)
    told = []
    fit = identify_response([log], RigidArm(one_axis), progress=lambda done, total: told.append((done, total)))
    assert told == [(done, 5) for done in range(len(told))]
    assert fit.response.delay == pytest.approx(response.delay, abs=0.3e-3)
    assert fit.response.lag == pytest.approx(response.lag, rel=0.05)
    low, high = fit.intervals["delay"]
    assert low < response.delay < high < response.delay + 1.5e-3
    # the sum, which paths need, is known better than how it divides
    least, most = fit.intervals["total_delay"]
    assert least < fit.response.total_delay < most
    assert most - least < 0.5 * (high - low)
    assert fit.response.total_delay == pytest.approx(response.total_delay, abs=0.1e-3)
    assert fit.factors["Coulomb friction"][0] == pytest.approx(1.2, rel=0.05)
    assert fit.explained > 0.999


@pytest.mark.slow
@pytest.mark.parametrize("response", EGM_RESPONSES, ids=SetpointResponse.describe)
def test_an_unknown_controller_is_found_and_keeps_nine_tenths_of_the_gain(
    response: SetpointResponse, irb4600: RobotDescription
) -> None:
    law, arm = elastic_feedforward(irb4600), RigidArm(irb4600)
    log, _ = stream(plan_probe(arm, np.random.default_rng(1), duration=2.0), irb4600, response)
    fit = identify_response([log], arm)
    assert fit.response.delay == pytest.approx(response.delay, abs=0.3e-3)
    for speed in (0.04, 0.1):
        none, torque = torque_channel(circles(speed), law)
        _, truth = stream(plan_setpoints(circles(speed), law, response=fit.response), irb4600, response, circles(speed))
        assert none - mean_error(truth) > 0.9 * (none - torque)


def test_a_log_in_which_nothing_moves_is_refused(one_axis: RobotDescription) -> None:
    probe = plan_probe(RigidArm(one_axis), np.random.default_rng(1), peak_speed=1e-6, duration=1.2)
    log, _ = stream(probe, one_axis, SetpointResponse(delay=0.0043))
    with pytest.raises(FFGymError, match=r"No set-point moves by more than 0.002 rad"):
        identify_response([log], RigidArm(one_axis))
    with pytest.raises(FFGymError, match=r"is of joints j1 of 'one_axis', robot 'irb4600_60_205' has j1, j2"):
        identify_response([log], RigidArm(load_robot("irb4600_60_205")))
    with pytest.raises(FFGymError, match="There are no recordings"):
        identify_response([], RigidArm(one_axis))


def test_the_file_of_a_controller_comes_back_and_mistakes_in_it_are_named(tmp_path) -> None:
    response, file = SetpointResponse.low_pass(20.0, delay=0.0093, damping=0.7), tmp_path / "controller.toml"
    write_controller(file, response, source="manual", intervals={"delay": (0.0092, 0.0094)})
    assert read_controller(file) == response
    file.write_text("[setpoints]\ndelay = 0.009\ncutoff = 20.0\n")
    with pytest.raises(FFGymError, match=r"controller.toml: Unknown entries of \[setpoints\]: cutoff"):
        read_controller(file)
    file.write_text("[setpoints]\ndelay = -1.0\n")
    with pytest.raises(FFGymError, match=r"delay of set-points = -1.0 s is out of range"):
        read_controller(file)
    file.write_text("delay = 0.009\n")
    with pytest.raises(FFGymError, match=r"There is no table \[setpoints\]"):
        read_controller(file)
