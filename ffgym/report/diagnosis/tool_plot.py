"""Path of the tool: as tracked, and where the models have it, their difference magnified."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.residual import Residual
from ffgym.report.diagnosis.models import LOOKS, NOMINAL
from ffgym.report.tool_path import ToolPath, scale_of_error, tool_path_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def tool_figure(models: Mapping[str, Residual], motion: int) -> "Figure":
    """Tracked path and tracked path + factor x (model - tracked), in one or two views."""
    tracked, paths = _paths(models, motion)
    look = {"label": "tracked", "zorder": 1, **LOOKS["measured"]}
    factor, sizes = scale_of_error(paths, tracked), ((6.4, 5.2), (10.4, 5.2))
    return tool_path_figure(paths, tracked, look, factor, what="difference", sizes=sizes)


def tool_caption(models: Mapping[str, Residual], motion: int) -> str:
    """What is drawn, with the largest difference by each model."""
    tracked, paths = _paths(models, motion)
    largest = ", ".join(f"{path.label} {1e6 * path.distance.max():.0f} µm" for path in paths)
    return (
        f"Motion {models[NOMINAL].motions[motion].motion}. Position of the tool by the tracker, and by the models "
        f"behind the measured motors, their difference drawn {scale_of_error(paths, tracked):g} times as large "
        f"(largest, dots: {largest})."
    )


def _paths(models: Mapping[str, Residual], motion: int) -> tuple[Array, list[ToolPath]]:
    """Tracked positions (R, 3) [m] in rows that count, and those by the models beside them."""
    nominal = models[NOMINAL].motions[motion]
    rows = nominal.valid & np.isfinite(nominal.measured["tool"]).all(axis=1)
    tracked = nominal.measured["tool"][rows]
    return tracked, [
        ToolPath(label=name, nearest=tracked, error=-residual.motions[motion].residual["tool"][rows], look=LOOKS[name])
        for name, residual in models.items()
    ]
