"""Waves over an angle: common part of all effects that repeat with each turn of a motor or joint."""

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
        """Wave of height 1 at an angle [rad], (..., N)."""
        wave: Array = np.sin(self.cycles * angle + self.phase)
        return wave

    def slope(self, height: Array, angle: Array) -> Array:
        """Derivative by the angle [rad] of a wave of that height."""
        slope: Array = height * self.cycles * np.cos(self.cycles * angle + self.phase)
        return slope


def cycles_per_turn(low: float, high: float, default: float, source: str) -> Any:
    """Declare parameter k, the number of periods in a turn of the motor."""
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
    """Declare parameter phi, the phase of a wave."""
    return parameter("phi", unit="rad", null=None, low=0.0, high=2 * np.pi, default=0.0, role="phase", source=source)
