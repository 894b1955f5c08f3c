"""What a residual depends on: its mean over speed, position, load, travel, temperature and time, with bands."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ffgym.diagnosis.profiles import VARIABLES, Profile, Variable, profiles
from ffgym.diagnosis.regimes import LogRows
from ffgym.diagnosis.residual import UNITS, Channel
from ffgym.report.figure import house_style, legend_above, new_figure
from ffgym.report.identification.friction_plots import NEW, OLD

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = {"both": "#444444", "forwards": NEW, "back": OLD}
_LINES = {"both": "-", "forwards": "-", "back": "--"}
_WIDEST = 3
"""Panels side by side."""

_TICKS = 6
"""Intervals between ticks at most: small numbers take much room."""


def profiles_figure(
    logs: Mapping[str, LogRows],
    channel: Channel,
    component: int,
    joint: int,
    unit: str = "rad",
    scale: tuple[float, str] | None = None,
) -> "Figure | None":
    """One panel for each variable that changes; None where too few rows count to show any.

    Args:
        logs: rows of the log with the residual, the one that is drawn strongly first, others pale.
        channel: what residuals they are.
        component: which component of the channel.
        joint: whose motion they are shown over.
        unit: of the position of that joint.
        scale: factor and unit of the residual; None is that of the channel.
    """
    factor, of_residual = scale or (1.0, UNITS[channel])
    found = {
        name: {log: profiles(rows, component, joint, variable) for log, rows in logs.items()}
        for name, variable in VARIABLES.items()
    }
    shown = {name: of for name, of in found.items() if any(p.mean.size for one in of.values() for p in one.values())}
    if not shown:
        return None
    with house_style():
        rows = -(-len(shown) // _WIDEST)
        figure = new_figure(3.3 * _WIDEST + 0.3, 2.5 * rows + 0.5)
        panels = figure.subplots(rows, _WIDEST, squeeze=False, sharey=True).ravel()
        for axes, (name, of_logs) in zip(panels, shown.items(), strict=False):
            for log, (place, of_directions) in zip(of_logs, enumerate(of_logs.values()), strict=True):
                _draw(axes, of_directions, log, factor, pale=place > 0)
            _name(axes, VARIABLES[name], unit if name == "position" else VARIABLES[name].unit)
        for axes in panels[len(shown) :]:
            axes.set_visible(False)
        for axes in panels[::_WIDEST]:
            axes.set_ylabel(f"mean residual [{of_residual}]")
        entries = dict(entry for axes in panels for entry in zip(*axes.get_legend_handles_labels()[::-1], strict=True))
        legend_above(figure, list(entries.values()), list(entries))
    return figure


def profiles_caption() -> str:
    """What is drawn."""
    return (
        "Mean of measured minus predicted in bins of equally many rows. Bands: two standard errors, with one second of "
        "the log as one observation."
    )


def _draw(axes: "Axes", found: Mapping[str, Profile], log: str, factor: float, *, pale: bool) -> None:
    for direction, profile in found.items():
        label = f"{log}, {direction}" if direction != "both" else f"{log}, both directions"
        colour = _COLOURS[direction]
        if not pale:
            axes.fill_between(
                profile.centre, factor * profile.low, factor * profile.high, color=colour, alpha=0.2, linewidth=0
            )
        width, alpha = (0.8, 0.45) if pale else (1.3, 1.0)
        axes.plot(
            profile.centre,
            factor * profile.mean,
            _LINES[direction],
            color=colour,
            label=label,
            linewidth=width,
            alpha=alpha,
        )


def _name(axes: "Axes", variable: Variable, unit: str) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

    axes.axhline(0.0, color="#666666", linewidth=0.6)
    axes.set_xlabel(f"{variable.label} [{unit}]")
    if variable.logarithmic:
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
    else:
        axes.xaxis.set_major_locator(MaxNLocator(_TICKS, steps=[1, 2, 2.5, 5, 10]))
