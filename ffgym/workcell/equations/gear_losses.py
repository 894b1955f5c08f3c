"""Losses of a gear under load that differ by which side drives."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, TorqueEffect, Torques
from ffgym.effects.effect import Side
from ffgym.effects.parameters import parameter


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class GearLosses(TorqueEffect):
    r"""Friction in proportion to the transmitted torque: one share where the motor drives, another where the load does.

    .. math:: \tau = -\bar\mu \, |\tau_l / n| \, s - \delta \, (\tau_l / n) \, |s|, \quad
        \bar\mu = (\mu_d + \mu_b) / 2, \quad \delta = (\mu_d - \mu_b) / 2

    where the motor drives if load and speed have one sign. Continuous, as s passes through 0 where bristles turn.
    """

    name: ClassVar[str] = "gear_losses"
    title: ClassVar[str] = "Losses by load and direction of power"
    equation: ClassVar[str] = (
        "tau_f += mu_drive |tl/n| s where power flows to the link, mu_back |tl/n| s where it flows back"
    )
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = "friction that grows with the load, more on the way up than on the way down"
    way_in: ClassVar[str] = "torque on the motor"
    needs_elasticity: ClassVar[bool] = True
    needs_friction: ClassVar[bool] = True

    driving: Array = parameter(
        "share of the torque lost where the motor drives", unit="1", low=0.0, high=0.15, source="chosen", minimum=0.0
    )
    driven: Array = parameter(
        "share of the torque lost where the load drives", unit="1", low=0.0, high=0.15, source="chosen", minimum=0.0
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        mean, half = (self.driving + self.driven) / 2, (self.driving - self.driven) / 2
        load, sign = state.load_at_motor, state.friction_sign
        return Torques(motor=-mean * np.abs(load) * sign - half * load * np.abs(sign)), memory
