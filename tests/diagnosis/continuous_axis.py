"""One axis in continuous time, written anew: LuGre friction, a servo, a rigid load; by Runge and Kutta's fourth order.

Nothing of it is the library's engine, so that what that engine's steps do to a diagnosis shows.
"""

from dataclasses import dataclass
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


def sines(robot, phase, duration=4.0):
    """A motion with reversals."""
    path = multisine([0.0], np.full((2, 1), 8.0), [0.4, 1.1], np.full((2, 1), phase), duration, name=f"sines {phase}")
    return joint_reference(robot, path)


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
    gains = gains or Gains()
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
    n, half = round(reference.duration / STEP), STEP / 2
    t = half * np.arange(2 * n + 1)
    q_ref, v_ref = set_points(reference, t + gains.lead)
    ahead = np.interp(t + gains.lead, reference.t, rigid_feedforward(RigidArm(robot), reference)[:, 0])
    q_ref, v_ref, ahead = q_ref.tolist(), v_ref.tolist(), ahead.tolist()

    def change(k, state):
        q, v, z, e = state
        g = fc + (fs - fc) * exp(-((v / vs) ** 2))
        dz = v - s0 * abs(v) / g * z
        u_fb = kp * (q_ref[k] - q) + kv * (v_ref[k] - v) + ki * e
        return (v, (u_fb + ahead[k] - s0 * z - s1 * dz - fv * v) / inertia, dz, q_ref[k] - q), u_fb

    state = (q_ref[0], v_ref[0], 0.0, 0.0)
    angle, torque, feedback = (np.empty(n + 1) for _ in range(3))
    for k in range(n + 1):
        k1, u_fb = change(2 * k, state)
        angle[k], feedback[k], torque[k] = state[0], u_fb, u_fb + ahead[2 * k]
        if k == n:
            break
        k2, _ = change(2 * k + 1, tuple(x + half * d for x, d in zip(state, k1, strict=True)))
        k3, _ = change(2 * k + 1, tuple(x + half * d for x, d in zip(state, k2, strict=True)))
        k4, _ = change(2 * k + 2, tuple(x + STEP * d for x, d in zip(state, k3, strict=True)))
        state = tuple(
            x + STEP / 6 * (a + 2 * b + 2 * c + d) for x, a, b, c, d in zip(state, k1, k2, k3, k4, strict=True)
        )
    stride = round(every / STEP)
    rows = slice(0, n + 1, stride)
    joint = robot.joints[0]
    found = {"timestamp": t[::2][rows], f"motor.position.{joint}": angle[rows], f"motor.effort.{joint}": torque[rows]}
    if "reference" in columns:
        q, v = set_points(reference, t[::2][rows])
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
