"""Damped Gauss-Newton with finite differences: all of a Jacobian's columns are simulated side by side, in batches."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_json
from ffgym.core.types import Array
from scripts.workcell.free import FREE, LOW, SPREAD
from scripts.workcell.objective import Objective

_BATCH = 8
"""Candidates simulated side by side; chosen: their recordings fit into 1 GB."""
_STEP = 0.2
"""Step of finite differences, in spreads; chosen: far above the noise of stick-slip, below where the model bends."""
_LARGEST_STEP = 0.05
"""Of factors, whatever their spread."""
_DAMPINGS = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
"""Factors on the damping of the last step that are tried."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Point:
    """Free numbers, what they give, and what it costs."""

    x: Array
    sizes: Array
    """[mm], shape (2, L, V, P, R)."""
    residuals: Array
    damping: float

    @property
    def cost(self) -> float:
        """Sum of squared residuals."""
        return float(self.residuals @ self.residuals)


def search(objective: Objective, steps: int, state: Path, tell: Callable[[int, Point], None]) -> Point:
    """Lower the objective from where the `state` file stands, or from the prior, and keep it up to date.

    Raises:
        FFGymError: if the state file is of other free numbers.
    """
    point = _begin(objective, state)
    tell(0, point)
    for step in range(steps):
        better = _better(objective, point)
        objective.forget()
        if better is None:
            break
        point = better
        _save(point, state)
        tell(step + 1, point)
    return point


def _points(objective: Objective, xs: Array, damping: Array) -> list[Point]:
    points = []
    for start in range(0, len(xs), _BATCH):
        some = xs[start : start + _BATCH]
        sizes = objective.sizes([objective.candidate(x) for x in some])
        points += [
            Point(x=x, sizes=size, residuals=objective.residuals(x, size), damping=float(d))
            for x, size, d in zip(some, sizes, damping[start : start + _BATCH], strict=True)
        ]
    return points


def _better(objective: Objective, point: Point) -> Point | None:
    """The best of several steps; None if none is better."""
    steps = np.array(
        [_STEP * f.spread if f.added_to is not None else min(_LARGEST_STEP, _STEP * f.spread) for f in FREE]
    )
    shifted = _points(objective, point.x + np.diag(steps), np.full(len(steps), point.damping))
    jacobian = np.stack([(p.residuals - point.residuals) / h for p, h in zip(shifted, steps, strict=True)], axis=1)
    normal, slope = jacobian.T @ jacobian, jacobian.T @ point.residuals
    dampings = point.damping * np.array(_DAMPINGS)
    tries = [np.maximum(point.x - np.linalg.solve(normal + d * np.diag(SPREAD**-2), slope), LOW) for d in dampings]
    best = min(_points(objective, np.array(tries), dampings), key=lambda p: p.cost)
    return best if best.cost < point.cost else None


def _begin(objective: Objective, state: Path) -> Point:
    x, damping = np.zeros(len(FREE)), 1.0
    if state.exists():
        saved = json.loads(read_text(state))
        if list(saved["x"]) != [free.name for free in FREE]:
            raise FFGymError(f"{state} is of other free numbers; give another file to begin anew.")
        x, damping = np.array(list(saved["x"].values())), saved["damping"]
    return _points(objective, x[None], np.array([damping]))[0]


def _save(point: Point, state: Path) -> None:
    names = [free.name for free in FREE]
    write_json(state, {"x": dict(zip(names, point.x.tolist(), strict=True)), "damping": point.damping})
