r"""Equations of motion of serial arms, for many arms or poses at once, by Newton and Euler projected on the joints.

.. math:: M = \sum_j m_j J_{v,j}^T J_{v,j} + J_{\omega,j}^T I_j J_{\omega,j}, \quad
    b = \sum_j J_{v,j}^T m_j (a_j - g) + J_{\omega,j}^T (I_j \alpha_j + \omega_j \times I_j \omega_j)

with accelerations at :math:`\ddot q = 0`.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.robot.description import RobotDescription

_ONE = np.eye(3)

_LEVI_CIVITA = np.zeros((3, 9))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _LEVI_CIVITA[_i, 3 * _k + _j], _LEVI_CIVITA[_i, 3 * _j + _k] = 1.0, -1.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Bodies:
    """Geometry and masses of B arms of N joints, the tool being part of the last link."""

    position: Array
    """Origin of each joint in the previous link frame [m], shape (B, N, 3)."""
    axis: Array
    """Unit axis of each joint, shape (B, N, 3)."""
    slides: BoolArray
    """True for sliding joints, shape (N,)."""
    mass: Array
    """[kg], shape (B, N)."""
    com: Array
    """Centre of mass in the link frame [m], shape (B, N, 3)."""
    inertia: Array
    """About the centre of mass [kg m^2], shape (B, N, 3, 3)."""
    gravity: Array
    """[m/s^2], shape (3,)."""
    tool_point: Array
    """Tool centre point in the last link frame [m], shape (B, 3)."""
    tool_rotation: Array
    """Orientation of the flange in the last link frame, shape (3, 3)."""

    @cached_property
    def square_root(self) -> Array:
        """Factor L of the inertia L L^T, shape (B, N, 3, 3)."""
        return np.asarray(np.linalg.cholesky(self.inertia))

    @cached_property
    def root_mass(self) -> Array:
        """Square root of the masses, shape (B, 1, N, 1)."""
        return np.asarray(np.sqrt(self.mass)[:, None, :, None])

    @cached_property
    def before(self) -> Array:
        """1 where a joint (row) moves a link (column), shape (N, N, 1)."""
        return np.triu(np.ones((len(self.slides), len(self.slides))))[..., None]

    @cached_property
    def has_slides(self) -> bool:
        """True if any joint slides."""
        return bool(self.slides.any())

    @cached_property
    def turning(self) -> Array:
        """1 for hinges, 0 for slides, shape (N, 1)."""
        return (~self.slides)[:, None].astype(np.float64)

    @cached_property
    def turns(self) -> tuple[Array, Array]:
        """Cross-product matrices of the axes and their squares, shape (B, N, 3, 3) each; zero for slides."""
        skew = _skew(self.axis * self.turning)
        return skew, skew @ skew


@dataclass(frozen=True, kw_only=True, eq=False)
class Pose:
    """Places and orientations of bodies at joint positions q."""

    rotation: Array
    """Rotation of each link in the world, shape (B, N, 3, 3)."""
    axis: Array
    """Joint axes in the world, shape (B, N, 3)."""
    origin: Array
    """Origin of the link frames [m], shape (B, N, 3)."""
    centre: Array
    """Centre of mass [m], shape (B, N, 3)."""
    offset: Array
    """Offset of each frame from the previous one, in the world [m], shape (B, N, 3)."""


def bodies_of(robot: RobotDescription, count: int = 1) -> Bodies:
    """Bodies as a description has them, `count` times."""
    bodies, n = robot.bodies, robot.n_joints
    mass, com, inertia = bodies.mass.copy(), bodies.com.copy(), np.array([matrix_of(row) for row in bodies.inertia])
    rotation, point = np.eye(3), np.zeros(3)
    if (tool := robot.tool) is not None:
        rotation, point = tool.rotation, tool.position + tool.rotation @ tool.tcp
        if tool.mass > 0:
            place = tool.position + rotation @ tool.com
            own = rotation @ matrix_of(tool.inertia) @ rotation.T
            mass[-1], com[-1], inertia[-1] = join((mass[-1], com[-1], inertia[-1]), (tool.mass, place, own))

    def many(values: Array) -> Array:
        return np.repeat(np.asarray(values, dtype=np.float64)[None], count, axis=0)

    return Bodies(
        position=many(robot.kinematics.position),
        axis=many(robot.kinematics.axis),
        slides=np.array([kind == "slide" for kind in robot.kinematics.types]),
        mass=many(mass),
        com=many(com),
        inertia=many(inertia).reshape(count, n, 3, 3),
        gravity=robot.gravity,
        tool_point=many(point),
        tool_rotation=rotation,
    )


def matrix_of(six: Array) -> Array:
    """Inertia matrix (3, 3) of xx, yy, zz, xy, xz, yz."""
    xx, yy, zz, xy, xz, yz = six
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


Body = tuple[float, Array, Array]
"""Mass [kg], centre of mass [m] (3,), inertia about it [kg m^2] (3, 3)."""


def join(one: Body, other: Body) -> Body:
    """Two bodies as one."""
    mass = one[0] + other[0]
    centre = (one[0] * one[1] + other[0] * other[1]) / mass
    inertia = np.zeros((3, 3))
    for own, com, about in (one, other):
        arm = com - centre
        inertia = inertia + (about + own * (np.dot(arm, arm) * np.eye(3) - np.outer(arm, arm)))  # Steiner
    return mass, centre, inertia


def pose_of(bodies: Bodies, q: Array) -> Pose:
    """Pose at joint positions (B, N)."""
    skew, square = bodies.turns
    angle = q[..., None, None]
    own = np.sin(angle) * skew
    own += (1 - np.cos(angle)) * square
    own += _ONE
    rotation = own
    for i in range(1, q.shape[1]):
        rotation[:, i] = rotation[:, i - 1] @ own[:, i]
    offset = bodies.position
    if bodies.has_slides:
        offset = offset + bodies.axis * (q * bodies.slides)[..., None]
    if q.shape[1] > 1:
        offset = offset.copy()
        offset[:, 1:] = _times(rotation[:, :-1], offset[:, 1:])
    origin = offset.cumsum(axis=1)
    centre = origin + _times(rotation, bodies.com)
    return Pose(rotation=rotation, axis=_times(rotation, bodies.axis), origin=origin, centre=centre, offset=offset)


def tool_of(bodies: Bodies, pose: Pose) -> Array:
    """Tool centre points in the world [m], shape (B, 3)."""
    return np.asarray(pose.origin[:, -1] + _times(pose.rotation[:, -1], bodies.tool_point))


def mass_and_bias(bodies: Bodies, q: Array, dq: Array) -> tuple[Array, Array]:
    """Mass matrix (B, N, N) and torques (B, N) at joint positions and speeds without acceleration, link side."""
    pose = pose_of(bodies, q)
    count, n = q.shape
    linear, hinge = _linear(bodies, pose)
    root = pose.rotation @ bodies.square_root
    angular = (hinge[:, None] @ root).swapaxes(1, 2) * bodies.before
    rows = np.concatenate([linear * bodies.root_mass, angular], axis=2).reshape(count, n, -1)
    forces, moments = _newton_euler(bodies, pose, hinge, root, dq, None)
    return rows @ rows.swapaxes(1, 2), _project(linear, hinge, forces, moments)


def inverse_dynamics(bodies: Bodies, q: Array, dq: Array, ddq: Array) -> Array:
    """Torques (B, N) that rigid arms take, link side, without rotors."""
    pose = pose_of(bodies, q)
    linear, hinge = _linear(bodies, pose)
    root = pose.rotation @ bodies.square_root
    return _project(linear, hinge, *_newton_euler(bodies, pose, hinge, root, dq, ddq))


def _times(matrix: Array, vector: Array) -> Array:
    """Matrices (..., 3, 3) times vectors (..., 3)."""
    product: Array = matrix @ vector[..., None]
    return product[..., 0]


def _skew(vector: Array) -> Array:
    """Matrices (..., 3, 3) that give the cross product with vectors (..., 3)."""
    nine: Array = vector @ _LEVI_CIVITA
    return nine.reshape((*vector.shape, 3))


def _linear(bodies: Bodies, pose: Pose) -> tuple[Array, Array]:
    """Speed of each link's centre by each joint, shape (B, joint, link, 3), and axes of hinges, (B, N, 3)."""
    hinge = pose.axis * bodies.turning
    arm = pose.centre[:, None] - pose.origin[:, :, None]
    linear = arm @ _skew(hinge).swapaxes(2, 3)
    if bodies.has_slides:
        linear = linear + (pose.axis - hinge)[:, :, None]
    return linear * bodies.before, hinge


