"""Practice of motions in iterative learning: torques and errors trial by trial, their history, and their state file."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import count, takewhile

import numpy as np

from ffgym.agents.law_files import StateFile
from ffgym.agents.torque_response import circle_rms
from ffgym.core.types import Array, IntArray
from ffgym.paths import Reference


@dataclass(frozen=True, kw_only=True, eq=False)
class Practice:
    """One motion after J trials."""

    torque: Array
    """Torque of the next trial, motor side [N m], shape (T, N)."""
    best: Array
    """Torque of the trial with the least error, shape (T, N)."""
    motion_error: Array
    """RMS length of the error over the motion, shape (J,)."""
    circle_error: Array
    """RMS length of the error on each circle, shape (J, C)."""

    @classmethod
    def begin(cls, torque: Array, n_circles: int) -> "Practice":
        """Begin with the torque of the first trial."""
        first = torque.copy()
        first[0] = 0.0  # no torque is computed before t = 0
        return cls(torque=first, best=first, motion_error=np.zeros(0), circle_error=np.zeros((0, n_circles)))

    @property
    def trials(self) -> int:
        """Number of trials J."""
        return len(self.motion_error)


def write_practices(file: StateFile, practices: Sequence[Practice]) -> None:
    """Keep practices in a file, so that an interrupted one can go on."""
    rows = ((f.name, i, practice) for i, practice in enumerate(practices) for f in fields(Practice))
    file.write({f"{name}_{i}": getattr(practice, name) for name, i, practice in rows})


def read_practices(file: StateFile) -> list[Practice]:
    """Read the practices that a file keeps; none where there is no file yet.

    Raises:
        FFGymError: if the file is damaged, or of other learning.
    """
    kept = file.read() or {}
    names = [f.name for f in fields(Practice)]
    there = takewhile(lambda i: f"{names[0]}_{i}" in kept, count())
    return [Practice(**{name: kept[f"{name}_{i}"] for name in names}) for i in there]


@dataclass(frozen=True, kw_only=True, eq=False)
class LearningHistory:
    """Errors and robot time of J trials on M motions with C circles."""

    motions: tuple[str, ...]
    circles: tuple[str, ...]
    """Motion and circle; the motion alone where it has no circle."""
    motion_error: Array
    """RMS length of the error of each motion [rad] or [m], shape (J, M)."""
    circle_error: Array
    """RMS length of the error on each circle [rad] or [m], shape (J, C)."""
    robot_seconds: Array
    """Robot time up to the end of each trial [s], shape (J,)."""

    @property
    def best(self) -> IntArray:
        """Trial whose torque is kept for each motion, shape (M,)."""
        return np.argmin(self.motion_error, axis=0)

    @classmethod
    def of(cls, references: Sequence[Reference], practices: Sequence[Practice]) -> "LearningHistory":
        """Collect the errors of practices of motions, one practice for each."""
        return cls(
            motions=tuple(reference.name for reference in references),
            circles=tuple(name for reference in references for name in circle_names(reference)),
            motion_error=np.stack([practice.motion_error for practice in practices], axis=1),
            circle_error=np.concatenate([practice.circle_error for practice in practices], axis=1),
            robot_seconds=np.arange(1.0, practices[0].trials + 1) * sum(each.duration for each in references),
        )


def circle_names(reference: Reference) -> tuple[str, ...]:
    """Name the circles whose errors are logged beside that of the motion."""
    labels = circle_rms(np.zeros((len(reference.t), 1)), reference)
    return tuple(f"{reference.name}, {label}" for label in labels)
