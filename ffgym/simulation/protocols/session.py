"""Motions of several protocols one after the other, on one clock: what a machine does in a day."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

from ffgym.core.errors import FFGymError
from ffgym.paths import Reference
from ffgym.robot import RigidArm
from ffgym.simulation.protocols.protocol import Protocol

_DIGITS = 6
"""Digits of a start on the clock of the session [s], which sums would leave unround."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SessionMotion:
    """One motion of a session."""

    reference: Reference
    """Its name differs from those of all others, also as the name of a file."""
    protocol: str
    """Name of its protocol."""
    start: float
    """When it begins, on the clock of the session [s]."""

    @property
    def end(self) -> float:
        """When it ends [s]."""
        return self.start + self.reference.duration

    @property
    def stem(self) -> str:
        """Name of its file, without suffix."""
        return re.sub(r"[^\w.-]", "_", self.reference.name)


def plan_session(arm: RigidArm, protocols: Sequence[Protocol], *, start: float = 0.0) -> list[SessionMotion]:
    """Motions of protocols for a robot, one after the other.

    Args:
        arm: the robot.
        protocols: one or more; motions of one that comes twice get numbers.
        start: when the first one begins, on the clock of the session [s], which is 0 at the time of the day that the
            machine is set up for.

    Raises:
        FFGymError: if there is no protocol, or the robot cannot make one of the motions.
    """
    if not protocols:
        raise FFGymError("There is nothing to record: name a protocol. ffgym record --list shows them.")
    motions: list[SessionMotion] = []
    for protocol in protocols:
        for scheduled in protocol.schedule(arm):
            begin = start if not motions else round(motions[-1].end + scheduled.pause, _DIGITS)
            motions.append(SessionMotion(reference=scheduled.reference, protocol=protocol.name, start=begin))
    return _with_own_names(motions)


def _with_own_names(motions: Sequence[SessionMotion]) -> list[SessionMotion]:
    """Motions whose files have names that differ, whether or not a file system tells capitals from small letters."""
    used: set[str] = set()
    named = []
    for motion in motions:
        first, count = motion.reference, 1
        while motion.stem.lower() in used:
            count += 1
            motion = replace(motion, reference=replace(first, name=f"{first.name}.{count}"))
        used.add(motion.stem.lower())
        named.append(motion)
    return named
