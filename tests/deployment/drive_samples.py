"""Robots whose servo is another than documented, and what a logger of their drives records under a stream."""

from dataclasses import replace

import numpy as np

from ffgym.control import CorrectionLimits, SetpointResponse
from ffgym.deployment import (
    EgmWire,
    EmulatedController,
    EmulatedRobot,
    Envelope,
    SetpointPlan,
    StreamSession,
    axes_of,
    plan_probe,
    record_drive,
    run_in_lock_step,
)
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription

RESPONSE = SetpointResponse.low_pass(20.0, delay=0.0117)
FACTORS = {"position_gain": 1.4, "velocity_gain": 0.8, "integral_gain": 1.3}
"""Gains of the real servo in those of the description."""


def with_other_gains(robot: RobotDescription) -> RobotDescription:
    """Return the real robot: other gains, and friction that is a third off."""
    servo = replace(robot.servo, **{name: factor * getattr(robot.servo, name) for name, factor in FACTORS.items()})
    friction = robot.friction
    more = replace(friction, coulomb=1.3 * friction.coulomb, static=1.3 * friction.static)
    return replace(robot, servo=servo, friction=more)


def probe(robot: RobotDescription, duration: float) -> SetpointPlan:
    """Plan the motion that shows a controller."""
    return plan_probe(RigidArm(robot), np.random.default_rng(1), duration=duration)


def log_of_drive(plan: SetpointPlan, real: RobotDescription, documented: RobotDescription) -> Recording:
    """Stream a plan to the real robot, and record set-points, angles and torque."""
    return run_stream(plan, real, documented)[0]


def run_stream(
    plan: SetpointPlan, real: RobotDescription, documented: RobotDescription
) -> tuple[Recording, EmulatedRobot]:
    """Stream a plan to the real robot; returns the log of its drives, and the robot."""
    wire = EgmWire(axes_of(documented))
    emulated = EmulatedRobot(real, plan.program[0], cycle=wire.cycle, response=RESPONSE)
    limits = CorrectionLimits.even(documented.n_joints, size=0.2, rate=50.0, acceleration=5e3)
    envelope = Envelope(correction=limits, torque=documented.drive.peak_torque)
    session = StreamSession(plan, wire, envelope, documented.drive)
    controller = EmulatedController(emulated, wire)
    run_in_lock_step(session, controller)
    return record_drive(session, controller), emulated
