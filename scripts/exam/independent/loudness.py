r"""Loudness of a hidden effect in a log of the independent plant, by the log with it and the log without.

.. math:: \chi_0 = 1 + \max_c \frac1R \sum_i \left( \frac{\Delta_{ic}}{\sigma_c} \right)^2

over torques of the motors and coordinates of the tool; :math:`\Delta` less what errors of the description within their
bounds would explain of it along the same motion.
"""

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.optimize import lsq_linear

from ffgym.core.types import Array
from scripts.exam.independent.arm import Bodies, inverse_dynamics, pose_of
from scripts.exam.independent.machine import numbers_of
from scripts.exam.independent.sensors import QUIET, TOOL_NOISE, TORQUE_NOISE, Exact, tracked
from scripts.exam.independent.setup import REFLECTOR, Setup

_BOUND = 4.0
"""Standard deviations within which an error of the description is one, as of a diagnosis."""

_ROWS = 400
"""Rows of each motion that are looked at, at most; chosen: errors of a description are smooth."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Motion:
    """Rows of all motions of a log in one, of the robot as described."""

    bodies: Bodies
    q: Array
    dq: Array
    ddq: Array


def loudness(setup: Setup, without: Exact, with_effect: Exact, *, error: float = 0.0) -> float:
    """Loudness of what two logs of one machine differ by.

    Args:
        setup: the machine as described, and how sure that is.
        without: log without the effect.
        with_effect: log with it.
        error: of a number of the description, relative, if that is all that the effect is; 0 if it is none. As far as
            such errors go, nobody can tell it from one.
    """
    every = max(1, len(without.angle) // _ROWS)
    changes, sigma = [], []
    size = QUIET if setup.noise == "quiet" else 1.0
    noise = size * TORQUE_NOISE * setup.robot.friction.coulomb
    changes.append((with_effect.torque - without.torque)[::every] / noise)
    sigma.append(noise)
    if setup.columns.tracker:
        changes.append((with_effect.tool - without.tool)[::every] / (size * TOOL_NOISE))
        sigma.append(np.full(3, size * TOOL_NOISE))
    delta = np.concatenate([c.reshape(-1, c.shape[-1]) for c in changes], axis=1)
    columns = np.stack([c / np.concatenate(sigma) for c in _columns(setup, without, every)])
    if error:
        columns = np.concatenate([columns, setup.share / abs(error) * delta[None]])
    rest = delta - np.tensordot(_explained(columns, delta), columns, axes=1)
    return 1 + float(np.mean(rest**2, axis=0).max())


def _explained(columns: Array, delta: Array) -> Array:
    """Errors of the description, in standard deviations, that explain most of a change; shape (K,)."""
    flat = columns.reshape(len(columns), -1)
    gram = flat @ flat.T + np.eye(len(flat))
    root = np.linalg.cholesky(gram)
    target = np.linalg.solve(root, flat @ delta.ravel())
    return np.asarray(lsq_linear(root.T, target, bounds=(-_BOUND, _BOUND)).x)


def _columns(setup: Setup, without: Exact, every: int) -> list[Array]:
    """What each number of the description changes per standard deviation, shape (rows, torques and tool)."""
    robot, share = setup.robot, setup.share
    n, width = robot.n_joints, robot.n_joints + 3 * setup.columns.tracker
    motion = _motion(setup, without, every)
    speed = motion.dq * robot.drive.gear_ratio
    direction = np.tanh(speed / robot.friction.stribeck_velocity * 4)
    slow = np.exp(-((speed / robot.friction.stribeck_velocity) ** 2))
    own = {
        "coulomb": robot.friction.coulomb * direction * share,
        "breakaway": robot.friction.static * direction * slow * share,
        "viscous": robot.friction.viscous * speed * share,
        "rotor": robot.drive.rotor_inertia * robot.drive.gear_ratio * motion.ddq * share,
        "offset": 2 * share * np.tile(robot.friction.coulomb, (len(speed), 1)),
    }
    found = []
    for values in own.values():
        for j in range(n):
            column = np.zeros((len(speed), width))
            column[:, j] = values[:, j]
            found.append(column)
    rigid = inverse_dynamics(motion.bodies, motion.q, motion.dq, motion.ddq)
    for j in range(n):
        column = np.zeros((len(speed), width))
        column[:, :n] = (_of_heavier(motion, j, share) - rigid) / robot.drive.gear_ratio
        found.append(column)
    if setup.columns.tracker:
        found += _of_tool(setup, motion, rigid)
    return found


def _motion(setup: Setup, without: Exact, every: int) -> _Motion:
    ratio = setup.robot.drive.gear_ratio
    dq = without.speed / ratio
    ddq = np.gradient(dq, without.dt, axis=0)
    q, dq, ddq = ((v[::every]).reshape(-1, v.shape[-1]) for v in (without.angle / ratio, dq, ddq))
    one = numbers_of(setup.robot).bodies
    names = ("position", "axis", "mass", "com", "inertia", "tool_point")
    many = replace(one, **{name: np.repeat(getattr(one, name), len(q), axis=0) for name in names})
    return _Motion(bodies=many, q=q, dq=dq, ddq=ddq)


def _of_heavier(motion: _Motion, link: int, share: float) -> Array:
    bodies = motion.bodies
    mass, inertia = bodies.mass.copy(), bodies.inertia.copy()
    mass[:, link] *= 1 + share
    inertia[:, link] *= 1 + share
    return inverse_dynamics(replace(bodies, mass=mass, inertia=inertia), motion.q, motion.dq, motion.ddq)


def _of_tool(setup: Setup, motion: _Motion, rigid: Array) -> list[Array]:
    """Softer springs and a reflector elsewhere."""
    robot = setup.robot
    place = tracked(motion.bodies, motion.q[None], setup.view, 1.0)[0]
    moved = []
    for j in np.flatnonzero(~robot.drive.is_rigid):
        bent = motion.q.copy()
        bent[:, j] += setup.share * rigid[:, j] / robot.drive.joint_stiffness[j]
        moved.append(tracked(motion.bodies, bent[None], setup.view, 1.0)[0] - place)
    turned = pose_of(motion.bodies, motion.q).rotation[:, -1] @ motion.bodies.tool_rotation
    moved += [REFLECTOR * turned[:, :, axis] for axis in range(3)]
    still = np.zeros((len(motion.q), robot.n_joints))
    return [np.concatenate([still, tool], axis=1) for tool in moved]
