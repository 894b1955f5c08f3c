r"""Leads from the centre of a circle onto it: a small circle that joins the large one.

The thesis (2.2.5, 4.3.2) starts each circle from its centre along a small circle that touches it. A half circle of half
the radius does that, but its curvature jumps from 2 / r to 1 / r where it joins, which asks for infinite jerk. In the
smooth lead the second part is a clothoid, whose curvature runs linearly from that of the small circle to 1 / r. Small
circle and total length follow from the two conditions that the lead starts at the centre and joins the circle in its
tangent; for r = 1 they are numbers, found once.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import final

import numpy as np

from ffgym.core.types import Array

BLEND = 0.5
"""Share of the lead's length that is clothoid; chosen: half keeps the small circle visible."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


class Lead(ABC):
    """A lead onto the unit circle around (0, 1), which it joins at the origin heading along x."""

    length: float
    """Arc length from the centre to the joint, in units of r."""

    @abstractmethod
    def bend(self, s: Array) -> Array:
        """Curvature at arc length `s` from the centre, shape (T,)."""

    @abstractmethod
    def heading(self, s: Array) -> Array:
        """Angle of the tangent [rad] at arc length `s`, 0 at the joint, shape (T,)."""

    @abstractmethod
    def point(self, s: Array) -> Array:
        """Position at arc length `s`, shape (T, 2)."""


@final
@dataclass(frozen=True, kw_only=True)
class HalfCircle(Lead):
    """Half a circle of half the radius, as in the thesis."""

    length: float = np.pi / 2

    def bend(self, s: Array) -> Array:
        """2 throughout."""
        return np.full_like(s, 2.0)

    def heading(self, s: Array) -> Array:
        """From backwards to along x."""
        return 2.0 * (s - self.length)

    def point(self, s: Array) -> Array:
        """On the circle around (0, 1/2)."""
        angle = self.heading(s)
        return np.stack([0.5 * np.sin(angle), 0.5 - 0.5 * np.cos(angle)], axis=1)


@final
@dataclass(frozen=True, kw_only=True)
class SmoothLead(Lead):
    """Part of a small circle, then a clothoid."""

    curvature: float
    """Curvature of the small circle, in units of 1 / r."""
    length: float
    """Arc length from the centre to the joint, in units of r."""

    @property
    def knot(self) -> float:
        """Arc length at which the clothoid begins."""
        return (1 - BLEND) * self.length

    def bend(self, s: Array) -> Array:
        """Curvature at arc length `s` from the centre, shape (T,)."""
        ramp = np.clip((s - self.knot) / (self.length - self.knot), 0.0, 1.0)
        return self.curvature + ramp * (1.0 - self.curvature)

    def heading(self, s: Array) -> Array:
        """Angle of the tangent [rad] at arc length `s`, 0 at the joint, shape (T,)."""
        late = np.maximum(s, self.knot)
        turned = 0.5 * (self.length - late) * (self.bend(late) + 1.0)
        return -turned - self.curvature * np.maximum(self.knot - s, 0.0)

    def point(self, s: Array) -> Array:
        """Position at arc length `s`, shape (T, 2)."""
        s = np.asarray(s, dtype=np.float64)
        middle = np.maximum(s, self.knot)
        return -(self._chord(s, middle) + self._chord(middle, np.full_like(s, self.length)))

    def _chord(self, start: Array, end: Array) -> Array:
        """Integral of the tangent from `start` to `end`, smooth in between, by Gauss-Legendre quadrature."""
        half = 0.5 * (end - start)
        s = 0.5 * (start + end)[:, None] + half[:, None] * _NODES
        angle = self.heading(s)
        return half[:, None] * np.stack([np.cos(angle) @ _WEIGHTS, np.sin(angle) @ _WEIGHTS], axis=1)


def unit_lead() -> SmoothLead:
    """Return the smooth lead that starts at the centre (0, 1) of the unit circle.

    Its two numbers solve `point(0) = (0, 1)` to rounding; a test solves again.
    """
    return SmoothLead(curvature=2.0913321439700536, length=1.9966390507735365)


LEADS: Mapping[str, Callable[[], Lead]] = MappingProxyType({"smooth": unit_lead, "half_circle": HalfCircle})
"""Leads by the names that `circle_test` knows."""
