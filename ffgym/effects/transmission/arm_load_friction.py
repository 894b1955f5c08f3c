"""T10: friction behind the elasticity that grows with the torque that the gearbox passes on."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import Braking, LinkBrake
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ArmLoadFriction(LinkBrake):
    r"""Bearings of the arm and the gearbox output, which rub in proportion to what they carry.

    The smoothed sign s of the link's motion yields along its way, exactly for a way in one direction (Dahl 1968):
    :math:`s \to \operatorname{sgn}(\Delta q) + (s - \operatorname{sgn}(\Delta q))\, e^{-|\Delta q| / w}`.
    """

    name = "arm_load_friction"
    code = "T10"
    title = "load-dependent friction behind the elasticity"
    equation = r"\tau_{link} \mathrel{+}= -\mu\, |\tau_l|\, s, \quad \dot s = (\dot q - |\dot q|\, s) / w"
    signature = "tool: a loop that widens with |gravity + inertia + payload|; torque: as load-dependent friction"
    way_in = "torque at every physics step on the link, with memory"
    confusable_with = ("F6", "T9")
    separating_motions = ("slow_triangles", "holds")
    alike_in_torque = ("F6",)
    needs_elasticity = True
    needs_load = True

    share: Array = parameter(
        "mu, lost share of the transmitted torque",
        unit="1",
        low=0.0,
        high=0.15,
        minimum=0.0,
        maximum=1.0,
        source="as load_friction: 0.06 and 0.15 of gear units as a whole (parameter files of Rhoban BAM)",
    )
    way: Array = parameter(
        "w, way of the link in which the sign turns by 63 %, link side",
        unit="rad",
        null=None,
        low=2e-5,
        high=2e-4,
        minimum=1e-6,
        default=1e-4,
        source="presliding of robots behind the gearbox; from memory of the literature",
    )

    def reach(self, dt: float) -> Array:
        """Return the change of speed that turns the sign by a part."""
        return 0.2 * self.way / dt

    def initial_memory(self, state: State) -> Array:
        """Return a relaxed contact, and the speed of the link."""
        speed = state.link_speed
        return np.stack([np.zeros_like(speed), speed], axis=-1)

    def brake(self, speed: Array, load: Array | None, memory: Array, dt: float) -> Braking:
        """Turn the sign along the link's way since the last state."""
        mean = 0.5 * (memory[..., 1] + speed)
        end, left = np.copysign(1.0, mean), np.exp(-np.abs(mean) * dt / self.way)
        turning = left * (memory[..., 0] - end)
        sign, by_speed = end + turning, -0.5 * dt / self.way * turning * end
        level = self.share * np.abs(load if load is not None else 0.0)
        return Braking(
            torque=-level * sign,
            slope=level * by_speed,
            memory=np.stack([sign, speed], axis=-1),
            memory_slope=np.stack([by_speed, np.ones_like(speed)], axis=-1),
        )

    def torques_over(self, states: State, dt: float) -> Torques:
        """Turn signs from sample to sample, then compute all torques at once."""
        speed = np.broadcast_to(states.link_speed, states.motor_angle.shape)
        mean = 0.5 * (speed + np.concatenate([speed[:1], speed[:-1]]))
        end, left = np.copysign(1.0, mean), np.exp(-np.abs(mean) * dt / self.way)
        signs, gain = np.empty_like(mean), (1 - left) * end
        sign = np.zeros_like(mean[0])
        for k in range(len(mean)):
            sign = signs[k] = left[k] * sign + gain[k]
        return Torques(link=-self.share * np.abs(states.load) * signs)
