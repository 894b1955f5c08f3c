"""What model feed-forward remembers from sample to sample, and how it goes into one array."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from ffgym.agents.effects.springs import Carried
from ffgym.agents.elasticity.lead import Lead
from ffgym.core.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Start:
    """The rest before the motion, from which everything counts, (..., N) each."""

    load: Array
    """Torque that gearboxes pass on [N m], link side."""
    bend: Array
    """Torque of linear springs that bend as far [N m], link side."""
    added: Array
    """What effects add to the motors [N m], motor side."""
    error: Array
    """What resolvers read beyond the true angle [rad], motor side."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Past:
    """What is remembered when the torque for a sample is asked for, (..., N) each."""

    start: Start
    carried: tuple[Carried, ...]
    """At the samples around this one that are known, 2 w of them."""
    time: Array
    """Of this sample since the motion began [s], as are all that follow."""
    lead: Lead
    integral: Array
    """Of what the servo sees of the lead [rad s], link side."""
    bristle: Array
    """Deflection of the bristles [rad]."""
    lost: Array
    """Part of friction, less what effects add, of the step before [N m]."""
    springs: list[Array]
    """What effects on springs and links remember at the newest sample, (..., N, M) each."""
    motors: list[Array]
    """What effects on motors remember, (..., N, M) each."""

    def packed(self) -> Array:
        """As one array (..., K)."""
        rows = [*_columns(self.start), *(row for each in self.carried for row in _columns(each))]
        rows += [self.time, *_columns(self.lead), self.integral, self.bristle, self.lost]
        flat = [memory.reshape(*memory.shape[:-2], -1) for memory in (*self.springs, *self.motors)]
        return np.concatenate([*rows, *flat], axis=-1)


def unpacked(memory: Array, n: int, samples: int, springs: Sequence[int], motors: Sequence[int]) -> Past:
    """What was `packed`, of N joints, with carried torques at so many samples, and effects that remember so much."""
    n_rows = len(fields(Start)) + samples * len(fields(Carried)) + 1 + len(fields(Lead)) + 3
    ends = np.cumsum([n * n_rows, *(n * length for length in (*springs, *motors))])
    first, *others = np.split(memory, ends[:-1], axis=-1)
    rows = iter([first[..., k * n : (k + 1) * n] for k in range(n_rows)])
    kept = [part.reshape(*part.shape[:-1], n, -1) for part in others]
    return Past(
        start=Start(**{f.name: next(rows) for f in fields(Start)}),
        carried=tuple(Carried(**{f.name: next(rows) for f in fields(Carried)}) for _ in range(samples)),
        time=next(rows),
        lead=Lead(**{f.name: next(rows) for f in fields(Lead)}),
        integral=next(rows),
        bristle=next(rows),
        lost=next(rows),
        springs=kept[: len(springs)],
        motors=kept[len(springs) :],
    )


def _columns(parts: Start | Carried | Lead) -> list[Array]:
    return [getattr(parts, f.name) for f in fields(parts)]
