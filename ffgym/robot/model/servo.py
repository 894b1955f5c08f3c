"""The servo of a motor in MuJoCo, with the torque loop of its drive: `pid`, or `dcmotor` where torque lags its command.

In a `dcmotor` the current lags the voltage by L / R, and its rate may be limited. A motor of torque constant
`MOTOR_CONSTANT` and resistance `RESISTANCE` is a torque loop: voltage over resistance is the command, current the
torque in N m. MuJoCo's controller compensates the back EMF, but for the 1e-9 N m that it takes off a limited voltage.
"""

from typing import Any

import mujoco
import numpy as np

from ffgym.robot.description import RobotDescription
from ffgym.robot.model.names import servo_actuator

MOTOR_CONSTANT = 1.0
"""Torque per current [N m/A] and back EMF per speed [V s/rad] of the motor that is a torque loop."""
RESISTANCE = 1e12
"""Its resistance [Ohm]: at the voltage limit, 1000 rad/s take 1e-9 N m off the peak torque."""
SHORTEST_LAG = 1 / 50
"""Lag of a loop without one whose rate is limited, in physics steps: exp(-50) of a step is left after it."""

_INPUTS = int(mujoco.mjtCtrlInput.mjINPUT_POS | mujoco.mjtCtrlInput.mjINPUT_VEL | mujoco.mjtCtrlInput.mjINPUT_FF)


def add_servo(spec: mujoco.MjSpec, robot: RobotDescription, i: int, motor: dict[str, Any]) -> None:
    """Add the PID servo of motor i: set-points for position and speed, feed-forward torque; its integral is clamped.

    Args:
        spec: model, whose time step is set.
        robot: the description.
        i: which motor.
        motor: what the actuator acts on, so that its length is the motor angle.
    """
    drive, servo = robot.drive, robot.servo
    peak, ki = drive.peak_torque[i], servo.integral_gain[i]
    most = peak / ki if ki > 0 else 0.0
    actuator = spec.add_actuator(name=servo_actuator(robot.joints[i]), armature=drive.rotor_inertia[i], **motor)
    if not drive.has_torque_loop[i]:
        actuator.forcelimited, actuator.forcerange = True, [-peak, peak]
        actuator.set_to_pid(kp=servo.position_gain[i], kv=servo.velocity_gain[i], ki=ki, imax=most, ctrlspec=_INPUTS)
        return
    lag, rate = drive.loop_lag[i], drive.loop_rate[i]
    dt = spec.option.timestep
    lag = max(lag, SHORTEST_LAG * dt)
    # MuJoCo limits the rate at the start of a step and lets it decay: a step adds limit T_c (1 - exp(-dt / T_c))
    limit = rate * dt / (-lag * np.expm1(-dt / lag)) if np.isfinite(rate) else 0.0
    actuator.set_to_dcmotor(
        motorconst=[MOTOR_CONSTANT, MOTOR_CONSTANT],
        resistance=RESISTANCE,
        inductance=[0.0, lag],
        saturation=[peak, 0.0, limit],
        controller=[servo.position_gain[i], ki, servo.velocity_gain[i], 0.0, most, RESISTANCE * peak],
        ctrlspec=_INPUTS,
    )
