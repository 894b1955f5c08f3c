"""Parts of emulators by themselves: the network, the controller's patience, and the reference of its servo."""

import numpy as np
import pytest
from stream_samples import FollowingRobot

from ffgym.control import SetpointResponse
from ffgym.deployment.streams import EgmWire, JointAxes, StreamCommand
from ffgym.deployment.streams.emulators import EmulatedController, Faults
from ffgym.deployment.streams.emulators.network import FaultyNetwork
from ffgym.deployment.streams.emulators.reference import ControllerReference
from ffgym.robot import RobotDescription

CYCLE, STEP = 0.004, 0.001


def arrivals(**faults: float) -> list[list[float]]:
    """Delays of what arrives of each of 2000 packets."""
    network = FaultyNetwork(Faults(**faults))
    return [[arrival - 1.0 for arrival, _ in network.carry(b"packet", 1.0)] for _ in range(2000)]


def test_faults_happen_as_often_and_as_much_as_they_are_said_to() -> None:
    assert arrivals() == [[0.0]] * 2000
    assert 0.2 < np.mean([not delays for delays in arrivals(drop=0.25)]) < 0.3
    twice = [len(delays) for delays in arrivals(duplicate=0.25)]
    assert set(twice) == {1, 2}
    assert 1.2 < np.mean(twice) < 1.3
    late = np.ravel(arrivals(late=0.5, lateness=0.02, latency=0.001))
    assert np.isclose(late, 0.001).mean() == pytest.approx(0.5, abs=0.05)
    assert 0.019 < late.max() <= 0.021
    jitter = np.ravel(arrivals(jitter=0.003))
    assert jitter.min() < 1e-4 < 0.0029 < jitter.max() <= 0.003 + 1e-12


def test_a_controller_stops_after_a_second_without_setpoints(axes: JointAxes, irb4600: RobotDescription) -> None:
    wire, start = EgmWire(axes), np.asarray(irb4600.work_area.home)
    controller = EmulatedController(FollowingRobot(irb4600, start, CYCLE), wire)
    none = np.zeros(6)
    command = StreamCommand(sequence=1, time=0.0, position=start, correction=none, velocity=none, effort=none)
    controller.receive(wire.encode_command(command))
    cycles = 0
    while wire.decode_feedback(controller.feedback()).ready:
        controller.advance()
        cycles += 1
    assert cycles * CYCLE == pytest.approx(1.0, abs=2.5 * CYCLE)


def make_reference(robot: RobotDescription, missing: str) -> ControllerReference:
    response = SetpointResponse(delay=CYCLE)
    return ControllerReference(robot.drive, np.zeros(6), cycle=CYCLE, step=STEP, response=response, missing=missing)


@pytest.mark.parametrize(("missing", "further"), [("hold", 0.0), ("extrapolate", 0.01)])
def test_a_setpoint_that_is_missing_is_held_or_extrapolated(
    missing: str, further: float, irb4600: RobotDescription
) -> None:
    reference = make_reference(irb4600, missing)
    for k in range(5):
        reference.advance(np.full(6, 0.01 * k), runs=True)
    for _ in range(2):
        reference.advance(None, runs=True)
    reached = irb4600.drive.joint_angle(reference.position[-1])
    assert np.allclose(reached, 0.04 + 2 * further)


def test_the_acceleration_of_setpoints_is_that_of_their_curve(irb4600: RobotDescription) -> None:
    """For a cubic it is linear in time, and exact where it is extrapolated to the newest set-point."""
    reference = make_reference(irb4600, "hold")
    for k in range(12):
        reference.advance(np.full(6, (k * CYCLE) ** 3), runs=True)
    assert np.allclose(reference.change, 6 * 11 * CYCLE)
