"""F8: viscous friction that grows more, or less, than in proportion to the speed."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import FrictionEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class NonlinearViscous(FrictionEffect):
    """Viscous friction with a square term; a negative one is a lubricant that thins when it is sheared."""

    name = "nonlinear_viscous"
    code = "F8"
    title = "nonlinear viscous friction"
    equation = r"\tau_f \mathrel{+}= a f_v\, v\, |v| / v_r"
    signature = "torque: odd in the speed, curved at high speed"
    way_in = (
        "torque at every physics step; MuJoCo's damping polynomial would do, but a recording is evaluated by the same "
        "formula"
    )
    confusable_with = ("F2", "F7")
    separating_motions = ("speed_ladder",)
    patterns = (
        ("sign-locked function", "size of the motor speed"),
        ("function", "motor speed"),
    )

    share: Array = parameter(
        "a, more viscous friction at speed v_r, as a share of it",
        unit="1",
        low=-0.3,
        high=0.3,
        source="chosen: a third of viscous friction at top speed",
    )
    speed: Array = parameter(
        "v_r, motor side",
        unit="rad/s",
        null=None,
        low=100.0,
        high=600.0,
        minimum=1e-3,
        default=300.0,
        scale="top_speed",
        source="top speed of robot motors, 1000 to 6000 turns per minute",
    )

    def friction(self, state: State) -> Array:
        """Return the square term of viscous friction."""
        v = state.motor_speed
        return self.share * state.viscous * v * np.abs(v) / self.speed
