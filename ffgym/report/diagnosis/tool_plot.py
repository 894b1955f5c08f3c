"""Path of the tool: as tracked, and where the models have it, their difference magnified."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.residual import Residual
from ffgym.report._matplotlib import house_style, legend_above, new_figure
from ffgym.report.diagnosis.models import LOOKS, NOMINAL
from ffgym.report.motion.tool_path_plot import round_factor, sights_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def tool_figure(models: Mapping[str, Residual], motion: int) -> "Figure":
    """Tracked path and tracked path + factor x (model - tracked), in one or two views."""
    tracked, errors = _errors(models, motion)
    factor = _factor(models, motion)
    sights = sights_of(tracked)
    with house_style():
        figure = new_figure(6.4 if len(sights) == 1 else 10.4, 5.2)
        for axes, sight in zip(figure.subplots(1, len(sights), squeeze=False)[0], sights, strict=True):
            axes.plot(*sight.flat(tracked).T, label="tracked", **LOOKS["measured"])
            for name, error in errors.items():
                axes.plot(*sight.flat(tracked + factor * error).T, label=name, **LOOKS[name])
            axes.set(xlabel=sight.labels[0], ylabel=sight.labels[1])
            axes.set_title("true scale" if factor == 1 else f"difference × {factor:g}")
            axes.set_aspect("equal", adjustable="datalim")
        legend_above(figure, *figure.axes[0].get_legend_handles_labels())
    return figure


def tool_caption(models: Mapping[str, Residual], motion: int) -> str:
    """What is drawn, with the largest difference by each model."""
    _, errors = _errors(models, motion)
    largest = ", ".join(f"{name} {1e6 * np.linalg.norm(e, axis=1).max():.0f} µm" for name, e in errors.items())
    return (
        f"Motion {models[NOMINAL].motions[motion].motion}. Position of the tool by the tracker, and by the models "
        f"behind the measured motors, their difference drawn {_factor(models, motion):g} times as large "
        f"(largest: {largest})."
    )


def _factor(models: Mapping[str, Residual], motion: int) -> float:
    tracked, errors = _errors(models, motion)
    largest = max(float(np.linalg.norm(error, axis=1).max()) for error in errors.values())
    return round_factor(float(np.linalg.norm(np.ptp(tracked, axis=0))), largest)


def _errors(models: Mapping[str, Residual], motion: int) -> tuple[Array, dict[str, Array]]:
    """Tracked positions (R, 3) [m] in rows that count, and model minus tracked by model."""
    nominal = models[NOMINAL].motions[motion]
    rows = nominal.valid & np.isfinite(nominal.measured["tool"]).all(axis=1)
    errors = {name: -residual.motions[motion].residual["tool"][rows] for name, residual in models.items()}
    return nominal.measured["tool"][rows], errors
