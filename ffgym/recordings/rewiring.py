"""Corrections of wrongly wired columns: of another joint, sign, unit, zero or time; and recordings that have them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Self, final

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray
from ffgym.recordings.header import clipped
from ffgym.recordings.recording import Recording
from ffgym.recordings.schema import FAMILIES

_WHOLE = 1e-3
"""Difference from a whole number of rows that a delay of whole rows may have: samples then move."""


@final
@dataclass(frozen=True, kw_only=True)
class Rewire:
    r"""Correction of one family with P columns: right_p(t) = factor_p given_{source_p}(t + delay_p) + offset_p."""

    source: tuple[int, ...]
    """Which of the given columns of the family holds the numbers of each, shape (P,)."""
    factor: tuple[float, ...]
    """Shape (P,)."""
    offset: tuple[float, ...]
    """In the unit of the family, shape (P,)."""
    delay: tuple[float, ...]
    """By which the given samples come late [s], shape (P,)."""

    @classmethod
    def none(cls, n_parts: int) -> Self:
        """Correction that leaves a family as it is."""
        return cls(
            source=tuple(range(n_parts)), factor=(1.0,) * n_parts, offset=(0.0,) * n_parts, delay=(0.0,) * n_parts
        )

    @property
    def is_none(self) -> bool:
        """Whether nothing is changed."""
        return self == Rewire.none(len(self.source))

    def scaled(self, parts: Sequence[int], factors: Sequence[float]) -> "Rewire":
        """Numbers of `parts` times `factors` in addition."""
        factor, offset = list(self.factor), list(self.offset)
        for part, by in zip(parts, factors, strict=True):
            factor[part] *= by
            offset[part] *= by
        return replace(self, factor=tuple(factor), offset=tuple(offset))

    def moved(self, parts: Sequence[int], offset: float) -> "Rewire":
        """Numbers of `parts` plus `offset` in addition."""
        return replace(self, offset=tuple(o + offset * (p in parts) for p, o in enumerate(self.offset)))

    def delayed(self, parts: Sequence[int], delay: float) -> "Rewire":
        """Numbers of `parts` taken `delay` [s] later in addition."""
        return replace(self, delay=tuple(d + delay * (p in parts) for p, d in enumerate(self.delay)))

    def permuted(self, order: Sequence[int]) -> "Rewire":
        """Part p is what part `order[p]` was until now."""
        return Rewire(**{name: tuple(values[p] for p in order) for name, values in vars(self).items()})

    def then(self, later: "Rewire") -> "Rewire":
        """Both corrections in one, `later` after this."""
        first = self.permuted(later.source)
        parts = range(len(first.source))
        return Rewire(
            source=first.source,
            factor=tuple(later.factor[p] * first.factor[p] for p in parts),
            offset=tuple(later.factor[p] * first.offset[p] + later.offset[p] for p in parts),
            delay=tuple(first.delay[p] + later.delay[p] for p in parts),
        )


@final
@dataclass(frozen=True, kw_only=True)
class Rewiring:
    """Corrections of a recording: of families, and of the clock."""

    families: Mapping[str, Rewire] = field(default_factory=dict)
    clock: float = 1.0
    """Factor of all times."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "families", MappingProxyType(dict(self.families)))

    @property
    def is_none(self) -> bool:
        """Whether nothing is changed."""
        return self.clock == 1.0 and all(rewire.is_none for rewire in self.families.values())

    def of(self, family: str, n_parts: int) -> Rewire:
        """Correction of a family with `n_parts` columns."""
        return self.families.get(family) or Rewire.none(n_parts)

    def with_family(self, family: str, rewire: Rewire) -> "Rewiring":
        """The same with another correction of one family."""
        return replace(self, families={**self.families, family: rewire})

    def then(self, later: "Rewiring") -> "Rewiring":
        """Both corrections in one, `later` after this; its delays are of the clock that this one made."""
        families = dict(self.families)
        for name, rewire in later.families.items():
            given = replace(rewire, delay=tuple(delay / self.clock for delay in rewire.delay))
            families[name] = self.of(name, len(rewire.source)).then(given)
        return Rewiring(families=families, clock=self.clock * later.clock)

    def applied(self, recording: Recording) -> Recording:
        """The recording as it should have been; rows that a late column does not reach are left out."""
        if self.is_none:
            return recording
        t = recording.t * self.clock
        table, within = dict(recording.columns), np.ones(len(t), dtype=np.bool_)
        for name, rewire in self.families.items():
            names = FAMILIES[name].columns(recording.header.joints)
            if rewire.is_none or not all(column in recording.columns for column in names):
                continue
            if len(rewire.source) != len(names):
                raise FFGymError(
                    f"Corrections of {name} are for {len(rewire.source)} columns, the recording has {len(names)}. Take "
                    "those of this robot."
                )
            for part, column in enumerate(names):
                given = recording.columns[names[rewire.source[part]]]
                samples, reached = earlier(given, t, rewire.delay[part] * self.clock)
                factor, offset = rewire.factor[part], rewire.offset[part]
                numbers = samples if factor == 1.0 else samples * factor
                table[column] = numbers if offset == 0.0 else numbers + offset
                within &= reached
        table["timestamp"] = t
        if "tcp.timestamp" in table:
            table["tcp.timestamp"] = table["tcp.timestamp"] * self.clock
        kept = {name: values[within] for name, values in table.items()}
        # phases on the corrected clock, cut to the rows that are left
        t, phases = kept["timestamp"], recording.header.phases
        if self.clock != 1.0:
            phases = tuple(replace(p, start=p.start * self.clock, end=p.end * self.clock) for p in phases)
        if len(t) > 1:
            phases = clipped(phases, float(t[0]), float(t[-1] + np.median(np.diff(t))))
        return Recording(kept, replace(recording.header, phases=phases))


def earlier(samples: Array, t: Array, delay: float) -> tuple[Array, BoolArray]:
    """Samples (T, ...) of times `t` (T,) as they are `delay` [s] later, and the rows that have one, (T,).

    A delay of whole rows of an even clock moves samples; any other interpolates between them.
    """
    if delay == 0.0:
        return samples, np.ones(len(t), dtype=np.bool_)
    dt = float(np.median(np.diff(t)))
    rows = round(delay / dt)
    wanted = t + delay
    reached = (wanted >= t[0] - _WHOLE * dt) & (wanted <= t[-1] + _WHOLE * dt)
    places = np.clip(np.arange(len(t)) + rows, 0, len(t) - 1)
    if np.all(np.abs(t[places] - wanted)[reached] < _WHOLE * dt):
        return samples[places], reached
    if samples.ndim == 1:
        return np.interp(wanted, t, samples), reached
    flat = samples.reshape(len(t), -1)
    return np.stack([np.interp(wanted, t, column) for column in flat.T], axis=1).reshape(samples.shape), reached
