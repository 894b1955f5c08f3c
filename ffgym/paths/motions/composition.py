"""Moves between targets as one joint reference: what a controller's motion planner does."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape, errors_at
from ffgym.core.types import Array
from ffgym.paths import Reference, cartesian_reference, joint_reference
from ffgym.paths.circles import DWELL
from ffgym.paths.limits import MotionLimits
from ffgym.paths.motion import JointPath
from ffgym.paths.motions.events import MotionEvent, locate_events
from ffgym.paths.motions.joint_run import check_range, joint_steps, run_joints
from ffgym.paths.motions.rows import APART, ReferencePiece, join_pieces, join_spans, rest, split_steps
from ffgym.paths.motions.tool_run import run_tool, tool_runs
from ffgym.paths.moves import (
    JointMove,
    Move,
    MoveJoint,
    MoveJointSpline,
    MoveLinear,
    MoveSpline,
    MoveTimed,
    Pose,
    ToolMove,
    Wait,
    locate_error,
)
from ffgym.paths.rapid import find_unreachable, join_errors, load_program, on_branches
from ffgym.robot import RigidArm, solve_pose


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """A joint reference made from moves, a file or a name."""

    reference: Reference
    """Its `robot` is the one it is for: a program may bring its own tool."""
    notes: tuple[str, ...] = ()
    """Differences from the requested motion, and their reasons, e.g. a stop where a corner cannot be rounded."""
    events: tuple[MotionEvent, ...] = ()
    """What else happens on the way, such as outputs that a program sets, in the order of time."""


def _space_of(move: Move) -> Literal["tool", "joints"] | None:
    """Space in which the path of a move is given; None for a move without a path."""
    if isinstance(move, ToolMove):
        return "tool"
    return "joints" if isinstance(move, JointMove) else None


@dataclass(kw_only=True, eq=False)
class Planner:
    """State of the composition: pieces so far, and the position of the robot behind them."""

    arm: RigidArm
    limits: MotionLimits
    free: bool
    """True if the orientation of the tool is free."""
    q: Array | None
    """Joint positions where the last group ended, link side, shape (N,); None before the first."""
    pieces: list[ReferencePiece] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def plan(self, group: Sequence[Move]) -> None:
        """Plan moves that belong together, see `_space_of`; an error begins with the place of the move."""
        first = group[0]
        if isinstance(first, MoveTimed):
            self._run_timed(first)
            return
        if self.q is None:
            self.q = self._start(first)
            group = group if isinstance(first, MoveSpline | MoveJointSpline) else group[1:]
        if isinstance(first, Wait):
            self._add([rest(self.q, first.duration, self.arm.robot.servo.control_dt, first.label, first)])
        elif _space_of(first) == "joints":
            self._run_joints([move for move in group if isinstance(move, JointMove)], self.q)
        else:
            self._run_tool([move for move in group if isinstance(move, ToolMove)], self.q)

    def _add(self, pieces: Sequence[ReferencePiece]) -> None:
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
            raise locate_error(
                move, "An arc or a wait cannot come first; say where the robot starts, or move there first."
            )
        pose = move.through[0] if isinstance(move, MoveSpline) else move.to
        assert isinstance(pose, Pose)
        fixed = None if area is None else area.tool_rotation
        return self._solve(move, pose, fixed, limits.mean(axis=1) if area is None else area.home)

    def _solve(self, move: Move, pose: Pose, before: Array | None, seed: Array) -> Array:
        """Solve joint positions for a pose, near `seed`; `before` is the orientation that a pose without one keeps."""
        rotation = before if pose.rotation is None else pose.rotation
        with errors_at(move.where):
            return solve_pose(self.arm, pose.position, rotation, seed)

    def _rotation(self, q: Array) -> Array | None:
        """Orientation of tool0 at `q` (N,), shape (3, 3); None where it is free."""
        return None if self.free else self.arm.tcp_pose(q[None])[1][0]

    def _run_joints(self, moves: Sequence[JointMove], q: Array) -> None:
        targets: list[Array] = []  # joint positions (K, N) of each move
        for move in moves:
            last = targets[-1][-1] if targets else q
            if isinstance(move, MoveJointSpline):
                targets.append(move.through)
            elif isinstance(move.to, Pose):
                targets.append(self._solve(move, move.to, self._rotation(last), last)[None])
            else:
                targets.append(np.atleast_2d(move.to))
        groups, notes = split_steps(joint_steps(self.arm, moves, targets, q))
        self._add([run_joints(self.arm, steps, self.limits) for steps in groups])
        self.notes += notes

    def _run_tool(self, moves: Sequence[ToolMove], q: Array) -> None:
        if self.arm.robot.tool is None:
            raise locate_error(
                moves[0], f"Robot {self.arm.robot.name!r} has no tool, so it has no TCP; move its joints."
            )
        runs, notes = tool_runs(moves, self.arm.tcp_position(q[None])[0], self._rotation(q))
        for run in runs:
            rows = run_tool(self.arm, run, q, self.limits)
            self._add([rows])
            q = rows.q[-1]
        self.notes += notes

    def _run_timed(self, move: MoveTimed) -> None:
        robot = self.arm.robot
        with errors_at(move.where):
            path = move.path(self.q, robot.servo.control_dt)
            if isinstance(path, JointPath):
                reference = joint_reference(robot, path)
            else:
                reference = cartesian_reference(self.arm, path, seed=self.q)
        if self.q is not None and not np.allclose(reference.q[0], self.q, rtol=0, atol=APART):
            raise locate_error(
                move,
                f"{move.label!r} starts at joint positions {np.round(reference.q[0], 6).tolist()}, but the robot is at "
                f"{np.round(self.q, 6).tolist()}. Move there before.",
            )
        self._add([ReferencePiece(q=reference.q, dq=reference.dq, ddq=reference.ddq, phases=reference.phases)])


def compose(
    arm: RigidArm,
    moves: Sequence[Move],
    *,
    start: Array | None = None,
    limits: MotionLimits | None = None,
    dwell: float = DWELL,
    name: str = "moves",
) -> Motion:
    """Joint reference that carries out moves one after the other, from rest to rest.

    Corners with a zone are rounded, in space between moves of the tool and in joint space between moves of the joints.
    The robot stops where a move of the joints meets one of the tool, around splines and where the tool turns on the
    spot; notes say where that was not asked for. What ends between two samples is held until the next one.

    Args:
        arm: the robot.
        moves: one or more.
        start: joint positions at the start, link side [rad or m], shape (N,); None starts at the first target.
        limits: of speed, acceleration and jerk, beside the programmed speeds; None takes the defaults.
        dwell: rest before the first and after the last move [s], >= 0; a motion that brings its own rests gets none.
        name: name of the motion.

    Raises:
        FFGymError: if a move cannot be made; the message begins with the move's `where`.
    """
    check_number("dwell", dwell, unit="s", low=0.0)
    if not moves:
        raise FFGymError(f"Motion {name!r} has no moves; give at least one.")
    labelled = [move if move.label else replace(move, label=f"move {i}") for i, move in enumerate(moves, start=1)]
    q = None if start is None else check_shape("start", start, (arm.robot.n_joints,))
    # whether the orientation of the tool is left open: neither the work area nor any target
    poses = [pose for move in labelled for pose in (getattr(move, "to", None), *getattr(move, "through", ()))]
    area = arm.robot.work_area
    free = not any(isinstance(pose, Pose) and pose.rotation is not None for pose in poses)
    free = free and (area is None or area.tool_rotation is None)
    planner = Planner(arm=arm, limits=limits or MotionLimits(), free=free, q=q)
    # moves of the tool, or of the joints, that follow each other are planned together, any other one alone
    groups: list[list[Move]] = []
    for move in labelled:
        space = _space_of(move)
        if space and groups and _space_of(groups[-1][-1]) == space:
            groups[-1].append(move)
        else:
            groups.append([move])
    for group in groups:
        planner.plan(group)
    # notes on zones at which the robot stops all the same, because what comes next is planned on its own
    stops = [
        str(locate_error(last, f"the robot stops at {last.label!r}, because a corner joins moves of one kind only"))
        for last in (group[-1] for group in groups[:-1])
        if _space_of(last) and not last.zone.stops
    ]
    pieces = _with_rests(planner.pieces, planner.q, dwell, arm.robot.servo.control_dt)
    reference = join_pieces(name, arm.robot, pieces)
    events = locate_events(arm, labelled, join_spans(pieces, arm.robot.servo.control_dt), reference)
    return Motion(reference=reference, notes=(*planner.notes, *stops), events=events)


def _with_rests(pieces: Sequence[ReferencePiece], q: Array | None, dwell: float, dt: float) -> list[ReferencePiece]:
    """Pieces with a rest before and after, unless a rest is there already or the robot is moving."""
    if not pieces:  # the only move said where to be
        assert q is not None
        return [rest(q, max(dwell, dt), dt, "rest 0")]
    rows = list(pieces)
    if dwell > 0 and rows[0].phases[0].kind != "standstill" and np.abs(rows[0].dq[0]).max() <= APART:
        rows.insert(0, rest(rows[0].q[0], dwell, dt, "rest 0"))
    if dwell > 0 and rows[-1].phases[-1].kind != "standstill" and np.abs(rows[-1].dq[-1]).max() <= APART:
        rows.append(rest(rows[-1].q[-1], dwell, dt, "rest 1"))
    return rows


def rapid_motion(
    arm: RigidArm,
    path: str | Path,
    *,
    entry: str | None = None,
    limits: MotionLimits | None = None,
    inputs: Mapping[str, float] | None = None,
    cycles: int = 1,
) -> Motion:
    """Motion of procedure `entry` of a program, for the robot with its tool; it starts at the first target.

    Args:
        arm: the robot.
        path: a program, or the list of its modules.
        entry: name of the procedure; None takes main, or the only one.
        limits: of speed, acceleration and jerk; None takes the defaults.
        inputs: values of inputs by name; others are 0 until the program waits for them.
        cycles: passes through a loop that never ends.

    Raises:
        FFGymError: if the program cannot be read or run, or the robot cannot make its moves; a line for each error.
    """
    execution = load_program(path).execute(arm.robot, entry, inputs=inputs, cycles=cycles)
    if execution.robot is not arm.robot:
        arm = RigidArm(execution.robot)
    moves, notes = on_branches(arm, execution)
    try:
        motion = compose(arm, moves, limits=limits, name=Path(path).stem)
    except FFGymError as error:
        raise join_errors([error, *find_unreachable(arm, moves, error)]) from error
    counts = Counter((*execution.notes, *notes, *motion.notes))
    return replace(motion, notes=tuple(note if n == 1 else f"{note} ({n} times)" for note, n in counts.items()))
