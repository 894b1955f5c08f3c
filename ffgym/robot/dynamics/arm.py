"""Kinematics and rigid-body dynamics of the arm, link side, for whole trajectories at once."""

from dataclasses import dataclass
from typing import Any, Literal

import mujoco
import numpy as np
from mujoco import batch

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.robot.description import RobotDescription
from ffgym.robot.model.spec import ModelOptions, compile_model


@dataclass(frozen=True, kw_only=True, eq=False)
class ChainLink:
    """A body between the world and the TCP, in the frame of the body before it."""

    position: Array
    rotation: Array | None
    """Orientation of its frame, (3, 3); None is that of the body before it."""
    joint: int = 0
    cross: Array | None = None
    """points @ cross is axis x points, for the unit axis of its hinge in the body's frame; None if it has none."""
    anchor: Array | None = None
    """Point on the hinge axis in the body's frame [m]; None is its origin."""
    slide: Array | None = None
    """Unit axis of its sliding joint in the body's frame, shape (3,); None if it has none."""

    def place(self, points: Array, q: Array) -> Array:
        """Points (T, 3) of this body in the frame of the body before it, at joint positions `q` (T, N)."""
        if self.cross is not None:  # Rodrigues' formula
            arms, angle = points if self.anchor is None else points - self.anchor, q[:, [self.joint]]
            points = (
                arms + np.sin(angle) * (arms @ self.cross) + (1 - np.cos(angle)) * (arms @ (self.cross @ self.cross))
            )
            points = points if self.anchor is None else points + self.anchor
        if self.slide is not None:
            points = points + q[:, [self.joint]] * self.slide
        return (points if self.rotation is None else points @ self.rotation.T) + self.position


def _chain_to_site(model: mujoco.MjModel, site: int) -> tuple[ChainLink, ...]:
    """A site, and the bodies that carry it down to the one that stands in the world."""
    chain = [ChainLink(position=model.site_pos[site].copy(), rotation=_matrix(model.site_quat[site]))]
    body = int(model.site_bodyid[site])
    while body > 0:
        joint, motion = int(model.body_jntadr[body]), dict[str, Any]()
        if joint >= 0 and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE:
            motion = {"slide": model.jnt_axis[joint].copy()}
        elif joint >= 0:
            anchor = model.jnt_pos[joint].copy() if model.jnt_pos[joint].any() else None
            motion = {"cross": np.cross(model.jnt_axis[joint], np.eye(3)), "anchor": anchor}
        position, rotation = model.body_pos[body].copy(), _matrix(model.body_quat[body])
        chain.append(ChainLink(position=position, rotation=rotation, joint=joint, **motion))
        body = int(model.body_parentid[body])
    return tuple(chain)


def _matrix(quaternion: Array) -> Array | None:
    """Orientation (3, 3) of a unit quaternion; None for no turn."""
    matrix = np.zeros((3, 3))
    mujoco.mju_quat2Mat(matrix.reshape(-1), quaternion)
    return None if np.array_equal(matrix, np.eye(3)) else matrix


RIGID = ModelOptions(flexible=False, friction=False, servo=False, looks=False)
"""Options of a model of the links alone."""

_CHUNK = 1024
"""Rows evaluated in one call: enough to keep the cores busy, small enough to stay in cache."""


