"""Rigid-body dynamics of a described arm by Pinocchio, which shares nothing with MuJoCo but the description.

Carpentier et al. (2019), "The Pinocchio C++ library", SII: recursive Newton-Euler and composite rigid bodies.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from ffgym.core.types import Array
from ffgym.robot import RobotDescription
from ffgym.robot.parts import Spring

_JOINTS = {"hinge": pin.JointModelRevoluteUnaligned, "slide": pin.JointModelPrismaticUnaligned}

BASE_RADIUS = 0.3
"""Radius of gyration of a base that turns [m], chosen by effect base_flexibility."""


class PinocchioArm:
    """Links, tool and springs of a robot, link side, one pose at a time: q, dq and ddq have shape (N,).

    Results are in the world frame, in SI units, as those of `ffgym.robot.RigidArm`. Joints without motors may be added:
    then q is of all joints in their order along the chain, and `own` says which are those of the robot.
    """

    def __init__(self, robot: RobotDescription, base: Sequence[int] = (), bends: Sequence[int] = ()) -> None:
        """Build the chain.

        Args:
            robot: the description.
            base: axes of the world about which the base turns on its floor, 0 to 2.
            bends: indices of links that bend about the axis of their joint, a third of the way to the next joint.
        """
        self.robot = robot
        self.own: list[int] = []
        """Places of the robot's joints among all."""
        self.structure: list[int] = []
        """Places of joints without motors."""
        self.model = pin.Model()
        self.model.gravity.linear = robot.gravity
        kinematics, bodies = robot.kinematics, robot.bodies
        last, offset = 0, np.zeros(3)
        # the base and its floor
        for i in base:
            last = self._add_joint(self.structure, last, "hinge", np.eye(3)[i], offset, f"base {i}")
        if base:
            mass = max(robot.base_mass, 1.0)
            inertia = pin.Inertia(mass, robot.base_com, mass * BASE_RADIUS**2 * np.eye(3))
            self.model.appendBodyToJoint(last, inertia, pin.SE3.Identity())
        self._places = {"base": (last, pin.SE3.Identity())}
        # joints and links
        flange = [np.zeros(3) if robot.tool is None else robot.tool.position]
        ways = [*kinematics.position[1:], *flange]  # from each joint to the next, and to the tool
        offset = kinematics.position[0]
        for i, (joint, link, kind) in enumerate(zip(robot.joints, robot.links, kinematics.types, strict=True)):
            axis = kinematics.axis[i]
            last = self._add_joint(self.own, last, kind, axis, offset, joint)
            inertia = pin.Inertia(bodies.mass[i], bodies.com[i], tensor(bodies.inertia[i]))
            self.model.appendBodyToJoint(last, inertia, pin.SE3.Identity())
            self._places[link] = (last, pin.SE3.Identity())
            offset = ways[i]
            if i in bends:
                last = self._add_joint(self.structure, last, kind, axis, offset / 3, f"{joint} bend")
                offset = 2 / 3 * offset
        if robot.tool is not None:
            tool, place = robot.tool, pin.SE3(robot.tool.rotation, offset)
            self.model.appendBodyToJoint(last, pin.Inertia(tool.mass, tool.com, tensor(tool.inertia)), place)
            self._places["tool"] = (last, place)
            self._tcp = self._add_point("tcp", "tool", tool.tcp)
        self._springs: list[tuple[Spring, int, int]] = []
        for spring in robot.springs:
            points = zip(("start", "end"), spring.bodies, (spring.start, spring.end), strict=True)
            ends = [self._add_point(f"{spring.name} {end}", body, point) for end, body, point in points]
            self._springs.append((spring, ends[0], ends[1]))
        self._data = self.model.createData()

    def _add_joint(self, kept: list[int], parent: int, kind: str, axis: Array, place: Array, name: str) -> int:
        kept.append(self.model.nv)
        return int(self.model.addJoint(parent, _JOINTS[kind](axis), pin.SE3(np.eye(3), place), name))

    def add_body(self, mass: float, com: Array, inertia: Array) -> None:
        """Weld a body to the tool: mass [kg], centre of mass [m] (3,), inertia about it [kg m^2] (3, 3), in tool0."""
        joint, flange = self._places["tool"]
        self.model.appendBodyToJoint(joint, pin.Inertia(mass, com, inertia), flange)
        self._data = self.model.createData()

    def _add_point(self, name: str, body: str, point: Array) -> int:
        """Index of a new frame at a point of a body, in the body's orientation."""
        joint, place = self._places[body]
        frame = pin.Frame(name, joint, place * pin.SE3(np.eye(3), point), pin.FrameType.OP_FRAME)
        return int(self.model.addFrame(frame))

    def _located(self, q: Array) -> Any:
        pin.framesForwardKinematics(self.model, self._data, q)
        return self._data.oMf

    def joint_origins(self, q: Array) -> Array:
        """Origins of all link frames [m], (N, 3)."""
        self._located(q)
        return np.array([place.translation for place in self._data.oMi[1:]])

    def tcp_pose(self, q: Array) -> tuple[Array, Array]:
        """TCP [m] (3,) and orientation of tool0 (3, 3)."""
        place = self._located(q)[self._tcp]
        return place.translation.copy(), place.rotation.copy()

    def jacobian(self, q: Array) -> Array:
        """Geometric Jacobian of the TCP, rows linear then angular, (6, N)."""
        return self._jacobian(q, self._tcp)

    def _jacobian(self, q: Array, frame: int) -> Array:
        world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        return np.asarray(pin.computeFrameJacobian(self.model, self._data, q, frame, world)).reshape(6, -1)

    def bias_acceleration(self, q: Array, dq: Array) -> Array:
        """Acceleration of the TCP, linear then angular, at constant speed of the joints, (6,)."""
        pin.forwardKinematics(self.model, self._data, q, dq, np.zeros_like(dq))
        world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        return np.asarray(pin.getFrameClassicalAcceleration(self.model, self._data, self._tcp, world).vector)

    def mass_matrix(self, q: Array) -> Array:
        """(N, N), without rotors, by composite rigid bodies."""
        upper: Array = np.triu(pin.crba(self.model, self._data, q).reshape(2 * (self.model.nv,)))
        return np.asarray(upper + np.triu(upper, 1).T)

    def gravity_torque(self, q: Array) -> Array:
        """Torque that holds the links at rest, (N,)."""
        return np.array(pin.computeGeneralizedGravity(self.model, self._data, q))

    def bias(self, q: Array, dq: Array) -> Array:
        """Coriolis, centrifugal and gravity torque, (N,)."""
        return np.array(pin.nonLinearEffects(self.model, self._data, q, dq))

    def inverse_dynamics(self, q: Array, dq: Array, ddq: Array) -> Array:
        """Torque for a motion, gravity included, by recursive Newton-Euler, (N,)."""
        return np.array(pin.rnea(self.model, self._data, q, dq, ddq))

    def spring_torque(self, q: Array) -> Array:
        """Torque that holds the arm against the springs between its bodies: slope of their energy, (N,)."""
        torque = np.zeros(self.model.nv)
        for spring, start, end in self._springs:
            place = self._located(q)
            apart = place[end].translation - place[start].translation
            length = np.linalg.norm(apart)
            pull = np.polyval([*spring.stiffness[::-1], 0.0], length - spring.length)
            spread = self._jacobian(q, end)[:3] - self._jacobian(q, start)[:3]
            torque += pull * (apart / length) @ spread
        return torque

    def kinetic_energy(self, q: Array, dq: Array) -> float:
        """Energy of the links [J], without rotors."""
        return float(pin.computeKineticEnergy(self.model, self._data, q, dq))

    def potential_energy(self, q: Array) -> float:
        """Energy in gravity [J], up to a constant."""
        return float(pin.computePotentialEnergy(self.model, self._data, q))


def tensor(inertia: Array) -> Array:
    """Inertia matrix (3, 3) of xx, yy, zz, xy, xz, yz."""
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
