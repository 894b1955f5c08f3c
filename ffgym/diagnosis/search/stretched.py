"""Shapes at the end of what is plausible: an effect that needs one often stands for something else."""

import numpy as np

from ffgym.diagnosis.fit.fit import Fit
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.setting import Setting
from ffgym.diagnosis.signatures.parts import Parts

_AT_END = 1e-3
"""Share of its plausible range within which a shape is at the end of it."""

_SEEN = 10.0
"""Energy of a tenth of a shape's range, in energies of the noise of a row, from which on the log says what it is."""


def stretched(setting: Setting, fit: Fit) -> tuple[tuple[Hypothesis, str], ...]:
    """Causes with shapes that the fit moved to the end of their plausible range, where they change what is seen."""
    found, at = [], 0
    for hypothesis in fit.hypotheses:
        for free in hypothesis.free():
            p, column = hypothesis.kind.parameters()[free.name], fit.columns[at]
            at += 1
            near = _AT_END * (p.high - p.low)
            is_shape = p.role == "shape" or (p.role == "cycles" and not p.is_looked_for)
            is_at_end = is_shape and not p.low + near < free.value < p.high - near
            if is_at_end and free.value != p.default and _energy(setting, column) > _SEEN:
                found.append((hypothesis, free.name))
    return tuple(found)


def _energy(setting: Setting, column: Parts) -> float:
    """Of a column, in energies of the noise of a row."""
    return sum(float(np.sum((setting.weights[key] * rows) ** 2)) for key, rows in column.items())
