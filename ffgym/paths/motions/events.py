"""Events of a program in time: when, and where on the path of the tool, outputs are set and the like."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.paths.motions.rows import MoveSpan
from ffgym.paths.moves import Move, PathEvent
from ffgym.robot import RigidArm


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionEvent:
    """Something that a program does on the way beside moving."""

    t: float
    """Time [s] on the clock of the motion."""
    position: Array | None
    """TCP in the world [m], shape (3,); None for a robot without tool."""
    text: str
    """The instruction, e.g. 'SetDO doLaser, 1'."""
    where: str
    """Place in the program, e.g. 'cut.mod:12:5'."""

    def __str__(self) -> str:
        place = "" if self.position is None else " at [" + ", ".join(f"{1e3 * x:.1f}" for x in self.position) + "] mm"
        return f"{self.t:.3f} s{place}: {self.text} ({self.where})"


def locate_events(
    arm: RigidArm, moves: Sequence[Move], spans: Sequence[MoveSpan], reference: Reference
) -> tuple[MotionEvent, ...]:
    """Locate the events of moves on a reference, in the order of time.

    Distances count along the path of the tool as it is run, with its corners rounded. What is asked for before the
    start of a move, or behind its target, happens at its start, or its target. A move that goes nowhere has its events
    where the one before it ends.
    """
    if not any(move.events for move in moves):
        return ()
    times = {span.move: (span.start, span.end) for span in spans}
    found: list[MotionEvent] = []
    last = float(spans[0].start) if spans else 0.0
    for move in moves:
        start, end = times.get(move, (last, last))
        for event in move.events:
            t = min(max(_time_of(arm, event, start, end, reference) - event.lead, 0.0), reference.duration)
            found.append(MotionEvent(t=t, position=_position(arm, reference, t), text=event.text, where=event.where))
        last = end
    return tuple(sorted(found, key=lambda event: event.t))


def _time_of(arm: RigidArm, event: PathEvent, start: float, end: float, reference: Reference) -> float:
    """Time [s] at which the tool has the distance of an event from the start or the target of its move."""
    if event.distance == 0 or arm.robot.tool is None or end <= start:
        return start if event.from_start else end
    inside = (reference.t > start) & (reference.t < end)
    t = np.concatenate([[start], reference.t[inside], [end]])
    q = np.column_stack([np.interp(t, reference.t, column) for column in reference.q.T])
    steps = np.linalg.norm(np.diff(arm.tcp_position(q), axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = event.distance if event.from_start else length[-1] - event.distance
    return float(np.interp(wanted, length, t))


def _position(arm: RigidArm, reference: Reference, t: float) -> Array | None:
    if arm.robot.tool is None:
        return None
    q = np.array([[np.interp(t, reference.t, column) for column in reference.q.T]])
    position: Array = arm.tcp_position(q)[0]
    return position
