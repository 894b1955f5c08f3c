"""Structure of an arm that gives way: joints without motors in the MuJoCo model, springs with some damping."""

from dataclasses import dataclass
from typing import Any

import mujoco

from ffgym.core.types import Array
from ffgym.effects.effect import ModelEffect
from ffgym.effects.parameters import parameter


@dataclass(frozen=True, kw_only=True, eq=False)
class FlexibleStructure(ModelEffect):
    """Part of the structure that gives way; members declare its compliance, and place its joints."""

    side = "link"
    separating_motions = ("excitation", "holds")

    compliance: Array
    """Compliance c of each joint without motor [rad/(N m)]; 0 where nothing gives way."""
    relaxation: Array = parameter(
        "t_d, damping over stiffness",
        unit="s",
        null=None,
        low=1e-4,
        high=5e-3,
        minimum=0.0,
        default=1e-3,
        per="machine",
        source="chosen: 1 to 20 % of critical damping at 10 Hz",
    )

    def joint(self, place: int, *, slides: bool = False) -> dict[str, Any]:
        """Type, stiffness and damping of the MuJoCo joint at a place of `compliance`."""
        compliance = self.compliance[place]
        return {
            "type": mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE,
            "stiffness": [1 / compliance, 0, 0],
            "damping": [float(self.relaxation) / compliance, 0, 0],
        }
