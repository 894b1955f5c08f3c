"""What a tracker sees in place of the tool."""

import numpy as np
import pytest

from ffgym.effects import EFFECTS
from ffgym.paths import joint_reference, multisine
from ffgym.robot import RigidArm
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine


@pytest.fixture(scope="module")
def exact(irb4600, corners):
    swing = multisine(corners["p1"], np.full((1, 6), 0.02), [2.0], np.zeros((1, 6)), 0.4, ramp=0.1, dwell=0.1)
    return simulate([Run(reference=joint_reference(irb4600, swing))], n_threads=1)[0]


def seen(robot, exact, name, **values):
    """The recording with one effect, and how far the tool is seen from where it is [m], (T, 3)."""
    recording = Machine(robot=robot, effects=(EFFECTS[name].on(robot, **values),)).seen(exact)
    changed = {c for c in recording.columns if not np.array_equal(recording[c], exact[c])}
    assert changed <= {"tcp.position.x", "tcp.position.y", "tcp.position.z"}
    return recording, recording.vector("tcp.position") - exact.vector("tcp.position")


def test_a_misplaced_reflector_turns_with_the_flange(irb4600, exact):
    offset = np.array([1e-3, -2e-3, 0.5e-3])
    _, error = seen(irb4600, exact, "tool_frame", offset=offset)
    np.testing.assert_allclose(np.linalg.norm(error, axis=1), np.linalg.norm(offset), rtol=1e-9)
    _, rotation = RigidArm(irb4600).tcp_pose(exact.joint_array("link.position"))
    np.testing.assert_allclose(np.einsum("tji,tj->ti", rotation, error), np.tile(offset, (len(error), 1)), atol=1e-12)


def test_a_tracker_with_another_scale_stretches_distances_and_nothing_else_does(irb4600, exact):
    truth = exact.vector("tcp.position")
    for scale in (0.0, 1e-4):
        recording, _ = seen(
            irb4600, exact, "tracker_frame", shift=np.full(3, 1e-3), turn=np.array([1e-3, 0, -1e-3]), scale=scale
        )
        measured = recording.vector("tcp.position")
        ratio = np.linalg.norm(measured[300] - measured[200]) / np.linalg.norm(truth[300] - truth[200])
        assert ratio == pytest.approx(1 + scale, abs=1e-12)


def test_latency_in_whole_samples_is_an_exact_shift(irb4600, exact):
    recording, _ = seen(irb4600, exact, "tracker_clock", latency=3e-3, drift=0.0)
    np.testing.assert_allclose(recording["tcp.position.x"][3:], exact["tcp.position.x"][:-3], atol=1e-12)
    np.testing.assert_allclose(recording["tcp.position.x"][:3], exact["tcp.position.x"][0], atol=1e-12)


@pytest.mark.parametrize(("name", "column"), [("torque_clock", "motor.effort.j2"), ("link_clock", "link.position.j2")])
def test_a_late_column_is_shifted_and_nothing_else_is(name, column, irb4600, exact):
    machine = Machine(robot=irb4600, effects=(EFFECTS[name].on(irb4600, latency=3e-3),))
    recording = machine.seen(exact)
    np.testing.assert_allclose(recording[column][3:], exact[column][:-3], atol=1e-12)
    np.testing.assert_allclose(recording[column][:3], exact[column][0], atol=1e-12)
    changed = {c for c in exact.columns if not np.array_equal(recording[c], exact[c])}
    assert {c.rpartition(".")[0] for c in changed} == set(EFFECTS[name].families)


def test_a_column_that_is_not_there_cannot_be_late(irb4600, exact):
    few = {c: values for c, values in exact.columns.items() if not c.startswith("link.")}
    recording = type(exact)(few, exact.header)
    assert EFFECTS["link_clock"].on(irb4600, latency=3e-3).measure(recording, irb4600).equals(recording)


def test_a_slow_clock_is_late_by_more_and_more(irb4600, exact):
    _, error = seen(irb4600, exact, "tracker_clock", latency=0.0, drift=1e-4)
    speed = np.gradient(exact.vector("tcp.position"), exact.t, axis=0)
    np.testing.assert_allclose(error, -1e-4 * exact.t[:, None] * speed, atol=2e-7)


def test_joint_zeros_show_through_the_jacobian(irb4600, exact):
    zero = np.array([1e-5, -1e-5, 2e-5, 0, 1e-5, 0])
    _, error = seen(irb4600, exact, "joint_zeros", zero=zero, stretch=0.0)
    jacobian = RigidArm(irb4600).jacobian(exact.joint_array("link.position"))[:, :3]
    np.testing.assert_allclose(error, jacobian @ zero, atol=1e-8)


def test_a_longer_upper_arm_moves_the_tool_along_it(irb4600, exact):
    _, error = seen(irb4600, exact, "joint_zeros", zero=0.0, stretch=np.array([0, 0, 1e-3, 0, 0, 0]))
    length = np.linalg.norm(irb4600.kinematics.position[2])
    np.testing.assert_allclose(np.linalg.norm(error, axis=1), 1e-3 * length, rtol=1e-6)
