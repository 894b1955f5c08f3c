"""Motions of the tool that an arm can make for sure, because its joints made them."""

import numpy as np

from ffgym.paths import CartesianPath
from ffgym.recordings import Phase

DT = 0.004


def joint_motion(home, spread=0.1, duration=2.0, seed=0):
    """Smooth motion of all joints from `home` and back to it: times (T,), q, dq and ddq (T, N)."""
    t = DT * np.arange(round(duration / DT) + 1)
    turns = np.random.default_rng(seed).uniform(-spread, spread, (2, len(home)))
    q, dq, ddq = np.zeros((3, len(t), len(home)))
    for k, amplitude in enumerate(turns, start=1):
        omega = 2 * np.pi * k / duration
        q += amplitude * (1 - np.cos(omega * t))[:, None]
        dq += amplitude * omega * np.sin(omega * t)[:, None]
        ddq += amplitude * omega**2 * np.cos(omega * t)[:, None]
    return t, home + q, dq, ddq


def tool_path(arm, motion, *, turning):
    """Path of the tool during a motion of the joints, with its orientation or without."""
    t, q, dq, ddq = motion
    position, rotation = arm.tcp_pose(q)
    jacobian = arm.jacobian(q)
    twist = np.einsum("tij,tj->ti", jacobian, dq)
    change = np.einsum("tij,tj->ti", jacobian, ddq) + arm.bias_acceleration(q, dq)
    turned = {"rotation": rotation, "angular_velocity": twist[:, 3:], "angular_acceleration": change[:, 3:]}
    return CartesianPath(
        name="made by joints",
        t=t,
        position=position,
        velocity=twist[:, :3],
        acceleration=change[:, :3],
        phases=(Phase(label="all", kind="motion", start=0.0, end=float(t[-1])),),
        **(turned if turning else {}),
    )


def slope(values, dt=DT):
    """Time derivative of samples (T, N) in the inner samples (T - 6, N), to sixth order."""
    weights = np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * dt)
    return sum(w * values[k : len(values) - 6 + k] for k, w in enumerate(weights))
