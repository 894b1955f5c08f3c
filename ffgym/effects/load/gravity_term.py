"""G3: gravity that masses do not explain, and springs that carry it."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class GravityTerm(TorqueEffect):
    """A function of one joint's own angle: hoses, a centre of mass off its place, a counterbalance."""

    name = "gravity_term"
    code = "G3"
    title = "gravity term and counterbalance"
    equation = r"\tau_{link} \mathrel{-}= c_1 \sin q + c_2 \cos q + k_s\, (q - q_0)"
    side = "link"
    signature = "torque: even in the speed, a function of one joint's angle, no inertia with it"
    way_in = "torque at every physics step on the link"
    confusable_with = ("F5", "G4", "M4")
    separating_motions = ("holds", "slow_triangles")
    patterns = (("function", "motor angle"),)

    sine: Array = parameter(
        "c_1, link side", unit="N m", low=-100.0, high=100.0, source="chosen: 10 kg at 1 m, as a description may miss"
    )
    cosine: Array = parameter("c_2, link side", unit="N m", low=-100.0, high=100.0, source="as c_1")
    stiffness: Array = parameter(
        "k_s, link side",
        unit="N m/rad",
        low=0.0,
        high=100.0,
        minimum=0.0,
        source="chosen: a weak counterbalance; a strong one is a spring of the description",
    )
    neutral: Array = parameter(
        "q_0, where the spring is relaxed",
        role="span",
        unit="rad",
        null=None,
        low=-1.0,
        high=1.0,
        default=0.0,
        source="chosen: about the upright arm",
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the torque of masses and spring at the angle of the link."""
        q = state.link_angle
        return Torques(
            link=-(self.sine * np.sin(q) + self.cosine * np.cos(q) + self.stiffness * (q - self.neutral))
        ), memory
