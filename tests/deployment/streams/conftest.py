"""Plans and envelopes that tests of streams share."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.control import CorrectionLimits
from ffgym.deployment import SetpointPlan
from ffgym.deployment.streams import Envelope, JointAxes
from ffgym.robot import RobotDescription


@pytest.fixture(scope="session")
def axes(irb4600: RobotDescription) -> JointAxes:
    """Joints of the six-axis robot, as packets have them."""
    low, high = irb4600.kinematics.range.T
    return JointAxes(names=irb4600.joints, units=irb4600.kinematics.units, low=low, high=high)


@pytest.fixture(scope="session")
def envelope(irb4600: RobotDescription) -> Envelope:
    """Envelope that the shared plans keep."""
    limits = CorrectionLimits.even(6, size=2e-3, rate=0.05, acceleration=5.0)
    return Envelope(correction=limits, torque=irb4600.drive.peak_torque)


@pytest.fixture(scope="session")
def wave(irb4600: RobotDescription) -> SetpointPlan:
    """Two seconds of motion of all joints from the home pose and back, with a correction."""
    t = np.arange(501) * 0.004
    home = np.asarray(irb4600.work_area.home)
    return SetpointPlan(
        name="wave",
        robot=irb4600.name,
        law="made up",
        joints=irb4600.joints,
        units=irb4600.kinematics.units,
        dt=0.004,
        program=home + 0.02 * np.outer(1 - np.cos(np.pi * t), np.ones(6)),
        correction=1e-3 * np.outer(np.sin(np.pi * t) ** 2, [1, -1, 0.5, 1, -1, 0.5]),
        torque=np.outer(np.sin(np.pi * t) ** 2, [1, -1, 0.5, 1, -1, 0.5]),
    )


@pytest.fixture(scope="session")
def brief(wave: SetpointPlan) -> SetpointPlan:
    """The first part of the wave, for what runs in real time."""
    return replace(wave, **{part: getattr(wave, part)[:151] for part in ("program", "correction", "torque")})
