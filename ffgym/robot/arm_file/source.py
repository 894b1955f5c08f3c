"""An arm file as MuJoCo's editable model, with what that model has no place for."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import mujoco


@dataclass(frozen=True, kw_only=True, eq=False)
class Source:
    """Common form of both formats."""

    spec: mujoco.MjSpec
    """Bodies, joints, masses and geoms, ready to be compiled."""
    speeds: Mapping[str, float] = field(default_factory=dict)
    """Speed limits of joints [rad/s] or [m/s]."""
    gear_ratios: Mapping[str, float] = field(default_factory=dict)
    """Motor over joint motion, of joints."""
    has_masses: bool = True
    """Whether it says what links weigh; if not, the model's masses are stand-ins that mean nothing."""
    notes: tuple[str, ...] = ()
    """What is left out."""
