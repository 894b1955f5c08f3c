"""LuGre friction in MuJoCo: passive `dcmotor` actuators with bristles, on motors and behind the elasticity."""

from typing import Any

import mujoco
import numpy as np

from ffgym.robot.description import RobotDescription
from ffgym.robot.model.names import (
    arm_friction_actuator,
    deflection_joint,
    friction_actuator,
    link_tendon,
    motor_joint,
    servo_actuator,
)


def add_friction(
    spec: mujoco.MjSpec, robot: RobotDescription, i: int, motor: dict[str, Any], *, flexible: bool
) -> None:
    """Add the friction of joint i on its motor, and its share of the arm on the link's angle in units of the motor's.

    Args:
        spec: model.
        robot: the description.
        i: which joint.
        motor: what the friction of the motor acts on, so that its length is the motor angle.
        flexible: if joints have their elasticity; without, all friction is on motors.
    """
    joint, share = robot.joints[i], robot.arm_share[i] if flexible else 0.0
    if share < 1:
        _add_bristles(spec, robot, i, friction_actuator(joint), 1 - share, motor)
    if share > 0:
        tendon = spec.add_tendon(name=link_tendon(joint))
        for hinge in (motor_joint(joint), deflection_joint(joint)):
            tendon.wrap_joint(hinge, robot.drive.gear_ratio[i])
        link = {"trntype": mujoco.mjtTrn.mjTRN_TENDON, "target": tendon.name, "gear": [1.0, 0, 0, 0, 0, 0]}
        _add_bristles(spec, robot, i, arm_friction_actuator(joint), share, link)


def _add_bristles(
    spec: mujoco.MjSpec, robot: RobotDescription, i: int, name: str, share: float, at: dict[str, Any]
) -> None:
    """Add a share of the LuGre friction of joint i: a motor without electrics, with bristles that MuJoCo integrates.

    Bristles stay the same where all torques shrink alike, as their steady deflection is a quotient of two of them.
    """
    f = robot.friction
    friction = spec.add_actuator(name=name, damping=[share * f.viscous[i], 0, 0], **at)
    torques = (f.bristle_stiffness[i], f.bristle_damping[i], f.coulomb[i], f.static[i])
    friction.set_to_dcmotor(
        motorconst=[0, 0],
        resistance=1.0,  # must be positive, acts on nothing: the electrical branch is off
        lugre=[*(share * torque for torque in torques), f.stribeck_velocity[i]],
        ctrlspec=int(mujoco.mjtCtrlInput.mjINPUT_NONE),
    )


def bear_arm_friction(spec: mujoco.MjSpec, robot: RobotDescription) -> None:
    r"""Give deflections the inertia that light links lack for stable steps of the friction that acts on them.

    MuJoCo takes friction at the speed before a step h. It brakes by up to :math:`d = s n^2 (2 \sigma_1 + f_v)` per
    speed of the link, as bristles that are still bent the other way double their damping, and the step is stable if
    :math:`h d \le 2 I` for a link of inertia I. What I lacks is added to that of the deflection alone: this part of the
    friction is then implicit in the deflection's speed, as the damping of joints is in MuJoCo. Rotor and link together
    weigh what they did; nothing is added where the step is short enough.

    The inertia I is that of the link against the one before, with all joints free and at 0: a stretched arm, whose
    wrist has least. A model without servos has no rotors, and is left as it is.
    """
    joints = [i for i in np.flatnonzero(robot.arm_share).tolist() if _has_both_sides(spec, robot.joints[i])]
    if not joints:
        return
    deflections = [spec.joint(deflection_joint(robot.joints[i])) for i in joints]
    for deflection in deflections:
        deflection.armature = 0.0
    model, friction, ratio = spec.compile(), robot.friction, robot.drive.gear_ratio
    slope = robot.arm_share * ratio**2 * (2 * friction.bristle_damping + friction.viscous)
    for i, deflection in zip(joints, deflections, strict=True):
        inertia = ratio[i] ** 2 / model.tendon_invweight0[model.tendon(link_tendon(robot.joints[i])).id]
        deflection.armature = max(0.0, 0.5 * model.opt.timestep * slope[i] - inertia)


def _has_both_sides(spec: mujoco.MjSpec, joint: str) -> bool:
    """Tell whether a model has friction on the link of a joint, and its motor."""
    return spec.actuator(arm_friction_actuator(joint)) is not None and spec.actuator(servo_actuator(joint)) is not None
