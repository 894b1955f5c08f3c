"""Corrections of wrongly wired columns: of another joint, sign, unit, zero or time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Self, final

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.measures import interpolate
from ffgym.core.types import Array, BoolArray
from ffgym.recordings.header import clip_phases
from ffgym.recordings.recording import Recording
from ffgym.recordings.schema import FAMILIES

_WHOLE = 1e-3
"""Tolerance of a delay of whole rows [rows], by which samples are moved, not interpolated."""


@final
@dataclass(frozen=True, kw_only=True)
class Rewire:
    r"""Correction of one family with P columns: right_p(t) = factor_p given_{source_p}(t + delay_p) + offset_p."""

    source: tuple[int, ...]
    """Index of the given column that holds the numbers of each, shape (P,)."""
    factor: tuple[float, ...]
    """Factors, shape (P,)."""
    offset: tuple[float, ...]
    """Offsets in the unit of the family, shape (P,)."""
    delay: tuple[float, ...]
    """Delays of the given samples [s], shape (P,)."""

    @classmethod
    def none(cls, n_parts: int) -> Self:
        """Return the correction that leaves a family as it is."""
        return cls(
            source=tuple(range(n_parts)), factor=(1.0,) * n_parts, offset=(0.0,) * n_parts, delay=(0.0,) * n_parts
        )

    @property
    def is_none(self) -> bool:
        """True if it changes nothing."""
        return self == Rewire.none(len(self.source))

    def scale_parts(self, parts: Sequence[int], factors: Sequence[float]) -> "Rewire":
        """Multiply numbers of `parts` by `factors` in addition."""
        factor, offset = list(self.factor), list(self.offset)
        for part, by in zip(parts, factors, strict=True):
            factor[part] *= by
            offset[part] *= by
        return replace(self, factor=tuple(factor), offset=tuple(offset))

    def shift_parts(self, parts: Sequence[int], offset: float) -> "Rewire":
        """Add `offset` to numbers of `parts` in addition."""
        return replace(self, offset=tuple(o + offset * (p in parts) for p, o in enumerate(self.offset)))

    def delay_parts(self, parts: Sequence[int], delay: float) -> "Rewire":
        """Take numbers of `parts` `delay` [s] later in addition."""
        return replace(self, delay=tuple(d + delay * (p in parts) for p, d in enumerate(self.delay)))

    def permute(self, order: Sequence[int]) -> "Rewire":
        """Permute parts: part p becomes the former part `order[p]`."""
        return Rewire(**{name: tuple(values[p] for p in order) for name, values in vars(self).items()})

    def then(self, later: "Rewire") -> "Rewire":
        """Combine both corrections, `later` after this."""
        first = self.permute(later.source)
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
    """Corrections of the families and of the clock of a recording."""

    families: Mapping[str, Rewire] = field(default_factory=dict)
    clock: float = 1.0
    """Factor of all times."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "families", MappingProxyType(dict(self.families)))

    @property
    def is_none(self) -> bool:
        """True if it changes nothing."""
        return self.clock == 1.0 and all(rewire.is_none for rewire in self.families.values())

    def of(self, family: str, n_parts: int) -> Rewire:
        """Return the correction of a family with `n_parts` columns."""
        return self.families.get(family) or Rewire.none(n_parts)

    def with_family(self, family: str, rewire: Rewire) -> "Rewiring":
        """Return the rewiring with another correction of one family."""
        return replace(self, families={**self.families, family: rewire})

    def then(self, later: "Rewiring") -> "Rewiring":
        """Combine both corrections, `later` after this; its delays refer to the clock that this one corrected."""
        families = dict(self.families)
        for name, rewire in later.families.items():
            given = replace(rewire, delay=tuple(delay / self.clock for delay in rewire.delay))
            families[name] = self.of(name, len(rewire.source)).then(given)
        return Rewiring(families=families, clock=self.clock * later.clock)

    def apply(self, recording: Recording) -> Recording:
        """Return the corrected recording, without rows that a late column does not reach."""
        if self.is_none:
            return recording
        # correct family by family; `within` marks the rows that every column reaches
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
                # source column, read earlier by its delay, then scaled and offset
                given = recording.columns[names[rewire.source[part]]]
                samples, reached = earlier(given, t, rewire.delay[part] * self.clock)
                factor, offset = rewire.factor[part], rewire.offset[part]
                numbers = samples if factor == 1.0 else samples * factor
                table[column] = numbers if offset == 0.0 else numbers + offset
                within &= reached
        # all clocks run at the corrected rate
        table["timestamp"] = t
        if "tcp.timestamp" in table:
            table["tcp.timestamp"] = table["tcp.timestamp"] * self.clock
        kept = {name: values[within] for name, values in table.items()}
        # phases on the corrected clock, cut to the rows that are left
        t, phases = kept["timestamp"], recording.header.phases
        if self.clock != 1.0:
            phases = tuple(replace(p, start=p.start * self.clock, end=p.end * self.clock) for p in phases)
        if len(t) > 1:
            phases = clip_phases(phases, float(t[0]), float(t[-1] + np.median(np.diff(t))))
        return Recording(kept, replace(recording.header, phases=phases))


def earlier(samples: Array, t: Array, delay: float) -> tuple[Array, BoolArray]:
    """Return samples (T, ...) at times `t` (T,) plus `delay` [s], and the rows for which they exist, (T,).

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
    return interpolate(wanted, t, samples), reached
