"""Names, colours and lines of the nominal and the extended model, and units in which residuals are read."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.residual import MotionResidual, Residual
from ffgym.report.identification.friction_plots import MEASURED, NEW, OLD

NOMINAL, EXTENDED = "nominal model", "extended model"
"""What models are called in pictures."""

LOOKS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "measured": {"color": MEASURED, "linewidth": 2.2},
        NOMINAL: {"color": OLD, "linewidth": 1.1, "linestyle": "--"},
        EXTENDED: {"color": NEW, "linewidth": 1.1},
    }
)
"""How lines are drawn."""

FINE: Mapping[str, tuple[float, str]] = MappingProxyType(
    {"N m": (1.0, "N m"), "N": (1.0, "N"), "m": (1e6, "µm"), "rad": (1e6, "µrad")}
)
"""Factor and unit in which people read a residual of that unit."""


def by_model(before: Residual, after: Residual | None) -> dict[str, Residual]:
    """Residuals by the name of the model: the nominal one, and the extended one if there is one."""
    return {NOMINAL: before} | ({} if after is None else {EXTENDED: after})


def counting(motion: MotionResidual, values: Array) -> Array:
    """Values (R,) along a motion, NaN in rows that do not count."""
    return np.where(motion.valid, values, np.nan)


def motor_speed(motion: MotionResidual, joint: int) -> Array:
    """Motor speed of a joint along a motion [rad/s], shape (R,)."""
    speed: Array = motion.state.motor_speed[:, joint]
    return speed
