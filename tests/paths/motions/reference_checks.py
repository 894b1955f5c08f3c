"""What holds of every reference that is made from moves."""

from itertools import pairwise

import numpy as np
import pytest
from programs import DT

from ffgym.paths.limits import MotionLimits


def tool_speed(arm, reference):
    twist = np.einsum("tij,tj->ti", arm.jacobian(reference.q), reference.dq)
    return np.linalg.norm(twist[:, :3], axis=1), np.linalg.norm(twist[:, 3:], axis=1)


def rows_of(reference, phase):
    return (reference.t >= phase.start) & (reference.t < phase.end)


def check_reference(reference, limits=None):
    """Continuous in position, speed and acceleration, at rest at both ends, phases without a gap, limits kept."""
    kinematics = reference.robot.kinematics
    axes = (limits or MotionLimits()).of_joints(kinematics.max_speed)
    q, dq, ddq = reference.q, reference.dq, reference.ddq
    assert np.all(np.abs(dq) <= axes.speed)
    assert np.all(np.abs(ddq) <= axes.acceleration)
    assert np.all(np.abs(np.diff(ddq, axis=0)) <= axes.jerk * DT + 1e-6)
    hermite = q[:-1] + DT / 2 * (dq[:-1] + dq[1:]) + DT**2 / 12 * (ddq[:-1] - ddq[1:])
    np.testing.assert_allclose(q[1:], hermite, atol=2 * axes.jerk.max() * DT**3 / 24 + 1e-8)
    np.testing.assert_allclose(dq[1:], dq[:-1] + DT / 2 * (ddq[:-1] + ddq[1:]), atol=axes.jerk.max() * DT**2 / 4 + 1e-7)
    np.testing.assert_array_equal(dq[[0, -1]], 0)
    assert reference.phases[0].start == 0
    assert reference.phases[-1].end == pytest.approx(reference.t[-1])
    for before, after in pairwise(reference.phases):
        assert before.end == pytest.approx(after.start, abs=1e-9)
