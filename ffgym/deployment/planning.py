"""Plan of set-points for a motion under a feed-forward law: what to send so that servos give the law's torque."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal, get_args

import numpy as np

from ffgym.control import (
    CorrectionLimits,
    FeedForwardLaw,
    NoCompensation,
    SetpointResponse,
    invert_servo,
    limit_correction,
    rigid_feedforward,
)
from ffgym.core.errors import check_choice
from ffgym.core.types import Array
from ffgym.core.version import __version__
from ffgym.deployment.plan import SetpointPlan
from ffgym.paths import Reference, joint_reference, random_multisine
from ffgym.robot import RigidArm

Sends = Literal["positions", "corrections"]
"""What is sent: whole set-points, with which the controller computes its own feed-forward; or what is added to the
set-points of a program that the controller runs by itself."""

FeedForward = Literal["setpoints", "program", "none"]
"""What a controller computes its rigid feed-forward from: set-points with their corrections, its own program alone, or
nothing."""


def plan_setpoints(
    reference: Reference,
    law: FeedForwardLaw,
    *,
    arm: RigidArm | None = None,
    response: SetpointResponse | None = None,
    sends: Sends = "positions",
    feedforward: FeedForward = "setpoints",
    limits: CorrectionLimits | None = None,
    meta: Mapping[str, Any] | None = None,
) -> SetpointPlan:
    """Plan the set-points of a motion.

    Whole set-points all arrive late by the delay of the controller: the motion is late, and the path the same, so that
    the filter alone is compensated, and that for the whole motion. Corrections of a program meet a motion that is not
    late, and are sent early by the delay.

    Args:
        reference: the program.
        law: law whose torque the servos shall give.
        arm: rigid dynamics of the controller; None takes those of the reference's robot.
        response: delay and filter of the controller; None is none.
        sends: what is sent.
        feedforward: what the controller computes its rigid feed-forward from.
        limits: limits of the correction, link side; None is none.
        meta: where the plan comes from.

    Raises:
        FFGymError: if the servo is not documented with positive gains, or the law does not fit.
    """
    check_choice("kind of set-points", sends, get_args(Sends))
    check_choice("feed-forward of a controller", feedforward, get_args(FeedForward))
    robot, arm, response = reference.robot, arm or RigidArm(reference.robot), response or SetpointResponse()
    torque = law.torques_along([reference])[0]
    torque = np.concatenate([np.zeros_like(torque[:1]), torque[1:]])  # which begins in equilibrium
    dt, drive = robot.servo.control_dt, robot.drive
    # what the servo and the controller's own feed-forward make of corrections
    given = torque if feedforward != "none" else torque + rigid_feedforward(arm, reference)
    inertia = motor_inertia(arm, reference.q) if feedforward == "setpoints" else None
    wanted = invert_servo(robot.servo, given, inertia)
    if sends == "positions":
        sent = replace(response, delay=0.0).invert(reference.motor_q + wanted, dt) - reference.motor_q
    else:
        sent = response.invert(wanted, dt)
    correction = drive.joint_angle(sent - sent[0])
    notes: dict[str, Any] = {
        "beyond_limits": {},
        "ffgym": __version__,
        "sends": sends,
        "feedforward": feedforward,
        "response": response.describe(),
    }
    if limits is not None:
        excess = limits.find_excess(correction, dt)
        notes["beyond_limits"] = {name: share.tolist() for name, share in excess.items() if share.any()}
        correction = limit_correction(limits, correction, dt)
    return SetpointPlan(
        name=reference.name,
        robot=robot.name,
        law=law.name,
        joints=robot.joints,
        units=robot.kinematics.units,
        dt=dt,
        program=reference.q,
        correction=correction,
        torque=torque,
        meta=notes | dict(meta or {}),
    )


PROBED = (0.5, 15.0)
"""Frequencies of the motion that shows delay and filter [Hz]: a filter and a delay differ from some Hz on only."""


def plan_probe(
    arm: RigidArm, rng: np.random.Generator, *, peak_speed: float = 0.15, duration: float = 4.0
) -> SetpointPlan:
    """Plan a motion without correction that shows delay and filter of a controller: random sines on every joint.

    Args:
        arm: rigid dynamics of the robot; it moves about the home pose of the work area, or the middle of the ranges.
        rng: randomness.
        peak_speed: largest joint speed, link side [rad/s or m/s].
        duration: time of the motion [s].

    Raises:
        FFGymError: if a joint would go beyond its limits, or the duration is too short.
    """
    robot = arm.robot
    low, high = np.clip(robot.kinematics.range, -np.pi, np.pi).T
    centre = (low + high) / 2 if robot.work_area is None else np.asarray(robot.work_area.home, dtype=np.float64)
    speed = np.minimum(peak_speed, robot.kinematics.max_speed)
    path = random_multisine(
        rng,
        centre,
        speed,
        duration,
        n_sines=8,
        frequencies=PROBED,
        dt=robot.servo.control_dt,
        name="delay and filter",
    )
    return plan_setpoints(joint_reference(robot, path), NoCompensation(), arm=arm)


def motor_inertia(arm: RigidArm, q: Array) -> Array:
    r"""Compute the inertia that motors feel, motor side [kg m^2], shape (T, N, N): :math:`G^{-T} M G^{-1} + J_m`."""
    drive = arm.robot.drive
    return drive.inverse.T @ arm.mass_matrix(q) @ drive.inverse + np.diag(drive.rotor_inertia)
