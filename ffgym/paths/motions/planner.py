"""Plans moves group after group, and remembers where the robot is."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths import cartesian_reference, joint_reference
from ffgym.paths.limits import MotionLimits
from ffgym.paths.motion import JointPath
from ffgym.paths.motions.joint_run import JointMove, check_range, joint_steps, run_joints, split_joints
from ffgym.paths.motions.rows import APART, Rows, rest
from ffgym.paths.motions.tool_legs import ToolMove, tool_runs
from ffgym.paths.motions.tool_run import run_tool
from ffgym.paths.moves import (
    Move,
    MoveArc,
    MoveJoint,
    MoveJointSpline,
    MoveLinear,
    MoveSpline,
    MoveTimed,
    Pose,
    Wait,
    located,
)
from ffgym.robot import RigidArm, solve_pose


def space_of(move: Move) -> Literal["tool", "joints"] | None:
    """Where the path of a move is given; None for what is neither."""
    if isinstance(move, MoveLinear | MoveArc | MoveSpline):
        return "tool"
    return "joints" if isinstance(move, JointMove) else None


@dataclass(kw_only=True, eq=False)
class Planner:
    """Where the robot is, and what it has done until then."""

    arm: RigidArm
    limits: MotionLimits
    free: bool
    """Whether the orientation of the tool does not matter."""
    q: Array | None
    """Joint positions where the last group ended, link side, shape (N,); None before the first."""
    pieces: list[Rows] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def plan(self, group: Sequence[Move]) -> None:
        """Plan moves that belong together, see `space_of`.

        Raises:
            FFGymError: if one cannot be made; the message begins with its place.
        """
        first = group[0]
        if isinstance(first, MoveTimed):
            self._run_timed(first)
            return
        if self.q is None:
            self.q = self._start(first)
            group = group if isinstance(first, MoveSpline | MoveJointSpline) else group[1:]
        if isinstance(first, Wait):
            self._add([rest(self.q, first.duration, self.arm.robot.servo.control_dt, first.label)])
        elif space_of(first) == "joints":
            self._run_joints([move for move in group if isinstance(move, JointMove)], self.q)
        else:
            self._run_tool([move for move in group if isinstance(move, ToolMove)], self.q)

    def _add(self, pieces: Sequence[Rows]) -> None:
        self.pieces += pieces
        if pieces:
            self.q = pieces[-1].q[-1]

    def _start(self, move: Move) -> Array:
        """Joint positions at the target of the first move, which is where the motion starts."""
        area, limits = self.arm.robot.work_area, self.arm.robot.kinematics.range
        if isinstance(move, JointMove):
            target = move.through[0] if isinstance(move, MoveJointSpline) else move.to
            if not isinstance(target, Pose):
                check_range(self.arm, move, target)
                return target
        if not isinstance(move, MoveLinear | MoveJoint | MoveSpline):
            raise located(move, "An arc or a wait cannot come first; say where the robot starts, or move there first.")
        pose = move.through[0] if isinstance(move, MoveSpline) else move.to
        assert isinstance(pose, Pose)
        fixed = None if area is None else area.tool_rotation
        return self._solved(move, pose, fixed, limits.mean(axis=1) if area is None else area.home)

    def _solved(self, move: Move, pose: Pose, before: Array | None, seed: Array) -> Array:
        """Joint positions for a pose, near `seed`; `before` is the orientation that a pose without one keeps."""
        rotation = before if pose.rotation is None else pose.rotation
        try:
            return solve_pose(self.arm, pose.position, rotation, seed)
        except FFGymError as error:
            raise located(move, str(error)) from error

    def _rotation(self, q: Array) -> Array | None:
        """Orientation of tool0 at `q` (N,), shape (3, 3); None where it is free."""
        return None if self.free else self.arm.tcp_pose(q[None])[1][0]

    def _run_joints(self, moves: Sequence[JointMove], q: Array) -> None:
        targets: list[Array] = []
        for move in moves:
            targets.append(self._through(move, targets[-1][-1] if targets else q))
        groups, notes = split_joints(joint_steps(self.arm, moves, targets, q))
        self._add([run_joints(self.arm, steps, self.limits) for steps in groups])
        self.notes += notes

    def _through(self, move: JointMove, last: Array) -> Array:
        """Joint positions (K, N) of a move that begins at `last` (N,)."""
        if isinstance(move, MoveJointSpline):
            return move.through
        if isinstance(move.to, Pose):
            return self._solved(move, move.to, self._rotation(last), last)[None]
        return np.atleast_2d(move.to)

    def _run_tool(self, moves: Sequence[ToolMove], q: Array) -> None:
        if self.arm.robot.tool is None:
            raise located(moves[0], f"Robot {self.arm.robot.name!r} has no tool, so it has no TCP; move its joints.")
        runs, notes = tool_runs(moves, self.arm.tcp_position(q[None])[0], self._rotation(q))
        for run in runs:
            rows = run_tool(self.arm, run, q, self.limits)
            self._add([rows])
            q = rows.q[-1]
        self.notes += notes

    def _run_timed(self, move: MoveTimed) -> None:
        robot = self.arm.robot
        try:
            path = move.path(self.q, robot.servo.control_dt)
            if isinstance(path, JointPath):
                reference = joint_reference(robot, path)
            else:
                reference = cartesian_reference(self.arm, path, seed=self.q)
        except FFGymError as error:
            raise located(move, str(error)) from error
        if self.q is not None and not np.allclose(reference.q[0], self.q, rtol=0, atol=APART):
            raise located(
                move,
                f"{move.label!r} starts at joint positions {np.round(reference.q[0], 6).tolist()}, but the robot is at "
                f"{np.round(self.q, 6).tolist()}. Move there before.",
            )
        self._add([Rows(q=reference.q, dq=reference.dq, ddq=reference.ddq, phases=reference.phases)])
