"""The robot that a protocol is made for: what its motors and joints may do."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array, BoolArray
from ffgym.paths.motions.part import resting_position
from ffgym.robot import RigidArm, RobotDescription

FASTEST = 0.8
"""Largest share of a joint's speed limit that a protocol uses; chosen: some is left for the feedback."""


TOOL_NEARBY = 0.6
"""How far large motions take the tool from where it rests, as a share of its distance from the base there; chosen: the
loads of a shoulder then differ by a quarter of its torque, and the arm does not fold."""

TOOL_DROP = 0.3
"""How far they lower it, in the same unit; chosen: the tools of the built-in robots stay above the floor."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Stage:
    """A robot, with quantities of motors turned into those of joints."""

    arm: RigidArm

    @property
    def robot(self) -> RobotDescription:
        """The robot."""
        return self.arm.robot

    @property
    def dt(self) -> float:
        """Sample time of references [s]."""
        return self.robot.servo.control_dt

    @property
    def rest(self) -> Array:
        """Joint positions (N,) about which protocols move: home, or as near to zero as can be."""
        return resting_position(self.robot)

    @property
    def span(self) -> Array:
        """Width of the joints' ranges, link side [rad or m], shape (N,)."""
        return np.diff(self.robot.kinematics.range, axis=1)[:, 0]

    @property
    def presliding(self) -> Array:
        """Motor angle over which bristles bend before they slip, f_s / sigma_0 [rad], shape (N,)."""
        friction = self.robot.friction
        return friction.static / friction.bristle_stiffness

    def moved(self, joints: Sequence[str]) -> tuple[int, ...]:
        """Numbers of the joints with these names, in the order of the robot; none is all.

        Raises:
            FFGymError: if the robot has no such joint.
        """
        for name in joints:
            check_choice("joint", name, self.robot.joints)
        return tuple(j for j, name in enumerate(self.robot.joints) if not joints or name in joints)

    def only(self, joints: Sequence[int], values: Array | float) -> Array:
        """`values` for some joints, zero for the others, shape (N,)."""
        kept = np.zeros(self.robot.n_joints)
        kept[list(joints)] = np.broadcast_to(values, kept.shape)[list(joints)]
        return kept

    def joint_side(self, motor: Array | float) -> Array:
        """Way or speed of each joint that turns its own motor by `motor` [rad], shape (N,), without direction."""
        way: Array = motor / np.abs(self.robot.drive.gear_ratio)
        return way

    @property
    def motor_speed(self) -> Array:
        """Speed of each motor at the largest speed that a protocol uses [rad/s], shape (N,)."""
        speed: Array = FASTEST * self.robot.kinematics.max_speed * np.abs(self.robot.drive.gear_ratio)
        return speed

    def keeps_tool_near(self, q: Array) -> BoolArray:
        """Whether the tool, if there is one, is near where it is at rest, for joint positions (T, N); shape (T,)."""
        if self.robot.tool is None:
            return np.ones(len(q), dtype=np.bool_)
        tip, rest = self.arm.tcp_position(q), self.arm.tcp_position(self.rest[None])
        unit, pull = np.linalg.norm(rest), np.linalg.norm(self.robot.gravity)
        down = np.divide(self.robot.gravity, pull, out=np.zeros(3), where=pull > 0)
        near: BoolArray = np.linalg.norm(tip - rest, axis=1) <= TOOL_NEARBY * unit
        return near & ((tip - rest) @ down <= TOOL_DROP * unit)

    def about(self, pose: Array, way: Array) -> Array:
        """Joint positions nearest to `pose` (N,) from which every joint can go `way` (N,) to either side.

        Raises:
            FFGymError: if the range of a joint is too small.
        """
        low, high = self.robot.kinematics.range.T
        narrow = np.flatnonzero(2 * way > high - low)
        if narrow.size:
            j = int(narrow[0])
            unit = self.robot.kinematics.units[j]
            raise FFGymError(
                f"joint {self.robot.joints[j]} would go {2 * way[j]:.4g} {unit}, more than its range of "
                f"{high[j] - low[j]:.4g} {unit}. Ask for less, or leave the joint out."
            )
        return np.clip(pose, low + way, high - way)
