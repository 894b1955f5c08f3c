"""Mean of a residual over what it may depend on, with a band that knows that neighbouring rows say the same."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.regimes import LogRows
from ffgym.diagnosis.settings import settings

BINS = 24
"""Bins of a profile; chosen: as many as a small picture can show."""

SIGMAS = 2.0
"""Half width of the band in standard errors of the mean: about 95 %."""

FEWEST_BLOCKS = 3
"""Blocks in a bin below which it has no band."""


@dataclass(frozen=True, kw_only=True)
class Variable:
    """Something that a residual may depend on."""

    label: str
    unit: str
    of: Callable[[LogRows], Array]
    """Values, shape (R, N)."""
    by_direction: bool = True
    """True if both directions are looked at apart: a sign-locked effect vanishes in their mean."""
    logarithmic: bool = False


VARIABLES: Mapping[str, Variable] = MappingProxyType(
    {
        "speed": Variable(label="motor speed", unit="rad/s", of=lambda rows: rows.speed, by_direction=False),
        "position": Variable(label="joint position", unit="rad", of=lambda rows: rows.position),
        "load": Variable(label="load on the motor", unit="N m", of=lambda rows: rows.load),
        "travel": Variable(
            label="motor travel since it turned", unit="rad", of=lambda rows: rows.travel, logarithmic=True
        ),
        "temperature": Variable(label="temperature", unit="degC", of=lambda rows: rows.temperature),
        "time": Variable(
            label="time in the log", unit="s", of=lambda rows: np.broadcast_to(rows.time[:, None], rows.speed.shape)
        ),
    }
)
"""Variables that residuals are shown over, by name."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Profile:
    """Mean residual of one component over one variable; B bins with enough rows, ascending."""

    centre: Array
    """Mean of the variable in each bin, shape (B,)."""
    mean: Array
    """Mean residual, in the unit of the channel, shape (B,)."""
    error: Array
    """Standard error of the mean, from blocks of rows, shape (B,); NaN with too few of them."""

    @property
    def low(self) -> Array:
        """Lower end of the band, shape (B,)."""
        return self.mean - SIGMAS * self.error

    @property
    def high(self) -> Array:
        """Upper end of the band, shape (B,)."""
        return self.mean + SIGMAS * self.error


def compute_profiles(rows: LogRows, component: int, joint: int, variable: Variable) -> dict[str, Profile]:
    """Mean of a residual over a variable of a joint: 'both', or 'forwards' and 'back', as the variable wants it."""
    limits = settings().patterns
    speed = rows.speed[:, joint]
    directions: dict[str, BoolArray] = {"both": np.ones(len(speed), dtype=np.bool_)}
    if variable.by_direction:
        directions = {"forwards": speed > limits.rest, "back": speed < -limits.rest}
    # rows with a residual and a value of the variable
    values = variable.of(rows)[:, joint]
    usable = np.isfinite(rows.residual[:, component]) & np.isfinite(values)
    if variable.logarithmic:
        usable = usable & (values > 0)
    # bins that hold about equally many rows, ascending
    edges = np.zeros(0)
    if usable.any():
        edges = np.unique(np.quantile(values[usable], np.linspace(0.0, 1.0, BINS + 1)))
    return {
        name: _compute_profile(rows, component, values, usable & rows_of, edges) for name, rows_of in directions.items()
    }


def _compute_profile(rows: LogRows, component: int, values: Array, usable: BoolArray, edges: Array) -> Profile:
    if len(edges) < 2:
        return Profile(centre=np.zeros(0), mean=np.zeros(0), error=np.zeros(0))
    value, residual = values[usable], rows.residual[usable, component]
    bins = np.clip(np.searchsorted(edges, value, side="right") - 1, 0, len(edges) - 2)
    # number of the block of each row, none of which reaches from one motion into the next
    place = np.stack([rows.motion, np.floor(rows.time / settings().blocks.length).astype(np.intp)], axis=1)
    block = np.unique(place, axis=0, return_inverse=True)[1].ravel()[usable]
    kept = [bins == b for b in range(len(edges) - 1) if np.count_nonzero(bins == b) >= settings().patterns.few]
    means = [(value[own].mean(), residual[own].mean()) for own in kept]
    centre, mean = np.array(means).reshape(-1, 2).T
    # standard errors of the means; each block is one observation
    errors = np.full(len(kept), np.nan)
    for i, own in enumerate(kept):
        sums = np.bincount(block[own], weights=residual[own] - residual[own].mean())
        n_blocks = np.count_nonzero(np.bincount(block[own]))
        if n_blocks >= FEWEST_BLOCKS:
            errors[i] = np.sqrt((sums**2).sum() * n_blocks / (n_blocks - 1)) / np.count_nonzero(own)
    return Profile(centre=centre, mean=mean, error=errors)
