"""M3: a motor that gives more or less torque than its drive believes."""

from dataclasses import dataclass
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueConstant(TorqueEffect):
    """Torque per current other than documented, lower when the magnets are warm, and lower near the peak torque."""

    name = "torque_constant"
    code = "M3"
    title = "torque constant and saturation"
    equation = r"\tau \mathrel{+}= u \left( e + m (T - T_r) - c\, (u / u_{peak})^2 \right)"
    side = "motor"
    signature = "torque: a share of all of it, gravity, inertia and friction alike"
    way_in = "torque at every physics step, a share of what the servo commands"
    confusable_with = ("F6",)
    separating_motions = ("holds", "slow_triangles")
    patterns = (("function", "load"),)

    error: Array = parameter(
        "e", unit="1", low=-0.1, high=0.1, minimum=-0.9, source="tolerance of magnets and current sensors, 10 %"
    )
    saturation: Array = parameter(
        "c, share lost at peak torque",
        unit="1",
        low=0.0,
        high=0.2,
        minimum=0.0,
        maximum=0.3,
        source="chosen; above 1/3 more current would give less torque",
    )
    magnets: Array = parameter(
        "m, by temperature",
        unit="1/K",
        low=-0.002,
        high=0.0,
        source="-0.1 %/K for NdFeB, -0.2 %/K for ferrite magnets; from memory of data sheets",
    )
    reference: Array = parameter(
        "T_r, temperature at which the documented constant holds",
        unit="degC",
        null=None,
        low=20.0,
        high=60.0,
        minimum=-40.0,
        default=20.0,
        source="chosen: from the room's to that of a warm motor",
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the error of the torque that the servo commands."""
        u = state.loop_torque
        warm = self.magnets * (state.temperature - self.reference)
        return Torques(motor=u * (self.error + warm - self.saturation * (u / state.peak_torque) ** 2)), memory