class RigidArm:
    """The robot without elasticity, friction and motors, as MuJoCo computes it.

    Joint positions `q` are link side, shape (T, N), [rad], or [m] for a sliding joint, which has N where a hinge has
    N m. All results are in the world frame, in SI units.
    """

    def __init__(self, robot: RobotDescription, model: mujoco.MjModel | None = None) -> None:
        """Compile the links of a robot, or take a `model` of them; with more joints it serves for dynamics alone."""
        self.robot = robot
        self._model = compile_model(robot, RIGID) if model is None else model
        self._n = int(self._model.nv)
        self._batch = batch.Batch(self._model, nsim=_CHUNK)
        self._gravity = self._batch.expand("opt.gravity")
        self._tcp = self._model.site("tcp").id if robot.tool is not None else None
        self._chain = () if self._tcp is None else _chain_to_site(self._model, self._tcp)
        self._slides = np.flatnonzero(self._model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE)
        self._rows = np.repeat(np.arange(self._n), self._model.M_rownnz)
        self._columns = self._model.M_colind

    def __reduce__(self) -> tuple[Any, ...]:
        return RigidArm, (self.robot, self._model)  # a batch of the engine cannot be copied or pickled

    def tcp_position(self, q: Array) -> Array:
        """TCP position [m], shape (T, 3), at joint angles `q` [rad]; ten times as fast as `tcp_pose`."""
        self._tcp_id()
        q = check_shape("q", q, (None, self.robot.n_joints))
        point = np.zeros((len(q), 3))
        for link in self._chain:
            point = link.place(point, q)
        return point

    def tcp_pose(self, q: Array) -> tuple[Array, Array]:
        """TCP position [m], shape (T, 3), and tool0 orientation, shape (T, 3, 3), at joint angles `q` [rad]."""
        tcp = self._tcp_id()
        out = self._evaluate(("site_xpos", "site_xmat"), q)
        return out["site_xpos"][:, tcp], out["site_xmat"][:, tcp].reshape(-1, 3, 3)

    def jacobian(self, q: Array) -> Array:
        """Geometric Jacobian of the TCP, rows linear [m/rad] then angular [1], shape (T, 6, N)."""
        return self.pose_and_jacobian(q)[2]

    def pose_and_jacobian(self, q: Array) -> tuple[Array, Array, Array]:
        """TCP position (T, 3), tool0 orientation (T, 3, 3) and Jacobian (T, 6, N) in one evaluation."""
        tcp = self._tcp_id()
        out = self._evaluate(("site_xpos", "site_xmat", "xanchor", "xaxis"), q)
        arms = out["site_xpos"][:, [tcp]] - out["xanchor"]
        linear, angular = np.cross(out["xaxis"], arms), out["xaxis"].copy()
        linear[:, self._slides], angular[:, self._slides] = angular[:, self._slides], 0.0
        jacobian = np.concatenate([linear, angular], axis=2).swapaxes(1, 2)
        return out["site_xpos"][:, tcp], out["site_xmat"][:, tcp].reshape(-1, 3, 3), jacobian

    def bias_acceleration(self, q: Array, dq: Array) -> Array:
        r"""TCP acceleration :math:`\dot J \dot q` at constant speed, linear [m/s^2], angular [rad/s^2], (T, 6)."""
        tcp_id = self._tcp_id()
        out = self._evaluate(("site_xpos", "xanchor", "xaxis"), q)
        dq = check_shape("dq", dq, (len(q), self.robot.n_joints))
        axis, anchor, tcp = out["xaxis"], out["xanchor"], out["site_xpos"][:, tcp_id]
        spin, push = axis * dq[:, :, None], np.zeros_like(axis)  # what each joint adds to turning and moving, (T, N, 3)
        push[:, self._slides], spin[:, self._slides] = spin[:, self._slides], 0.0
        axis_rate = np.cross(np.cumsum(spin, axis=1), axis)
        linear, angular = np.zeros_like(tcp), np.zeros_like(tcp)
        tcp_velocity = _point_velocity(spin, push, anchor, tcp, self.robot.n_joints)
        for i in range(self.robot.n_joints):
            if i in self._slides:
                linear += dq[:, [i]] * axis_rate[:, i]
                continue
            anchor_velocity = _point_velocity(spin, push, anchor, anchor[:, i], i)
            linear += dq[:, [i]] * np.cross(axis_rate[:, i], tcp - anchor[:, i])
            linear += dq[:, [i]] * np.cross(axis[:, i], tcp_velocity - anchor_velocity)
            angular += dq[:, [i]] * axis_rate[:, i]
        return np.concatenate([linear, angular], axis=1)

    def mass_matrix(self, q: Array) -> Array:
        """Joint inertia matrix of the links [kg m^2], without rotors, shape (T, N, N)."""
        return self._unpack(self._evaluate(("M",), q)["M"])

    def _unpack(self, packed: Array) -> Array:
        """Unpack symmetric matrices (T, N, N) from MuJoCo's sparse lower triangles."""
        matrix = np.zeros((len(packed), self._n, self._n))
        matrix[:, self._rows, self._columns] = packed
        matrix[:, self._columns, self._rows] = packed
        return matrix

    def gravity_torque(self, q: Array) -> Array:
        """Torque [N m] that holds the links still at `q`, shape (T, N)."""
        return self._evaluate(("qfrc_bias",), q, stage="velocity", gravity=True)["qfrc_bias"]

    def spring_torque(self, q: Array) -> Array:
        """Torque [N m] that holds the arm still at `q` against the springs between its links, shape (T, N)."""
        if not self.robot.springs:
            return np.zeros(check_shape("q", q, (None, self._n)).shape)
        return -self._evaluate(("qfrc_passive",), q, stage="velocity")["qfrc_passive"]

    def holding_torque(self, q: Array) -> Array:
        """Torque [N m] that holds the arm still at `q` against gravity and springs, shape (T, N)."""
        return self.gravity_torque(q) + self.spring_torque(q)

    def inverse_dynamics(self, q: Array, dq: Array, ddq: Array, *, gravity: bool = False) -> Array:
        """Joint torque [N m] of the rigid links for a motion, M(q) ddq + C(q, dq) dq (+ g(q)), shape (T, N)."""
        ddq = check_shape("ddq", ddq, (len(q), self._n))
        mass, bias = self.equations_of_motion(q, dq, gravity=gravity)
        return np.einsum("tij,tj->ti", mass, ddq) + bias

    def equations_of_motion(self, q: Array, dq: Array, *, gravity: bool = False) -> tuple[Array, Array]:
        """M(q) [kg m^2], shape (T, N, N), and C(q, dq) dq (+ g(q)) [N m], shape (T, N), in one evaluation."""
        out = self._evaluate(("M", "qfrc_bias"), q, dq, stage="velocity", gravity=gravity)
        return self._unpack(out["M"]), out["qfrc_bias"]

    def _tcp_id(self) -> int:
        if self._tcp is None:
            raise FFGymError(
                f"Robot {self.robot.name!r} has no tool, so it has no TCP; give its motions in joint space."
            )
        return int(self._tcp)

    def _evaluate(
        self,
        fields: tuple[str, ...],
        q: Array,
        dq: Array | None = None,
        *,
        stage: Literal["position", "velocity"] = "position",
        gravity: bool = False,
    ) -> dict[str, Array]:
        """Let MuJoCo compute `fields` at every row of `q` (and `dq`); returns arrays with T rows."""
        q = check_shape("q", q, (None, self._n))
        dq = np.zeros_like(q) if dq is None else check_shape("dq", dq, (len(q), self._n))
        engine = self._batch
        bound = {name: engine.bind(name) for name in fields}
        out = {name: np.empty((len(q), *view.shape[1:])) for name, view in bound.items()}
        self._gravity[:] = self.robot.gravity if gravity else 0.0
        reach = mujoco.mjtStage.mjSTAGE_VEL if stage == "velocity" else mujoco.mjtStage.mjSTAGE_POS
        for start in range(0, len(q), _CHUNK):
            rows = slice(start, min(start + _CHUNK, len(q)))
            count = rows.stop - rows.start
            engine.qpos[:count] = q[rows]
            engine.qvel[:count] = dq[rows]
            engine.forward(None if count == _CHUNK else np.arange(count), stage=reach.value)
            for name, view in bound.items():
                out[name][rows] = view[:count]
        return out


def _point_velocity(spin: Array, push: Array, anchor: Array, point: Array, n: int) -> Array:
    """Velocity [m/s] that the first `n` joints give to `point`, shape (T, 3)."""
    turning: Array = np.cross(spin[:, :n], point[:, None] - anchor[:, :n]).sum(axis=1)
    return turning + push[:, :n].sum(axis=1)
