r"""Bodies of an arm, ten inertial parameters each, and the torque of a rigid arm, which is linear in them.

The parameters of a body, in its own frame: mass, first moments h = m c, inertia about the origin of the frame. A body
exists if and only if its pseudo-inertia

.. math:: J = \begin{pmatrix} \Sigma & h \\ h^T & m \end{pmatrix}, \quad \Sigma = \tfrac12 \mathrm{tr}(I) 1 - I

is positive definite, which holds mass, centre of mass and inertia together.

Reference:
    Wensing, Kim, Slotine (2018), IEEE Robotics and Automation Letters 3(1), 60-67.

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
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.types import Array
from ffgym.robot import RobotDescription

PARAMETERS = ("mass", "h_x", "h_y", "h_z", "I_xx", "I_yy", "I_zz", "I_xy", "I_xz", "I_yz")
"""Names of the ten parameters; the inertia is about the origin of the body's frame."""

UNITS = ("kg", *("kg m",) * 3, *("kg m^2",) * 6)
"""Unit of each."""

_TENSOR = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Row and column of each of the six numbers of an inertia tensor, in the order of descriptions."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Body:
    """A rigid body that a link of the arm carries along."""

    name: str
    link: int
    """Index of the link with which it moves."""
    position: Array
    """Origin of its frame in the link frame [m], shape (3,)."""
    rotation: Array
    """Orientation of its frame in the link frame, shape (3, 3)."""
    parameters: Array
    """The ten inertial parameters of the description, shape (10,)."""


def bodies_of(robot: RobotDescription) -> tuple[Body, ...]:
    """Links of an arm, and its tool if that weighs something."""
    links = zip(robot.links, robot.bodies.mass, robot.bodies.com, robot.bodies.inertia, strict=True)
    bodies = [
        Body(name=name, link=i, position=np.zeros(3), rotation=np.eye(3), parameters=parameters(mass, com, inertia))
        for i, (name, mass, com, inertia) in enumerate(links)
    ]
    tool = robot.tool
    if tool is not None and tool.mass > 0:
        own = parameters(tool.mass, tool.com, tool.inertia)
        last = robot.n_joints - 1
        bodies.append(Body(name="tool", link=last, position=tool.position, rotation=tool.rotation, parameters=own))
    return tuple(bodies)


def with_bodies(robot: RobotDescription, values: Array) -> RobotDescription:
    """The robot with inertial parameters `values` (B, 10) of its bodies, in the order of `bodies_of`."""
    mass, com, inertia = mass_com_inertia(values)
    n = robot.n_joints
    robot = replace(robot, bodies=replace(robot.bodies, mass=mass[:n], com=com[:n], inertia=inertia[:n]))
    if len(values) == n or robot.tool is None:
        return robot
    return replace(robot, tool=replace(robot.tool, mass=float(mass[n]), com=com[n], inertia=inertia[n]))


def parameters(mass: float, com: Array, inertia: Array) -> Array:
    """The ten parameters (10,) of a mass [kg], centre of mass (3,) [m] and inertia (6,) about it [kg m^2]."""
    return np.concatenate([[mass], mass * com, inertia + _steiner(np.asarray(mass), com)])


def mass_com_inertia(values: Array) -> tuple[Array, Array, Array]:
    """Mass (...), centre of mass (..., 3) and inertia about it (..., 6) of parameters `values` (..., 10)."""
    mass = values[..., 0]
    com = values[..., 1:4] / mass[..., None]
    return mass, com, values[..., 4:] - _steiner(mass, com)


def pseudo_inertia(values: Array) -> Array:
    """Pseudo-inertia matrices (..., 4, 4) of parameters `values` (..., 10)."""
    return np.einsum("...k,kij->...ij", values, _PSEUDO)


def _steiner(mass: Array, com: Array) -> Array:
    """Compute the inertia that the distance `com` (..., 3) [m] adds to that of a `mass` (...) [kg], shape (..., 6)."""
    square = np.sum(com**2, axis=-1)
    terms = [(square if i == j else 0.0) - com[..., i] * com[..., j] for i, j in _TENSOR]
    return mass[..., None] * np.stack(np.broadcast_arrays(*terms), axis=-1)


def _pseudo_basis() -> Array:
    """The pseudo-inertia of each of the ten parameters alone, shape (10, 4, 4)."""
    basis = np.zeros((10, 4, 4))
    basis[0, 3, 3] = 1.0
    for i in range(3):
        basis[1 + i, i, 3] = basis[1 + i, 3, i] = 1.0
    for k, (i, j) in enumerate(_TENSOR, start=4):
        if i == j:
            basis[k, :3, :3] = 0.5 * np.eye(3)
        basis[k, i, j] -= 1.0
        basis[k, j, i] = basis[k, i, j]
    return basis


_PSEUDO = _pseudo_basis()


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

    def carry(self, position: Array) -> tuple[Array, Array]:
        """Compute place and pull of a point that turns with the frame; `position` (3,) or (T, 3) in the frame."""
        arm = np.einsum("tij,tj->ti", self.rotation, np.broadcast_to(position, self.origin.shape))
        pull = self.pull + np.cross(self.spin_rate, arm) + np.cross(self.spin, np.cross(self.spin, arm))
        return self.origin + arm, pull


def body_torque_columns(robot: RobotDescription, q: Array, dq: Array, ddq: Array) -> Iterator[Array]:
    """Joint torque of each inertial parameter at 1, gravity included, link side [N m, or N of a slide].

    Positions [rad or m], speeds and accelerations of the joints, link side, have shape (T, N). Yields for each body of
    `bodies_of` an array (T, 10, N), in the order of `PARAMETERS`; one at a time, since those of a long motion do not
    fit into memory together.
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
    for i, (position, own_axis) in enumerate(zip(robot.kinematics.position, robot.kinematics.axis, strict=True)):
        axis, speed, rise = before.rotation @ own_axis, dq[:, [i]], ddq[:, [i]]
        spin_push = np.cross(before.spin, axis * speed)  # the joint's own motion, turned by what carries it
        if robot.kinematics.is_sliding[i]:
            origin, pull = before.carry(position + q[:, [i]] * own_axis)
            before = replace(before, origin=origin, pull=pull + 2 * spin_push + axis * rise)
        else:
            origin, pull = before.carry(position)
            cross = _cross_matrix(own_axis)  # turned by Rodrigues' formula
            sine, cosine = np.sin(q[:, i])[:, None, None], np.cos(q[:, i])[:, None, None]
            before = _Frame(
                rotation=before.rotation @ (np.eye(3) + sine * cross + (1 - cosine) * (cross @ cross)),
                origin=origin,
                spin=before.spin + axis * speed,
                spin_rate=before.spin_rate + spin_push + axis * rise,
                pull=pull,
            )
        axes.append(axis)
        frames.append(before)
    return frames, axes


def _wrench(body: Body, link: _Frame) -> tuple[Array, Array, Array]:
    """Origin (T, 3), force and moment about it (T, 3, 10) of each inertial parameter of a body, in the world."""
    origin, pull = link.carry(body.position)
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
