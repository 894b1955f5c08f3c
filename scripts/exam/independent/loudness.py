r"""Loudness of a hidden effect in a log of the independent plant, by the log with it and the log without.

.. math:: \chi_0 = 1 + \max_c \frac1R \sum_i \left( \frac{\Delta_{ic}}{\sigma_c} \right)^2

over torques of the motors and coordinates of the tool; :math:`\Delta` less what errors of the description within their
bounds would explain of it along the same motion.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import lsq_linear

from ffgym.core.types import Array
from scripts.exam.independent.arm import bodies_of, inverse_dynamics, pose_of
from scripts.exam.independent.sensors import QUIET, TOOL_NOISE, TORQUE_NOISE, Exact, track
from scripts.exam.independent.setup import REFLECTOR, Setup

_BOUND = 4.0
"""Standard deviations within which an error of the description is one, as of a diagnosis."""

_ROWS = 400
"""Rows of each motion that are looked at, at most; chosen: errors of a description are smooth."""


def loudness(setup: Setup, without: Exact, with_effect: Exact, *, error: float = 0.0) -> float:
    """Loudness of what two logs of one machine differ by.

    Args:
        setup: the machine as described, and how sure that is.
        without: log without the effect.
        with_effect: log with it.
        error: of a number of the description, relative, if that is all that the effect is; 0 if it is none. As far as
            such errors go, it cannot be told from one.
    """
    every = max(1, len(without.angle) // _ROWS)
    quiet = QUIET if setup.noise == "quiet" else 1.0
    noise = quiet * TORQUE_NOISE * setup.robot.friction.coulomb
    changes, sigma = [(with_effect.torque - without.torque)[::every] / noise], [noise]
    if setup.columns.tracker:
        changes.append((with_effect.tool - without.tool)[::every] / (quiet * TOOL_NOISE))
        sigma.append(np.full(3, quiet * TOOL_NOISE))
    delta = np.concatenate([c.reshape(-1, c.shape[-1]) for c in changes], axis=1)
    columns = np.stack([c / np.concatenate(sigma) for c in _columns(setup, without, every)])
    if error:
        columns = np.concatenate([columns, setup.share / abs(error) * delta[None]])
    # errors of the description, in standard deviations, that explain most of the change
    flat = columns.reshape(len(columns), -1)
    root = np.linalg.cholesky(flat @ flat.T + np.eye(len(flat)))
    target = np.linalg.solve(root, flat @ delta.ravel())
    explained = lsq_linear(root.T, target, bounds=(-_BOUND, _BOUND)).x
    rest = delta - np.tensordot(explained, columns, axes=1)
    return 1 + float(np.mean(rest**2, axis=0).max())


def _columns(setup: Setup, without: Exact, every: int) -> list[Array]:
    """Compute the change by each number of the description per standard deviation, shape (rows, torques and tool)."""
    robot, share, n = setup.robot, setup.share, setup.robot.n_joints
    ratio, friction = robot.drive.gear_ratio, robot.friction
    # the motion of all logs, of the robot as it is described
    links = (without.angle / ratio, without.speed / ratio, np.gradient(without.speed / ratio, without.dt, axis=0))
    q, dq, ddq = (values[::every].reshape(-1, n) for values in links)
    bodies, still = bodies_of(robot, len(q)), np.zeros((len(q), n))
    rigid = inverse_dynamics(bodies, q, dq, ddq)
    # friction, rotors and current sensors, joint by joint
    speed = dq * ratio
    direction = np.tanh(speed / friction.stribeck_velocity * 4)
    slow = np.exp(-((speed / friction.stribeck_velocity) ** 2))
    own = (
        friction.coulomb * direction * share,
        friction.static * direction * slow * share,
        friction.viscous * speed * share,
        robot.drive.rotor_inertia * ratio * ddq * share,
        2 * share * np.tile(friction.coulomb, (len(speed), 1)),
    )
    torques = [np.where(np.arange(n) == j, values, 0.0) for values in own for j in range(n)]
    # heavier links
    for j in range(n):
        mass, inertia = bodies.mass.copy(), bodies.inertia.copy()
        mass[:, j] *= 1 + share
        inertia[:, j] *= 1 + share
        heavier = replace(bodies, mass=mass, inertia=inertia)
        torques.append((inverse_dynamics(heavier, q, dq, ddq) - rigid) / ratio)
    if not setup.columns.tracker:
        return torques
    # softer springs, and a reflector elsewhere
    place = track(bodies, q[None], setup.view, 1.0)[0]
    moved = []
    for j in np.flatnonzero(~robot.drive.is_rigid).tolist():
        bent = q.copy()
        bent[:, j] += share * rigid[:, j] / robot.drive.joint_stiffness[j]
        moved.append(track(bodies, bent[None], setup.view, 1.0)[0] - place)
    turned = pose_of(bodies, q).rotation[:, -1] @ bodies.tool_rotation
    moved += [REFLECTOR * turned[:, :, axis] for axis in range(3)]
    return [
        *(np.concatenate([torque, np.zeros((len(q), 3))], axis=1) for torque in torques),
        *(np.concatenate([still, tool], axis=1) for tool in moved),
    ]
