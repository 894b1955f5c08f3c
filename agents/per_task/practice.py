"""How far per-task learning has come with each motion, and the file that keeps it between program runs."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from ffgym.agents.common.law_files import FORMAT, pack, unpack
from ffgym.core.errors import FFGymError
from ffgym.core.files import check_writable, write_bytes
from ffgym.core.types import Array

_KIND = "practice"
"""Kind of the state file, beside those of laws."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Practice:
    """One motion after J trials."""

    torque: Array
    """To be tried next, motor side [N m], shape (T, N)."""
    best: Array
    """The one that did best, shape (T, N)."""
    motion_error: Array
    """RMS length of the error over the motion, shape (J,)."""
    circle_error: Array
    """The same on each circle, shape (J, C)."""

    @classmethod
    def begin(cls, torque: Array, n_circles: int) -> "Practice":
        """Nothing tried yet."""
        first = torque.copy()
        first[0] = 0.0  # no torque is computed before t = 0
        return cls(torque=first, best=first, motion_error=np.zeros(0), circle_error=np.zeros((0, n_circles)))

    def tried(self, motion_error: float, circle_error: Sequence[float], following: Array) -> "Practice":
        """After a trial of `torque` with these errors; `following` is to be tried next."""
        is_best = not (motion_error >= self.motion_error).any()
        return Practice(
            torque=following,
            best=self.torque if is_best else self.best,
            motion_error=np.append(self.motion_error, motion_error),
            circle_error=np.vstack([self.circle_error, circle_error]),
        )

    @property
    def trials(self) -> int:
        """Number of trials J."""
        return len(self.motion_error)


@dataclass(frozen=True)
class StateFile:
    """Practices on disk, written whole or not at all."""

    path: Path
    fingerprint: str
    """Of the learning it belongs to."""

    def __post_init__(self) -> None:
        check_writable(self.path)

    def write(self, practices: Sequence[Practice]) -> None:
        """Replace the file."""
        arrays = {f"{f.name}_{i}": getattr(practice, f.name) for i, practice in enumerate(practices) for f in _FIELDS}
        write_bytes(self.path, pack({"format": FORMAT, "kind": _KIND, "fingerprint": self.fingerprint}, arrays))

    def read(self, beginning: Sequence[Practice]) -> list[Practice]:
        """Practices of the file, or `beginning` where there is no file yet.

        Raises:
            FFGymError: if the file is damaged, or of other learning.
        """
        if not self.path.exists():
            return list(beginning)
        header, arrays = unpack(self.path)
        if header.get("kind") != _KIND or header.get("fingerprint") != self.fingerprint:
            raise FFGymError(
                f"{self.path} is the state of other learning: another target, tolerance, first torque, robot model or "
                f"other motions. Go on with the same, or give another file."
            )
        return [Practice(**{f.name: arrays[f"{f.name}_{i}"] for f in _FIELDS}) for i in range(len(beginning))]


_FIELDS = fields(Practice)
