"""Servo and friction of each motor, as MuJoCo's own actuators in motor units."""

from dataclasses import dataclass

import mujoco
import numpy as np

from ffgym.robot.description import RobotDescription
from ffgym.robot.model.names import friction_actuator, motor_joint, motor_tendon, servo_actuator

_SERVO_INPUTS = mujoco.mjtCtrlInput.mjINPUT_POS | mujoco.mjtCtrlInput.mjINPUT_VEL | mujoco.mjtCtrlInput.mjINPUT_FF


def add_actuators(spec: mujoco.MjSpec, robot: RobotDescription, i: int, *, servo: bool, friction: bool) -> None:
    """Servo and friction of motor i, on its joint, or on a tendon if other joints turn the motor too."""
    if not (servo or friction):
        return
    joint, ratios = robot.joints[i], robot.drive.matrix[i]
    if np.any(np.delete(ratios, i)):
        tendon = spec.add_tendon(name=motor_tendon(joint))
        for j in np.flatnonzero(ratios):
            tendon.wrap_joint(motor_joint(robot.joints[j]), ratios[j])
        motor = _Transmission(kind=mujoco.mjtTrn.mjTRN_TENDON, target=motor_tendon(joint), gear=1.0)
    else:
        motor = _Transmission(kind=mujoco.mjtTrn.mjTRN_JOINT, target=motor_joint(joint), gear=float(ratios[i]))
    if servo:
        _add_servo(spec, robot, i, motor)
    if friction:
        _add_friction(spec, robot, i, motor)


@dataclass(frozen=True, kw_only=True)
class _Transmission:
    """What an actuator acts on, so that its length is the motor angle."""

    kind: mujoco.mjtTrn
    target: str
    gear: float


def _add_servo(spec: mujoco.MjSpec, robot: RobotDescription, i: int, motor: _Transmission) -> None:
    """PID with set-points for position, velocity and feed-forward torque; its integral is clamped."""
    servo, peak = robot.servo, robot.drive.peak_torque[i]
    integral_gain = servo.integral_gain[i]
    actuator = spec.add_actuator(
        name=servo_actuator(robot.joints[i]),
        trntype=motor.kind,
        target=motor.target,
        gear=[motor.gear, 0, 0, 0, 0, 0],
        armature=robot.drive.rotor_inertia[i],
        forcelimited=True,
        forcerange=[-peak, peak],
    )
    actuator.set_to_pid(
        kp=servo.position_gain[i],
        kv=servo.velocity_gain[i],
        ki=integral_gain,
        imax=peak / integral_gain if integral_gain > 0 else 0.0,
        ctrlspec=int(_SERVO_INPUTS),
    )


def _add_friction(spec: mujoco.MjSpec, robot: RobotDescription, i: int, motor: _Transmission) -> None:
    """LuGre friction of motor i: a motor without electrics, whose bristles MuJoCo integrates exactly."""
    f = robot.friction
    actuator = spec.add_actuator(
        name=friction_actuator(robot.joints[i]),
        trntype=motor.kind,
        target=motor.target,
        gear=[motor.gear, 0, 0, 0, 0, 0],
        damping=[f.viscous[i], 0, 0],
    )
    actuator.set_to_dcmotor(
        motorconst=[0, 0],
        resistance=1.0,  # must be positive, acts on nothing: the electrical branch is off
        lugre=[f.bristle_stiffness[i], f.bristle_damping[i], f.coulomb[i], f.static[i], f.stribeck_velocity[i]],
        ctrlspec=int(mujoco.mjtCtrlInput.mjINPUT_NONE),
    )
