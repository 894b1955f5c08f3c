r"""T9: friction behind the elasticity of a joint, and the torque on the link by which models without an engine have it.

The engine has it by the description's `friction.arm_share` alone, as feed-forward from a model has. A replay takes
`LinkFriction.of(robot)` among the effects that act on the arm.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Self, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import Braking, LinkBrake, NativeEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State
from ffgym.robot import RobotDescription
from ffgym.robot.friction import LuGreParameters


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ArmFriction(NativeEffect):
    r"""A share of the motor's friction acts on the link, where the spring must carry it.

    Each part has bristles of its own, on the motor's motion and on the link's in units of the motor. Of what a
    description has on the motor's side, the share moves: :math:`1 - s \to (1 - a)(1 - s)`.

    There is no effect of hysteresis on the arm beside it: presliding of these bristles is a loop on the link that does
    not depend on the rate, from which another could not be told within the 80 urad or so of travel that it takes.
    """

    name = "arm_friction"
    code = "T9"
    title = "friction behind the elasticity"
    equation = (
        r"\tau_f \to (1 - a)\, \tau_f(v), \quad \tau_{link} \mathrel{+}= -a\, n\, \tau_f(n \dot q), \quad "
        r"\tau_f(v) = \sigma_0 z + \sigma_1 \dot z + f_v v"
    )
    side = "link"
    signature = "tool: a loop of the friction over the stiffness, turned by the link's motion; torque: hardly any"
    way_in = "native: a second LuGre friction, on the angle of the link"
    confusable_with = ("F1", "F4", "T3", "T4", "T10", "T11")
    alike_in_torque = ("F4",)
    separating_motions = ("slow_triangles", "speed_ladder")
    needs_elasticity = True
    needs_friction = True
    patterns = (("sign-locked function", "size of the motor speed"),)

    share: Array = parameter(
        "a, share of the motor's friction that moves behind the elasticity",
        unit="1",
        low=0.0,
        high=0.9,
        minimum=0.0,
        maximum=1.0,
        source="about 90 % of the friction is in the gearbox (thesis 4.1), on both sides of its spring",
    )

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """Return the robot with more of its friction on the arm."""
        share = 1 - (1 - self.share) * (1 - robot.arm_share)
        return robot.with_arm_share(np.minimum(share, 1.0))


_PART = 0.2
"""Part of the length of bristles within which their slopes hold; chosen: the torque is then known to some per cent."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LinkFriction(LinkBrake):
    """Friction of a description behind its elasticity, as a torque on the link."""

    name = "link_friction"
    title = "friction behind the elasticity"
    side = "link"

    share: Array = parameter(
        "share of the friction that acts on the link", unit="1", low=0.0, high=0.9, source="the description"
    )
    friction: LuGreParameters
    """Friction of both parts together, motor side."""
    gear_ratio: Array
    """Motor turns per joint turn, (N,)."""

    @classmethod
    def of(cls, robot: RobotDescription) -> Self | None:
        """Friction of a robot on its links; None if all of it is on its motors."""
        if not np.any(robot.arm_share):
            return None
        return cls(share=robot.arm_share, friction=robot.friction, gear_ratio=robot.drive.gear_ratio)

    def reach(self, dt: float) -> Array:
        """Return the change of speed that bends bristles by a part of their length."""
        return _PART * self.friction.coulomb / (self.friction.bristle_stiffness * np.abs(self.gear_ratio) * dt)

    def initial_memory(self, state: State) -> Array:
        """Return relaxed bristles, and the speed that they see, in units of the motor."""
        speed = self.gear_ratio * state.link_speed
        return np.stack([np.zeros_like(speed), speed], axis=-1)

    def brake(self, speed: Array, load: Array | None, memory: Array, dt: float) -> Braking:
        """Bend bristles along the link's way since the last state, and let them pull at the link."""
        ratio = self.gear_ratio
        speed = ratio * speed
        bent = self.friction.bend_bristles(memory[..., 0], 0.5 * (memory[..., 1] + speed), speed, dt)
        lever, lever_of_slope = self._levers
        later, slope = np.empty_like(memory), np.empty_like(memory)
        later[..., 0], later[..., 1] = bent.bristle, speed
        slope[..., 0], slope[..., 1] = ratio * bent.bristle_slope, ratio
        return Braking(
            torque=lever * bent.torque, slope=lever_of_slope * bent.torque_slope, memory=later, memory_slope=slope
        )

    @cached_property
    def _levers(self) -> tuple[Array, Array]:
        """Torque on links per torque of bristles, and per slope of that by the motor's speed, (N,) each."""
        lever = self.share * self.gear_ratio
        return -lever, lever * self.gear_ratio
