"""Numbers of a hypothesis that are fitted: steps, bounds and nudges, by what each is."""

from dataclasses import dataclass

import numpy as np

from ffgym.diagnosis.signatures.variant import step_of
from ffgym.effects.parameters import Parameter

_CYCLES = 0.05
"""Step of a frequency as a share of itself; a frequency is looked for before, and only refined here."""


_NUDGE, _CYCLES_NUDGE = 0.05, 1e-5
"""Change of a number by which slopes are found, as a share of its practical step: small against where effects bend,
large against rounding; and of a frequency, as a share of itself: after a hundred turns of a motor at sixty cycles per
turn, the phase is 0.4 rad further."""


@dataclass(frozen=True, kw_only=True)
class Free:
    """One number of a hypothesis that is fitted."""

    name: str
    part: int | None
    """Which number of a vector."""
    value: float
    step: float
    """A practical change, > 0."""
    low: float
    high: float
    nudge: float
    """A change by which slopes are found, > 0."""
    of_session: bool = False
    """Whether it is the time in which a session changes something."""


def free_number(p: Parameter, part: int | None, value: float, *, of_session: bool = False) -> Free:
    """One number of a parameter at a value."""
    step, low, high = _span(p, value)
    nudge = _CYCLES_NUDGE * max(abs(value), 1.0) if p.role == "cycles" else _NUDGE * step
    return Free(name=p.name, part=part, value=value, step=step, low=low, high=high, nudge=nudge, of_session=of_session)


def _span(p: Parameter, value: float) -> tuple[float, float, float]:
    """Practical step, lowest and highest value of a number."""
    if p.role == "size":
        return abs(step_of(p)), p.minimum, p.maximum
    if p.role == "phase":
        return 0.5, -np.inf, np.inf
    if p.is_looked_for:  # and found there
        step = _CYCLES * max(abs(value), 1.0)
        return step, max(p.minimum, value - step), value + step
    # beyond its plausible range a shape makes of an effect another one: a drift of a second is a level, and so is
    # friction that repeats after many turns
    low, high = min(p.low, value), max(p.high, value)
    if p.role == "cycles":  # somewhere between those that were tried
        step = 0.5 * float(np.min(np.diff(p.tries)))
        return step, max(low, value - step), min(high, value + step)
    return 0.1 * (p.high - p.low), low, high
