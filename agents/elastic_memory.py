"""Memory of elastic feed-forward at a sample whose torque is computed next."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ffgym.agents.arm_friction import ArmState, Asked
from ffgym.agents.flexible_joints import Lead
from ffgym.core.types import Array

ARM_ROWS = 7
"""Numbers per joint of `ArmPast`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmPast:
    """Friction behind the elasticity at the sample."""

    state: ArmState
    asked: Asked
    """Part of the averages around the sample that comes from the step before it."""

    @classmethod
    def relaxed(cls, like: Array) -> Self:
        """Return the memory of an arm that rests, in the shape of an array (..., N)."""
        none = np.zeros_like(like)
        return cls(
            state=ArmState.relaxed(like),
            asked=Asked(torque=none, lead=Lead(angle=none, speed=none, acceleration=none)),
        )

    @property
    def rows(self) -> tuple[Array, ...]:
        """Memory (..., N) each."""
        state, asked, lead = self.state, self.asked, self.asked.lead
        before = (asked.torque, lead.angle, lead.speed, lead.acceleration)
        return state.bristle, state.lead, state.lead_speed, *before

    @classmethod
    def of(cls, rows: Array) -> Self:
        """Read rows (..., 7, N)."""
        bristle, lead, lead_speed, torque, *asked = (rows[..., k, :] for k in range(ARM_ROWS))
        angle, speed, acceleration = asked
        return cls(
            state=ArmState(bristle=bristle, lead=lead, lead_speed=lead_speed),
            asked=Asked(torque=torque, lead=Lead(angle=angle, speed=speed, acceleration=acceleration)),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class ElasticPast:
    """Memory of the law, (..., N) each but for the torque of the links."""

    gravity: Array
    """Load of the links at the start, link side [N m]."""
    links: Array
    """Torque of the links beyond it at the 2 w known samples around this one, link side [N m], (..., 2 w, N)."""
    lead: Lead
    """Lead for the links at the sample; all that follow are at the sample."""
    integral: Array
    """Integral of all lead since the start, link side [rad s]."""
    bristle: Array
    """Deflection of the bristles on the motors [rad]."""
    friction: Array
    """Part of the friction around the sample that comes from the step before it, motor side [N m]."""
    arm: ArmPast | None
    """Friction behind the elasticity; None where the law knows of none."""

    @classmethod
    def at_rest(cls, gravity: Array, links: Array, lead: Lead, *, arm: bool) -> Self:
        """Return the memory where a motion begins, from gravity, torque of the links and lead there."""
        still = np.zeros_like(gravity)
        behind = ArmPast.relaxed(still) if arm else None
        return cls(gravity=gravity, links=links, lead=lead, integral=still, bristle=still, friction=still, arm=behind)

    def pack(self) -> Array:
        """Pack the memory into one array (..., (2 w + 7) N), 7 N more with friction on the arm."""
        last = (self.lead.angle, self.lead.speed, self.lead.acceleration, self.integral, self.bristle, self.friction)
        arm = () if self.arm is None else self.arm.rows
        rows = np.concatenate([self.gravity[..., None, :], self.links, np.stack([*last, *arm], axis=-2)], axis=-2)
        return rows.reshape(*rows.shape[:-2], -1)

    @classmethod
    def unpack(cls, memory: Array, n: int, *, arm: bool) -> Self:
        """Unpack the memory of N joints; `arm` says that friction on the arm is part of it."""
        rows = memory.reshape(*memory.shape[:-1], -1, n)
        behind = None
        if arm:
            rows, behind = rows[..., :-ARM_ROWS, :], ArmPast.of(rows[..., -ARM_ROWS:, :])
        angle, speed, acceleration, integral, bristle, friction = (rows[..., k, :] for k in range(-6, 0))
        return cls(
            gravity=rows[..., 0, :],
            links=rows[..., 1:-6, :],
            lead=Lead(angle=angle, speed=speed, acceleration=acceleration),
            integral=integral,
            bristle=bristle,
            friction=friction,
            arm=behind,
        )
