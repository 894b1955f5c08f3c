"""What a streamed correction keeps of a law's gain, behind delay and filter of an emulated controller."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym import elastic_feedforward
from ffgym.control import SetpointChannel, SetpointResponse, rigid_feedforward
from ffgym.deployment import SetpointPlan
from ffgym.deployment.streams import EgmWire, Envelope, JointAxes, RsiWire, StreamSession, Wire
from ffgym.deployment.streams.emulators import EmulatedController, EmulatedRobot, run_in_lock_step
from ffgym.paths import Reference, cartesian_reference, circle_test
from ffgym.recordings.metrics import path_errors
from ffgym.robot import RigidArm, RobotDescription

RESPONSES = [
    SetpointResponse(delay=0.004),
    SetpointResponse.low_pass(20.0, delay=0.0093),
    SetpointResponse.low_pass(20.0, delay=0.0297, damping=0.71),
]


@pytest.fixture(scope="module", params=[0.04, 0.1], ids=["40 mm/s", "100 mm/s"])
def circle(request, irb4600: RobotDescription, arm: RigidArm) -> Reference:
    path = circle_test(irb4600.position("p1"), request.param, radii=[0.003], normal=irb4600.work_area.normal, dt=0.004)
    return cartesian_reference(arm, path)


def stream(
    wire: Wire, circle: Reference, planned: np.ndarray, correction: np.ndarray, response, envelope, arm, **options
) -> float:
    """Stream a correction to an emulated robot; returns the RMS path error [m]."""
    robot = circle.robot
    plan = SetpointPlan(
        name=circle.name,
        robot=robot.name,
        law="elastic",
        joints=robot.joints,
        units=robot.kinematics.units,
        dt=0.004,
        program=planned,
        correction=correction,
        torque=np.zeros_like(correction),
    )
    session = StreamSession(plan, wire, envelope, robot.drive)
    assert session.cut_share == 0.0
    emulated = EmulatedRobot(robot, planned[0], cycle=wire.cycle, response=response, arm=arm, **options)
    run_in_lock_step(session, EmulatedController(emulated, wire))
    return path_errors(emulated.truth("circle", circle))[0].rms


@pytest.fixture(scope="module")
def wide(envelope: Envelope) -> Envelope:
    """Envelope of corrections that stand for rigid torques, too."""
    limits = replace(envelope.correction, size=np.full(6, 5e-3), rate=np.full(6, 0.5), acceleration=np.full(6, 100.0))
    return replace(envelope, correction=limits)


@pytest.mark.parametrize("response", RESPONSES, ids=SetpointResponse.describe)
def test_corrections_of_a_program_that_the_controller_runs_keep_97_percent(
    response: SetpointResponse, circle: Reference, axes: JointAxes, wide: Envelope, arm: RigidArm
) -> None:
    # the correction alone is late: it is sent early
    robot, law = circle.robot, elastic_feedforward(circle.robot)
    sent = robot.drive.joint_angle(SetpointChannel(response=response).send(robot.servo, law.torque(circle)))
    without, kept = (
        stream(
            RsiWire(axes), circle, circle.q, share * sent, response, wide, arm, program=circle.q, feedforward="program"
        )
        for share in (0.0, 1.0)
    )
    assert kept < 0.03 * without


@pytest.mark.parametrize("response", RESPONSES[1:], ids=SetpointResponse.describe)
def test_whole_setpoints_keep_97_percent_with_their_filter_undone(
    response: SetpointResponse, circle: Reference, axes: JointAxes, wide: Envelope, arm: RigidArm
) -> None:
    # program and correction are late together: their filter is undone, their delay is none; the controller computes no
    # feed-forward, so that the correction stands for the rigid torque, too
    robot, law, filtered = circle.robot, elastic_feedforward(circle.robot), replace(response, delay=0.0)
    channel, rigid = SetpointChannel(response=filtered), rigid_feedforward(arm, circle)
    program = filtered.invert(circle.q, 0.004)
    without, kept = (
        stream(
            EgmWire(axes),
            circle,
            program,
            robot.drive.joint_angle(channel.send(robot.servo, torque)),
            response,
            wide,
            arm,
            feedforward="none",
        )
        for torque in (rigid, rigid + law.torque(circle))
    )
    assert kept < 0.03 * without
