"""A named part of a motion: standstill, lead-in, circle, lead-out, or any other motion."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal, Self, get_args

from ffgym.core.errors import FFGymError, check_choice, check_number

PhaseKind = Literal["standstill", "lead_in", "circle", "lead_out", "motion"]
PHASE_KINDS: tuple[PhaseKind, ...] = get_args(PhaseKind)
"""Every kind of phase."""


@dataclass(frozen=True, kw_only=True)
class Phase:
    """The rows with start <= t < end.

    The interval is half open, so that touching phases share no row and cutting a recording moves no row to another
    phase. To include the last row, end the phase one sample period after it.
    """

    label: str
    """Name, for example `circle_2`; need not be unique."""
    kind: PhaseKind
    """What the robot does."""
    start: float
    """First instant [s], on the clock of `timestamp`."""
    end: float
    """First instant after the phase [s], > start."""

    def __post_init__(self) -> None:
        if not isinstance(self.label, str) or not self.label:
            raise FFGymError(f"Phase label must be non-empty text, got {self.label!r}.")
        check_choice(f"kind of phase {self.label!r}:", self.kind, PHASE_KINDS)
        for name in ("start", "end"):
            value = check_number(f"Phase {self.label!r} {name}", getattr(self, name), unit="s")
            object.__setattr__(self, name, value)
        if self.end <= self.start:
            raise FFGymError(f"Phase {self.label!r} ends at {self.end} s, must be after its start at {self.start} s.")

    @classmethod
    def from_dict(cls, values: Any) -> Self:
        """Return the phase with the fields `values`.

        Raises:
            FFGymError: if `values` is not a dict with exactly the fields of a phase, all valid.
        """
        names = {"label", "kind", "start", "end"}
        if not isinstance(values, dict) or set(values) != names:
            raise FFGymError(f"A phase must be an object with {', '.join(sorted(names))}, got {values!r}.")
        return cls(**values)


def clipped(phases: Iterable[Phase], first: float, last: float) -> tuple[Phase, ...]:
    """Phases cut to [first, last] s, without those that vanish."""
    cut = ((phase, max(phase.start, first), min(phase.end, last)) for phase in phases)
    return tuple(replace(phase, start=start, end=end) for phase, start, end in cut if start < end)
