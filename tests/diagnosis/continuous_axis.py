"""One axis in continuous time, written anew: LuGre friction, a servo, a rigid load; by Runge and Kutta's fourth order.

Nothing of it is the library's engine, so that what that engine's steps do to a diagnosis shows.
"""

from dataclasses import dataclass
from functools import cache
from math import exp

import numpy as np

from ffgym.control import rigid_feedforward
from ffgym.paths import joint_reference, multisine
from ffgym.recordings import Header, Recording
from ffgym.robot import RigidArm

STEP = 5e-5
"""Of the integration [s]: a bristle at 75 rad/s relaxes within 0.1 ms."""


@dataclass(frozen=True, kw_only=True)
class Gains:
    """Of the controller: shares of the documented gains, and how far its set-points lead."""

    position: float = 1.0
    velocity: float = 1.0
    integral: float = 1.0
    lead: float = 0.0
    """[s]."""


@cache
def sines(robot, phase, duration=4.0):
    """A motion with reversals."""
    path = multisine([0.0], np.full((2, 1), 8.0), [0.4, 1.1], np.full((2, 1), phase), duration, name=f"sines {phase}")
    return joint_reference(robot, path)


@cache
def moved(robot, reference, gains):
    """Time [s], motor angle [rad], torque and feedback torque [N m] at every step."""
    servo, friction = robot.servo, robot.friction
    kp, kv, ki = (
        float(gain[0]) * share
        for gain, share in (
            (servo.position_gain, gains.position),
            (servo.velocity_gain, gains.velocity),
            (servo.integral_gain, gains.integral),
        )
    )
    fc, fs, fv, vs, s0, s1 = (
        float(x[0])
        for x in (
            friction.coulomb,
            friction.static,
            friction.viscous,
            friction.stribeck_velocity,
            friction.bristle_stiffness,
            friction.bristle_damping,
        )
    )
    inertia = float(robot.drive.rotor_inertia[0] + robot.bodies.inertia[0, 2])
    n, half, sixth = round(reference.duration / STEP), STEP / 2, STEP / 6
    t = half * np.arange(2 * n + 1)
    q_ref, v_ref = set_points(reference, t + gains.lead)
    ahead = np.interp(t + gains.lead, reference.t, rigid_feedforward(RigidArm(robot), reference)[:, 0])
    q_ref, v_ref, ahead = q_ref.tolist(), v_ref.tolist(), ahead.tolist()

    def change(k, q, v, z, e):
        off = q_ref[k] - q
        g = fc + (fs - fc) * exp(-((v / vs) ** 2))
        dz = v - s0 * abs(v) / g * z
        u_fb = kp * off + kv * (v_ref[k] - v) + ki * e
        return v, (u_fb + ahead[k] - s0 * z - s1 * dz - fv * v) / inertia, dz, off, u_fb

    q, v, z, e = q_ref[0], v_ref[0], 0.0, 0.0
    angle, torque, feedback = (np.empty(n + 1) for _ in range(3))
    for k in range(n + 1):
        q1, v1, z1, e1, u_fb = change(2 * k, q, v, z, e)
        angle[k], feedback[k], torque[k] = q, u_fb, u_fb + ahead[2 * k]
        if k == n:
            break
        # slopes twice in the middle of the step, and at its end
        q2, v2, z2, e2, _ = change(2 * k + 1, q + half * q1, v + half * v1, z + half * z1, e + half * e1)
        q3, v3, z3, e3, _ = change(2 * k + 1, q + half * q2, v + half * v2, z + half * z2, e + half * e2)
        q4, v4, z4, e4, _ = change(2 * k + 2, q + STEP * q3, v + STEP * v3, z + STEP * z3, e + STEP * e3)
        q += sixth * (q1 + 2 * q2 + 2 * q3 + q4)
        v += sixth * (v1 + 2 * v2 + 2 * v3 + v4)
        z += sixth * (z1 + 2 * z2 + 2 * z3 + z4)
        e += sixth * (e1 + 2 * e2 + 2 * e3 + e4)
    return t[::2], angle, torque, feedback


def recorded(robot, reference, gains=None, *, every=0.001, noise=None, rng=None, coloured=0.0, columns=()):
    """What such an axis records: angle and torque, and `columns` ('reference', 'feedback') beside them.

    Args:
        robot: of one rigid axis.
        reference: what its controller tracks.
        gains: of that controller; None is as documented.
        every: sample period [s].
        noise: standard deviations of angle [rad] and torque [N m]; None is none.
        rng: draws them.
        coloured: how much of the torque's noise stays from one sample to the next.
        columns: families beside angle and torque.
    """
    t, angle, torque, feedback = moved(robot, reference, gains or Gains())
    rows = slice(0, len(t), round(every / STEP))
    joint = robot.joints[0]
    found = {"timestamp": t[rows], f"motor.position.{joint}": angle[rows], f"motor.effort.{joint}": torque[rows]}
    if "reference" in columns:
        q, v = set_points(reference, t[rows])
        found |= {f"reference.position.{joint}": q, f"reference.velocity.{joint}": v}
    if "feedback" in columns:
        found[f"feedback.effort.{joint}"] = feedback[rows]
    if noise is not None:
        size = len(found["timestamp"])
        found[f"motor.position.{joint}"] = found[f"motor.position.{joint}"] + rng.normal(scale=noise[0], size=size)
        for family in ("motor.effort", "feedback.effort"):
            if f"{family}.{joint}" in found:
                found[f"{family}.{joint}"] = found[f"{family}.{joint}"] + red_noise(noise[1], coloured, size, rng)
    header = Header(
        robot=robot.name,
        joints=robot.joints,
        gear_ratio=tuple(robot.drive.gear_ratio.tolist()),
        joint_types=robot.kinematics.types,
        position_side="motor",
        torque_semantics="motor_side",
        hold="sampled",
        segment=reference.name,
    )
    return Recording(columns=found, header=header)


def set_points(reference, t):
    """Angle [rad] and speed of a reference at any times (T,), smooth between its samples."""
    from scipy.interpolate import CubicHermiteSpline

    curve = CubicHermiteSpline(reference.t, reference.q[:, 0], reference.dq[:, 0])
    t = np.clip(t, reference.t[0], reference.t[-1])
    return curve(t), curve(t, 1)


def red_noise(size, stays, n, rng):
    """Noise of standard deviation `size` of which a share `stays` from one sample to the next, (n,)."""
    white, found, now = rng.normal(size=n), np.empty(n), 0.0
    now = white[0]
    for k in range(n):
        now = stays * now + np.sqrt(1 - stays**2) * white[k] if k else now
        found[k] = now
    return size * found
