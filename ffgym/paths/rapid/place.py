"""Place of the robot between two statements, for the functions that ask for it."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths.rapid import targets
from ffgym.paths.rapid.geometry import to_orient
from ffgym.paths.rapid.predefined import DESCRIBED_TOOL, TOOL0, WOBJ0
from ffgym.paths.rapid.records import Value
from ffgym.paths.rapid.targets import MILLIMETRE, UNUSED_AXIS, Frame
from ffgym.robot import RigidArm, RobotDescription, solve_pose

_NO_AXES = (UNUSED_AXIS,) * 6


@dataclass
class RobotPlace:
    """Place to which the last move has led: a pose of the flange, or joint positions."""

    robot: RobotDescription
    flange: Frame | None = None
    """Pose of tool0 in the world; None after a move to joint positions, and before the first move."""
    joints: Array | None = None
    """Joint positions, link side [rad or m], shape (N,); None after a move to a pose."""
    tool: Value = TOOL0
    work_object: Value = WOBJ0
    turns: Value = field(default=(0.0, 0.0, 0.0, 0.0))
    """robconf of the last target."""

    @cached_property
    def _arm(self) -> RigidArm:
        if self.robot.tool is None:
            raise FFGymError(f"robot {self.robot.name!r} has no flange, so targets cannot be computed from its joints.")
        return RigidArm(self.robot)

    def tool_frame(self, tool: Value) -> Frame:
        """Frame of a tooldata in tool0, that of the described tool as well."""
        if tool == DESCRIBED_TOOL and self.robot.tool is not None:
            return Frame(position=self.robot.tool.tcp, rotation=np.eye(3))
        return targets.tool_frame(tool)

    def target(self, tool: Value | None, work_object: Value | None) -> Value:
        """Robtarget of the place, of the tool and in the work object of the last move unless others are given."""
        flange = self._solve_forward(self.joints) if self.flange is None and self.joints is not None else self.flange
        if flange is None:
            raise FFGymError("the robot's place is not known before the first move; begin with MoveAbsJ or MoveJ.")
        held = self.tool if tool is None else tool
        return self._write_target(flange, held, self.work_object if work_object is None else work_object)

    def joint_target(self) -> Value:
        """Jointtarget of the place."""
        if self.joints is None and self.flange is None:
            raise FFGymError("the robot's place is not known before the first move; begin with MoveAbsJ or MoveJ.")
        if self.joints is None:
            assert self.flange is not None
            return self._write_joints(self._solve_backward(self.flange))
        return self._write_joints(self.joints)

    def calculate_target(self, joint_target: Value, tool: Value, *, work_object: Value) -> Value:
        """Robtarget of joint positions (CalcRobT)."""
        q = targets.joint_positions(joint_target, self.robot.kinematics.is_sliding, "the joint target")
        return self._write_target(self._solve_forward(q), tool, work_object)

    def calculate_joints(self, target: Value, tool: Value, *, work_object: Value) -> Value:
        """Jointtarget of a robtarget (CalcJointT)."""
        held = self.tool_frame(tool)
        pose = targets.pose(target, "the target", held, work_object)
        assert pose.rotation is not None
        flange = Frame(position=pose.position - pose.rotation @ held.position, rotation=pose.rotation)
        return self._write_joints(self._solve_backward(flange))

    def _write_target(self, flange: Frame, tool: Value, work_object: Value) -> Value:
        inside = targets.object_frame(work_object).inverse().place(flange.place(self.tool_frame(tool)))
        return (
            tuple((inside.position / MILLIMETRE).tolist()),
            to_orient(inside.rotation),
            self.turns,
            _NO_AXES,
        )

    def _write_joints(self, q: Array) -> Value:
        sliding = self.robot.kinematics.is_sliding
        values = np.where(sliding, q / MILLIMETRE, np.rad2deg(q)).tolist()
        return ((*values, *(0.0,) * (6 - len(values))), _NO_AXES)

    def _solve_forward(self, q: Array) -> Frame:
        position, rotation = (part[0] for part in self._arm.tcp_pose(q[None]))
        assert self.robot.tool is not None
        return Frame(position=position - rotation @ self.robot.tool.tcp, rotation=rotation)

    def _solve_backward(self, flange: Frame) -> Array:
        arm, area = self._arm, self.robot.work_area
        assert self.robot.tool is not None
        seed = self.robot.kinematics.range.mean(axis=1) if area is None else area.home
        return solve_pose(arm, flange.position + flange.rotation @ self.robot.tool.tcp, flange.rotation, seed)
