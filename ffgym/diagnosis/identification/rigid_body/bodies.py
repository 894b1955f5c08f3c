r"""Bodies of an arm and their ten inertial parameters each, in which the torque of a rigid arm is linear.

The parameters of a body, in its own frame: mass, first moments h = m c, inertia about the origin of the frame. A body
exists if and only if its pseudo-inertia

.. math:: J = \begin{pmatrix} \Sigma & h \\ h^T & m \end{pmatrix}, \quad \Sigma = \tfrac12 \mathrm{tr}(I) 1 - I

is positive definite, which holds mass, centre of mass and inertia together.

Reference:
    Wensing, Kim, Slotine (2018), IEEE Robotics and Automation Letters 3(1), 60-67.
"""

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
    """What the distance `com` (..., 3) [m] adds to the inertia of a `mass` (...) [kg], shape (..., 6)."""
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