def _newton_euler(
    bodies: Bodies, pose: Pose, hinge: Array, root: Array, dq: Array, ddq: Array | None
) -> tuple[Array, Array]:
    """Forces (B, N, 3), and moments (B, N, 3) about the centres of mass, that move the links."""
    turning = hinge * dq[..., None]
    spin = turning.cumsum(axis=1)
    previous = _skew(spin - turning)  # of the link before
    change = _times(previous, turning)
    if ddq is not None:
        change = change + hinge * ddq[..., None]
    spin_rate = change.cumsum(axis=1)
    step = _times(_skew(spin_rate - change) + previous @ previous, pose.offset)
    if bodies.has_slides:
        sliding = pose.axis - hinge
        step = step + 2 * _times(previous, sliding * dq[..., None])
        step = step if ddq is None else step + sliding * ddq[..., None]
    own = _skew(spin)
    moved = step.cumsum(axis=1) + _times(_skew(spin_rate) + own @ own, pose.centre - pose.origin)
    inertia = root @ root.swapaxes(2, 3)
    forces = bodies.mass[..., None] * (moved - bodies.gravity)
    return forces, _times(inertia, spin_rate) + _times(own @ inertia, spin)


def _project(linear: Array, hinge: Array, forces: Array, moments: Array) -> Array:
    """Torques (B, N) of the joints that give forces and moments of the links."""
    carried = moments[:, ::-1].cumsum(axis=1)[:, ::-1]
    count, n = hinge.shape[:2]
    pushed = linear.reshape(count, n, -1) @ forces.reshape(count, -1, 1)
    torque: Array = pushed[..., 0] + (hinge * carried).sum(axis=2)
    return torque
