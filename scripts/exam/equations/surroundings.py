"""What pulls at links, in other shapes: gravity of a second harmonic, cables that yield smoothly."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, TorqueEffect, Torques
from ffgym.effects.effect import Side
from ffgym.effects.parameters import parameter
from scripts.exam.equations.dahl import lagging
from scripts.exam.equations.variant import Variant


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CounterweightLinkage(Variant, TorqueEffect):
    """A balancer on a linkage, whose arm changes with the angle: a second harmonic beside the first."""

    name: ClassVar[str] = "counterweight_linkage"
    variant_of: ClassVar[str] = "gravity_term"
    title: ClassVar[str] = "gravity term with a second harmonic"
    equation: ClassVar[str] = (
        r"\tau_{link} \mathrel{-}= c \left( \sin(q + \alpha) + \tfrac{3}{10} \sin(2 q + \alpha) \right)"
    )
    side: ClassVar[Side] = "link"

    level: Array = parameter("c, link side", unit="N m", low=0.0, high=100.0, minimum=0.0, source="as gravity_term")
    angle: Array = parameter("alpha", unit="rad", null=None, low=0.0, high=2 * np.pi, source="any")

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        q = state.link_angle
        return Torques(link=-self.level * (np.sin(q + self.angle) + 0.3 * np.sin(2 * q + self.angle))), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SmoothCable(Variant, TorqueEffect):
    """A bundle of strands that slip on each other little by little, and pull back to where they were laid."""

    name: ClassVar[str] = "smooth_cable"
    variant_of: ClassVar[str] = "cable_pull"
    title: ClassVar[str] = "cables by Dahl"
    equation: ClassVar[str] = (
        r"\tau_{link} \mathrel{-}= h\, (z + r\, (q - q_0)), \quad z' = (1 - z\, \mathrm{sgn}\, \dot q)\, \dot q / w"
    )
    side: ClassVar[Side] = "link"

    hysteresis: Array = parameter("h, link side", unit="N m", low=0.0, high=10.0, minimum=0.0, source="as cable_pull")
    spring: Array = parameter("r", unit="1/rad", null=None, low=0.3, high=3.0, minimum=0.0, source="chosen")
    width: Array = parameter(
        "w, link side", unit="rad", null=None, low=0.01, high=0.1, minimum=1e-4, source="chosen: as cable_pull"
    )
    neutral: Array = parameter("q_0, where it was laid", unit="rad", null=None, low=-1.0, high=1.0, source="any")

    def initial_memory(self, state: State) -> Array:
        """Relaxed at rest, shape (..., N, 1)."""
        return np.zeros((*state.joint_angle.shape, 1))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        z = memory[..., 0]
        pull = self.hysteresis * (z + self.spring * (state.link_angle - self.neutral))
        return Torques(link=-pull), lagging(z, state.link_speed * dt, self.width)[..., None]
