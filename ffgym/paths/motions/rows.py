"""Pieces of a joint reference, from rest to rest, and joining of them."""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.paths.curves import Still
from ffgym.paths.motion import MAX_STEPS
from ffgym.paths.moves import JointMove, Move, MoveJointSpline, MoveSpline, ToolMove, locate_error
from ffgym.paths.route import SHARPEST, Leg, corner_angle
from ffgym.paths.timing import TimeLaw
from ffgym.recordings import Phase, PhaseKind
from ffgym.robot import RobotDescription

APART = 1e-6
"""Largest step between the end of a piece and the start of the next [rad or m], and [rad/s or m/s] of their speeds;
chosen: inverse kinematics leave 1e-10 m, and a step of 1e-6 rad lies below what a motor resolver sees."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MoveSpan:
    """Times of a move in a motion."""

    move: Move
    start: float
    """Time [s] at which the target before it is passed."""
    end: float
    """Time [s] at which its own target is passed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ReferencePiece:
    """Samples of a piece at every control step, the first and the last of which belong to its neighbours as well."""

    q: Array
    """Link side [rad or m], shape (T, N)."""
    dq: Array
    """Shape (T, N)."""
    ddq: Array
    """Shape (T, N)."""
    phases: tuple[Phase, ...]
    """Phases on the clock of the piece."""
    spans: tuple[MoveSpan, ...] = ()
    """Times of its moves on the clock of the piece; moves that go nowhere have none."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Step:
    """A move and the leg that it makes, in space or in units of the joints' largest speeds."""

    move: ToolMove | JointMove
    leg: Leg
    stops: bool
    """True if the robot rests at the target."""


def add_step(steps: list[Step], move: ToolMove | JointMove, leg: Leg | None) -> None:
    """Add the step of a move; one that goes nowhere makes none, but may stop the robot."""
    if leg is not None:
        steps.append(Step(move=move, leg=leg, stops=move.zone.stops))
    elif steps and move.zone.stops:
        steps[-1] = replace(steps[-1], stops=True)


def split_steps(steps: Sequence[Step]) -> tuple[list[list[Step]], list[str]]:
    """Groups of steps between which the robot stops, and a note for each stop that was not asked for."""
    groups, notes = [[step] for step in steps[:1]], []
    for before, after in itertools.pairwise(steps):
        why = _no_corner(before, after)
        if before.stops or why:
            groups.append([after])
        else:
            groups[-1].append(after)
        if why and not before.stops:
            notes.append(str(locate_error(before.move, f"the robot stops at {before.move.label!r}, because {why}")))
    return groups, notes


def _no_corner(before: Step, after: Step) -> str:
    """Why the path cannot go round the corner between two steps; empty if it can."""
    steps = (before, after)
    if any(isinstance(step.move, MoveSpline | MoveJointSpline) for step in steps):
        return "a spline starts and ends at rest"
    if any(isinstance(step.leg.curve, Still) for step in steps):
        return "the tool turns on the spot"
    if corner_angle(before.leg.curve, after.leg.curve) > SHARPEST:
        return "the joints turn back there" if isinstance(before.move, JointMove) else "the path turns back there"
    return ""


def rest(q: Array, duration: float, dt: float, label: str, move: Move | None = None) -> ReferencePiece:
    """Rest at `q` (N,) for `duration` [s], up to the next sample; `move` is what asks for it, if it is one."""
    count = _sample_count(duration, dt)
    still = np.zeros((count, len(q)))
    phase = Phase(label=label, kind="standstill", start=0.0, end=(count - 1) * dt)
    spans = () if move is None else (MoveSpan(move=move, start=0.0, end=phase.end),)
    return ReferencePiece(q=still + q, dq=still, ddq=still, phases=(phase,), spans=spans)


def _sample_count(duration: float, dt: float) -> int:
    """Samples every `dt` [s] from 0 up to the first at or after `duration` [s]."""
    steps = duration / dt
    if not steps <= MAX_STEPS:
        raise FFGymError(f"The motion would last {duration:.6g} s, must be at most {MAX_STEPS:g} steps of {dt} s.")
    return int(np.ceil(steps - 1e-9)) + 1


def rows_along(
    law: TimeLaw,
    path: Callable[[Array], tuple[Array, Array, Array]],
    targets: Array,
    phases: Sequence[tuple[str, PhaseKind]],
    passed: Sequence[tuple[Move, float]],
    dt: float,
) -> ReferencePiece:
    """Samples of a path that is run by a time law, up to the first at or after its end.

    `path` gives joint positions and their first two derivatives by path length, (T, N) each. Each of the `phases`, a
    label and a kind, ends where the path passes its target, at path lengths of shape (L,). `passed` are all moves with
    the path lengths at their targets.
    """
    t = np.arange(_sample_count(law.duration, dt), dtype=np.float64) * dt
    s, speed, acceleration = law.at(t)
    q, first, second = path(s)
    times = [0.0, *(law.time_of(float(target)) for target in targets[:-1]), float(t[-1])]
    marks = [0.0, *(law.time_of(float(length)) for _, length in passed)]
    return ReferencePiece(
        q=q,
        dq=first * speed[:, None],
        ddq=first * acceleration[:, None] + second * speed[:, None] ** 2,
        phases=tuple(
            Phase(label=label, kind=kind, start=start, end=end)
            for (label, kind), start, end in zip(phases, times, times[1:], strict=False)
        ),
        spans=tuple(
            MoveSpan(move=move, start=start, end=end)
            for (move, _), start, end in zip(passed, marks, marks[1:], strict=False)
        ),
    )


def join_spans(pieces: Sequence[ReferencePiece], dt: float) -> list[MoveSpan]:
    """Times of all moves on the clock of the pieces one after the other."""
    spans, count = [], 0
    for piece in pieces:
        spans += [replace(s, start=s.start + count * dt, end=s.end + count * dt) for s in piece.spans]
        count += len(piece.q) - 1
    return spans


def join_pieces(name: str, robot: RobotDescription, pieces: Sequence[ReferencePiece]) -> Reference:
    """Join pieces that follow each other to one reference."""
    dt = robot.servo.control_dt
    for before, after in itertools.pairwise(pieces):
        last, first = before.dq[-1], after.dq[0]
        j = int(np.argmax(np.abs(first - last)))
        if abs(first[j] - last[j]) > APART:
            unit = robot.kinematics.units[j]
            raise FFGymError(
                f"{after.phases[0].label!r} starts with joint {robot.joints[j]} at {first[j]:.6g} {unit}/s, but what "
                f"comes before ends at {last[j]:.6g} {unit}/s. A motion that starts or ends at speed must be alone."
            )
    counts = np.cumsum([0, *(len(piece.q) - 1 for piece in pieces)])
    phases: list[Phase] = []
    for count, piece in zip(counts, pieces, strict=False):
        for p in piece.phases:
            start, end = p.start + float(count) * dt, p.end + float(count) * dt
            start = max(start, phases[-1].end) if phases else start  # sums of times are rounded
            phases.append(Phase(label=p.label, kind=p.kind, start=start, end=end))
    series = {
        part: np.concatenate([getattr(pieces[0], part)[:1], *(getattr(piece, part)[1:] for piece in pieces)])
        for part in ("q", "dq", "ddq")
    }
    t = np.arange(int(counts[-1]) + 1, dtype=np.float64) * dt
    return Reference(name=name, robot=robot, t=t, phases=tuple(phases), **series)
