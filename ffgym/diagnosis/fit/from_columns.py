"""Hypotheses from what a linear fit says of the columns of a candidate."""

import math
from collections.abc import Sequence

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.signatures.column import Column
from ffgym.effects.parameters import Parameter
from ffgym.robot import RobotDescription


def hypothesis_of(columns: Sequence[Column], sizes: Array, robot: RobotDescription) -> Hypothesis:
    """A hypothesis from the columns of a candidate and what a linear fit gives them, in units of their parameters.

    What spans a phase gives amplitude and phase; what spans a linear shape gives its mean, weighted by sizes. Shares
    begin within what is plausible, whatever the robot: one that acts through another number, as the width of a peak
    that is to be higher, is far off in a linear fit. Other sizes depend on the robot's.
    """
    kind, joint = columns[0].effect, columns[0].joint
    values: dict[str, Array] = {}
    for p in kind.parameters().values():
        own = [(c, float(x)) for c, x in zip(columns, sizes, strict=True) if c.parameter == p.name]
        if p.role == "size":
            values[p.name] = _size(p, own)
        else:
            values[p.name] = _shape(p, columns, sizes)
    if not values:
        raise FFGymError(f"Effect {kind.name} has no parameters.")
    source = columns[0].part if kind.parameters()[columns[0].parameter].per == "pair" else None
    return Hypothesis(kind=kind, joint=joint, source=source, values=values)


def _size(p: Parameter, own: list[tuple[Column, float]]) -> Array:
    if p.per == "vector":
        moved = np.array([sum(x for c, x in own if c.part == k) for k in range(3)])
        return np.clip(p.neutral + moved, p.minimum, p.maximum)
    phases = [c.shape["phase"] for c, _ in own if "phase" in c.shape]
    sizes = [x for _, x in own]
    total = math.hypot(*sizes) if len(phases) == 2 else sum(sizes)
    low, high = (p.low, p.high) if p.unit == "1" else (p.minimum, p.maximum)
    return np.array(np.clip(p.neutral + total, low, high))


def _shape(p: Parameter, columns: Sequence[Column], sizes: Array) -> Array:
    """Value of a shape parameter: chosen, or what the fit says of the values that span it."""
    neutral = np.full(3, _default(p)) if p.per == "vector" else np.array(_default(p))
    if p.role == "phase":
        return np.array(float(np.arctan2(sizes[1], sizes[0]))) if len(sizes) == 2 else neutral
    known = [np.asarray(c.shape.get(p.name, neutral), dtype=np.float64) for c in columns]
    if p.role != "span":
        return known[0]
    total = float(np.sum(sizes))
    if abs(total) < 1e-12:
        return neutral
    mean = sum(x * value for x, value in zip(sizes, known, strict=True)) / total
    return np.clip(mean, p.low, p.high)


def _default(p: Parameter) -> float:
    return p.default if p.default is not None else p.neutral
