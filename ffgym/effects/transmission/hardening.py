"""T2: a gearbox that gets stiffer under load."""

from dataclasses import dataclass
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Hardening(TorqueEffect):
    """Stiffness that grows with the square of the deflection; the described one is that at no load."""

    name = "hardening"
    code = "T2"
    title = "hardening stiffness"
    equation = r"\tau_l = -k\, \delta\, (1 + h\, \delta^2)"
    side = "link"
    signature = "tool over load: bent like an S, with a third harmonic"
    way_in = (
        "torque at every physics step on the spring; MuJoCo's stiffness polynomial would do, but a recording is "
        "evaluated by the same formula"
    )
    confusable_with = ("T1", "T3")
    separating_motions = ("holds", "excitation")
    needs_elasticity = True

    growth: Array = parameter(
        "h",
        unit="1/rad^2",
        low=0.0,
        high=5e5,
        minimum=0.0,
        source="slope 1.5 to 4 times as steep at rated torque, 1 to 1.5 mrad, as at none; strain wave gears, "
        "from memory of the literature",
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the torque beyond that of a linear spring."""
        bent = state.deflection
        return Torques(spring=-state.joint_stiffness * self.growth * (bent * bent * bent)), memory
