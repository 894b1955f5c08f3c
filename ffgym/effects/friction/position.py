"""F9: friction that depends on where the joint is."""

from dataclasses import dataclass
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import FrictionEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State
from ffgym.effects.wave import Wave, phase


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PositionFriction(Wave, FrictionEffect):
    """Coulomb friction that rises and falls along the joint's turn."""

    name = "position_friction"
    code = "F9"
    title = "position-dependent friction"
    equation = r"\tau_f \mathrel{+}= a f_c \sin(k q + \varphi)\, s(v)"
    signature = "torque: sign of the speed times a periodic function of the joint angle"
    confusable_with = ("M1", "T5")
    separating_motions = ("slow_triangles", "speed_ladder")
    patterns = (("sign-locked function", "motor angle"),)

    share: Array = parameter(
        "a, of the Coulomb torque",
        unit="1",
        low=0.0,
        high=0.2,
        minimum=0.0,
        maximum=1.0,
        source="up to 0.2; from memory of the literature",
    )
    cycles: Array = parameter(
        "k, per radian of the joint (per metre of a slide)",
        role="cycles",
        unit="1/rad",
        null=None,
        low=1.0,
        high=40.0,
        minimum=0.0,
        default=10.0,
        tries=(1.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0),
        source="chosen: from a turn of the joint to that of a planet wheel",
    )
    phase: Array = phase("any")

    def friction(self, state: State) -> Array:
        """Return the wave of Coulomb friction at the joint angle."""
        level = self.share * state.coulomb * self.wave(state.joint_angle)
        return level * state.friction_sign
