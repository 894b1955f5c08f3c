"""Damped Gauss-Newton whose candidates are simulated side by side: all columns of a Jacobian, then several steps.

For fits whose model is a simulation of whole motions, without slopes; fits to logs, which have them, descend by
`ffgym.diagnosis.fit.descent`. A search that was stopped goes on from the state of its last point.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ffgym.core.types import Array

DAMPINGS = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
"""Factors on the damping of the last step that are tried."""

Evaluate = Callable[[Array], Sequence[tuple[Any, Array]]]
"""Function of candidates (C, K) that returns the outcome of each, and its residuals (M,)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Point:
    """Free numbers, their outcome, and their cost."""

    x: Array
    outcome: Any
    """Values that the simulation gave."""
    residuals: Array
    damping: float
    steps: int = 0
    """Steps that led here."""
    rests: bool = False
    """True if the last of them gained so little that another is not worth its simulations."""

    @property
    def state(self) -> dict[str, Any]:
        """Values from which `Descent.search` goes on, for a JSON file."""
        return {"x": self.x.tolist(), "damping": self.damping, "steps": self.steps, "rests": self.rests}

    @property
    def cost(self) -> float:
        """Sum of squared residuals."""
        return float(self.residuals @ self.residuals)


@dataclass(frozen=True, kw_only=True, eq=False)
class Descent:
    """Fit of free numbers by steps that are damped towards standing still, in units of their spreads."""

    evaluate: Evaluate
    steps: Array
    """Steps of finite differences, shape (K,)."""
    spread: Array
    """Units of the damping, shape (K,)."""
    clip: Callable[[Array], Array]
    """Function that brings free numbers (..., K) within their bounds."""
    dampings: tuple[float, ...] = DAMPINGS

    def points(self, xs: Array, damping: float | Array) -> list[Point]:
        """Evaluate candidates `xs` (C, K)."""
        dampings = np.broadcast_to(damping, len(xs))
        return [
            Point(x=x, outcome=outcome, residuals=residuals, damping=float(d))
            for x, (outcome, residuals), d in zip(xs, self.evaluate(xs), dampings, strict=True)
        ]

    def jacobian(self, point: Point) -> Array:
        """Compute the slopes of the residuals about a point, shape (M, K)."""
        if not len(point.x):
            return np.zeros((len(point.residuals), 0))
        shifted = self.points(point.x + np.diag(self.steps), point.damping)
        there = np.stack([each.residuals for each in shifted], axis=1)
        return (there - point.residuals[:, None]) / self.steps

    def step(self, point: Point, jacobian: Array, damping: float) -> Array:
        """Compute the free numbers that a damped step leads to, within their bounds."""
        normal, slope = jacobian.T @ jacobian, jacobian.T @ point.residuals
        return self.clip(point.x - np.linalg.solve(normal + damping * np.diag(self.spread**-2), slope))

    def better(self, point: Point) -> Point | None:
        """Return the best of several steps from a point; None if no step is better."""
        jacobian = self.jacobian(point)
        dampings = point.damping * np.array(self.dampings)
        tries = np.array([self.step(point, jacobian, float(d)) for d in dampings])
        best = min(self.points(tries, dampings), key=lambda p: p.cost)
        return best if best.cost < point.cost else None

    def descend(self, start: Point, most: int, gain: float = 0.0) -> Iterator[Point]:
        """Yield better and better points, at most so many; end when a step lowers the cost by less than a share."""
        point = start
        for _ in range(most):
            found = self.better(point)
            if found is None:
                return
            rests = found.cost > (1 - gain) * point.cost
            point = replace(found, steps=point.steps + 1, rests=rests)
            yield point
            if rests:
                return

    def search(
        self, starts: Array, most: int, keep: Callable[[Point], None], state: Mapping[str, Any], gain: float = 0.0
    ) -> Point:
        """Search from where a state stands, or else from the best of several starts; return the last point.

        Args:
            starts: free numbers, shape (S, K).
            most: most steps, those of the state among them.
            keep: called with each point, the first among them.
            state: `Point.state` of a search that was stopped; empty to begin anew.
            gain: share of the cost below which a step is the last one.
        """
        xs = np.array([state["x"]]) if state else starts
        found = min(self.points(xs, state.get("damping", 1.0)), key=lambda each: each.cost)
        begun = found = replace(found, steps=state.get("steps", 0), rests=state.get("rests", False))
        keep(begun)
        if not begun.rests and len(begun.x):
            for found in self.descend(begun, most - begun.steps, gain):
                keep(found)
        return found
