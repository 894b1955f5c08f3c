"""Waves over an angle: what effects share that repeat with the turn of a motor or joint."""

from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import Effect
from ffgym.effects.parameters import parameter


class Wave(Effect):
    r"""An effect with a wave :math:`\sin(k x + \varphi)` of an angle x; its members declare k and phi."""

    cycles: Array
    """k"""
    phase: Array
    r""":math:`\varphi`"""

    def wave(self, angle: Array) -> Array:
        """The wave at an angle [rad], (..., N)."""
        wave: Array = np.sin(self.cycles * angle + self.phase)
        return wave

    def slope(self, height: Array, angle: Array) -> Array:
        """Derivative by the angle [rad] of a wave of that height."""
        slope: Array = height * self.cycles * np.cos(self.cycles * angle + self.phase)
        return slope


def cycles_per_turn(low: float, high: float, default: float, source: str) -> Any:
    """Parameter k: how often a wave repeats in a turn of the motor."""
    return parameter(
        "k, per motor turn",
        role="cycles",
        unit="1",
        null=None,
        low=low,
        high=high,
        minimum=0.0,
        default=default,
        source=source,
    )


def phase(source: str = "any; where the motor's zero lies") -> Any:
    """Parameter phi: where a wave begins."""
    return parameter("phi", unit="rad", null=None, low=0.0, high=2 * np.pi, default=0.0, role="phase", source=source)
