r"""Torque of a rigid arm as a linear function of the inertial parameters of its bodies, for whole motions at once.

Newton's and Euler's equations of a body with angular velocity w, angular acceleration a_w, and acceleration a of the
origin of its frame less gravity, all in that frame, are linear in mass m, first moments h and inertia I:

.. math::
    f = m a + ([\dot\omega]_\times + [\omega]_\times^2) h, \quad
    n = I \dot\omega + \omega \times I \omega - a \times h

A hinge carries the moment about its axis of all bodies behind it, a slide the force along its axis.

Reference:
    Atkeson, An, Hollerbach (1986), Int. J. Robotics Research 5(3), 101-119.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification.rigid_body.bodies import Body, bodies_of
from ffgym.robot import RobotDescription


@dataclass(frozen=True, kw_only=True, eq=False)
class _Frame:
    """Motion of a link frame in the world; first axis is time."""

    rotation: Array
    """(T, 3, 3)."""
    origin: Array
    """(T, 3) [m]."""
    spin: Array
    """Angular velocity (T, 3) [rad/s]."""
    spin_rate: Array
    """Angular acceleration (T, 3) [rad/s^2]."""
    pull: Array
    """Acceleration of the origin less gravity (T, 3) [m/s^2]."""

    def carried(self, position: Array) -> tuple[Array, Array]:
        """Where a point that turns with the frame is, and how it pulls; `position` (3,) or (T, 3) in the frame."""
        arm = np.einsum("tij,tj->ti", self.rotation, np.broadcast_to(position, self.origin.shape))
        pull = self.pull + np.cross(self.spin_rate, arm) + np.cross(self.spin, np.cross(self.spin, arm))
        return self.origin + arm, pull


def body_torque_columns(robot: RobotDescription, q: Array, dq: Array, ddq: Array) -> Iterator[Array]:
    """Joint torque of each inertial parameter at 1, gravity included, link side [N m, or N of a slide].

    Args:
        robot: geometry, gravity and which bodies there are; their masses play no part.
        q: joint positions, link side [rad or m], shape (T, N).
        dq: joint speeds, shape (T, N).
        ddq: joint accelerations, shape (T, N).

    Yields:
        For each body of `bodies_of` an array (T, 10, N), in the order of `PARAMETERS`; one at a time, since those of a
        long motion do not fit into memory together.
    """
    frames, axes = _frames(robot, q, dq, ddq)
    for body in bodies_of(robot):
        origin, force, moment = _wrench(body, frames[body.link])
        columns = np.zeros((len(q), 10, robot.n_joints))
        for j in range(body.link + 1):
            along = np.einsum("ti,tik->tk", axes[j], force)
            if not robot.kinematics.is_sliding[j]:
                lever = np.cross(axes[j], origin - frames[j].origin)
                along = np.einsum("ti,tik->tk", axes[j], moment) + np.einsum("ti,tik->tk", lever, force)
            columns[:, :, j] = along
        yield columns


def body_torque(robot: RobotDescription, values: Array, q: Array, dq: Array, ddq: Array) -> Array:
    """Joint torque (T, N) of bodies with inertial parameters `values` (B, 10); the rest as `body_torque_columns`."""
    columns = body_torque_columns(robot, q, dq, ddq)
    return np.sum([np.einsum("tkn,k->tn", c, own) for c, own in zip(columns, values, strict=True)], axis=0)


def _frames(robot: RobotDescription, q: Array, dq: Array, ddq: Array) -> tuple[list[_Frame], list[Array]]:
    """Motion of all link frames, from the base on, and their joint axes in the world (T, 3)."""
    count = len(q)
    still = np.zeros((count, 3))
    before = _Frame(
        rotation=np.broadcast_to(np.eye(3), (count, 3, 3)),
        origin=still,
        spin=still,
        spin_rate=still,
        pull=np.broadcast_to(-robot.gravity, (count, 3)),
    )
    frames, axes = [], []
    for i in range(robot.n_joints):
        axes.append(before.rotation @ robot.kinematics.axis[i])
        before = _next_frame(robot, i, before, axes[-1], q[:, [i]], dq[:, [i]], ddq[:, [i]])
        frames.append(before)
    return frames, axes


def _next_frame(
    robot: RobotDescription, i: int, before: _Frame, axis: Array, q: Array, dq: Array, ddq: Array
) -> _Frame:
    """The frame of link i from that before it; `axis` (T, 3) in the world, joint motion (T, 1)."""
    position, own_axis = robot.kinematics.position[i], robot.kinematics.axis[i]
    spin_push = np.cross(before.spin, axis * dq)  # the joint's own motion, turned by what carries it
    if robot.kinematics.is_sliding[i]:
        origin, pull = before.carried(position + q * own_axis)
        return _Frame(
            rotation=before.rotation,
            origin=origin,
            spin=before.spin,
            spin_rate=before.spin_rate,
            pull=pull + 2 * spin_push + axis * ddq,
        )
    origin, pull = before.carried(position)
    return _Frame(
        rotation=before.rotation @ _turned(own_axis, q[:, 0]),
        origin=origin,
        spin=before.spin + axis * dq,
        spin_rate=before.spin_rate + spin_push + axis * ddq,
        pull=pull,
    )


def _turned(axis: Array, angle: Array) -> Array:
    """Rotations (T, 3, 3) by `angle` (T,) [rad] about the unit `axis` (3,), Rodrigues' formula."""
    cross = _cross_matrix(axis)
    sine, cosine = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + sine * cross + (1 - cosine) * (cross @ cross)


def _wrench(body: Body, link: _Frame) -> tuple[Array, Array, Array]:
    """Origin (T, 3), force and moment about it (T, 3, 10) of each inertial parameter of a body, in the world."""
    origin, pull = link.carried(body.position)
    rotation = link.rotation @ body.rotation
    spin, spin_rate, own_pull = (np.einsum("tji,tj->ti", rotation, v) for v in (link.spin, link.spin_rate, pull))
    force, moment = np.zeros((len(pull), 3, 10)), np.zeros((len(pull), 3, 10))
    turn = _cross_matrix(spin)
    force[:, :, 0] = own_pull
    force[:, :, 1:4] = _cross_matrix(spin_rate) + turn @ turn
    moment[:, :, 1:4] = -_cross_matrix(own_pull)
    moment[:, :, 4:] = _tensor_times(spin_rate) + turn @ _tensor_times(spin)
    return origin, rotation @ force, rotation @ moment


def _cross_matrix(v: Array) -> Array:
    """Matrices (..., 3, 3) whose product with x is v x x, for vectors v (..., 3)."""
    columns: Array = np.cross(v[..., None, :], np.eye(3))
    return columns.swapaxes(-1, -2)


def _tensor_times(w: Array) -> Array:
    """Matrices (T, 3, 6) that make I w of the six numbers of an inertia tensor I, for vectors w (T, 3)."""
    x, y, z = w.T
    zero = np.zeros_like(x)
    rows = [[x, zero, zero, y, z, zero], [zero, y, zero, x, zero, z], [zero, zero, z, zero, x, y]]
    return np.moveaxis(np.array(rows), -1, 0)
