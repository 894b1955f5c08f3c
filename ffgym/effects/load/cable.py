"""G4: a dress pack that is bent along."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques
from ffgym.robot.friction import advance_slip, advance_slip_along


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CablePull(TorqueEffect):
    """Cables and hoses: a spring about the angle at which they were laid, and strands that slip on each other."""

    name = "cable_pull"
    code = "G4"
    title = "cables and dress pack"
    equation = r"\tau_{link} \mathrel{-}= k_c\, (q - q_0) + h\, s, \quad s \to \mathrm{clip}(s + \Delta q / w, \pm 1)"
    side = "link"
    signature = "torque: a function of the joint angle, weakly of its direction; another after re-dressing"
    way_in = "torque at every physics step on the link, with memory"
    confusable_with = ("G3",)
    separating_motions = ("slow_triangles", "holds")
    patterns = (("function", "motor angle"),)

    stiffness: Array = parameter(
        "k_c, link side",
        unit="N m/rad",
        low=0.0,
        high=30.0,
        minimum=0.0,
        source="chosen: some N m over the travel of a wrist",
    )
    hysteresis: Array = parameter(
        "h, link side", unit="N m", low=0.0, high=10.0, minimum=0.0, source="chosen: some N m of rubbing strands"
    )
    width: Array = parameter(
        "w, travel after a reversal at which all strands slip, link side",
        tries=(0.03, 0.2),
        unit="rad",
        null=None,
        low=0.02,
        high=0.5,
        minimum=1e-4,
        default=0.1,
        source="chosen: some degrees",
    )
    neutral: Array = parameter(
        "q_0, angle at which they were laid",
        unit="rad",
        null=None,
        low=-1.5,
        high=1.5,
        default=0.0,
        role="span",
        source="any",
    )

    def initial_memory(self, state: State) -> Array:
        """Return relaxed strands."""
        return np.zeros((*state.joint_angle.shape, 1))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return spring and strands; the last physics step moved the link by its present speed."""
        speed = state.link_speed
        slip = advance_slip(memory, speed, speed, dt, self.width[..., None])
        return self._pull(state, slip), slip

    def torques_over(self, states: State, dt: float) -> Torques:
        """Let strands slip along all samples, then compute all torques at once."""
        speed = np.broadcast_to(states.link_speed, states.motor_angle.shape)
        return self._pull(states, advance_slip_along(speed, dt, self.width[..., None]))

    def _pull(self, state: State, slip: Array) -> Torques:
        return Torques(link=-(self.stiffness * (state.link_angle - self.neutral) + self.hysteresis * slip[..., 0]))
