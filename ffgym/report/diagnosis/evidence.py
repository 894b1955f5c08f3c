"""Residual of one joint over time, variables, the motor's turn and speed, and the path of the tool."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.patterns import compute_turn_spectrum
from ffgym.diagnosis.patterns.periodic import Amplitude
from ffgym.diagnosis.profiles import VARIABLES, Variable, compute_profiles
from ffgym.diagnosis.regimes import LogRows, collect_rows, map_by_motion
from ffgym.diagnosis.residual import UNITS, Channel, Residual, components
from ffgym.report.diagnosis.diagnosis_report import DiagnosisReport, Place
from ffgym.report.diagnosis.words import LOOKS, NOMINAL, counting, fine_scale_of, scale_of
from ffgym.report.figure import ReportFigure, keep_peaks, panels
from ffgym.report.identification.plots import NEW, OLD
from ffgym.report.page import words_of
from ffgym.report.table import shorten
from ffgym.report.tool_path import ToolPath, choose_scale, tool_path_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LOOPS = 3
"""Motions whose friction loops are shown."""


def place_figures(report: DiagnosisReport, place: Place) -> list[ReportFigure]:
    """Draw the residual of one joint."""
    models, channel, j = report.models, place.channel, place.index
    nominal, words = models[NOMINAL], words_of("diagnosis_figures")
    ratio = map_by_motion(nominal, channel).ratio[j]
    order = np.argsort(-np.nan_to_num(ratio, nan=-1.0), kind="stable")
    worst = [int(motion) for motion in order if np.isfinite(ratio[motion])][:_LOOPS]
    rows = {name: collect_rows(residual, channel) for name, residual in models.items()}
    unit, scale = nominal.robot.kinematics.units[j], scale_of(nominal.robot, channel, j)
    figures = [_time_figure(models, place, worst[0])]
    if (depends := profiles_figure(rows, channel, j, j, unit, scale)) is not None:
        title = f"{place.component}, {channel}: what the residual depends on"
        figures.append(ReportFigure(f"depends-{channel}-{j + 1}", title, words["depends"], depends))
    marked = [
        pattern.frequency
        for pattern in report.diagnosis.patterns
        if pattern.kind == "periodic" and pattern.component == place.component and pattern.frequency is not None
    ]
    if (repeats := _spectrum_figure(models, place, marked)) is not None:
        figures.append(repeats)
    if channel == "torque":
        figures.append(_loops_figure(models, place, worst))
    return figures


def _time_figure(models: Mapping[str, Residual], place: Place, motion: int) -> ReportFigure:
    """Measured and predicted, residuals with the noise floor, and the speed of a motor, over time."""
    channel, j, robot, nominal = place.channel, place.index, models[NOMINAL].robot, models[NOMINAL].motions[motion]
    (factor, unit), (plain, shown) = fine_scale_of(robot, channel, j), scale_of(robot, channel, j)
    noise = 2 * factor * models[NOMINAL].floor[channel][motion, j]
    with panels(3, 1, size=(8.6, 5.4), sharex=True, height_ratios=(3, 2, 1.2)) as (figure, grid):
        # signal above, residual against the noise, speed below, where friction reverses
        upper, middle, lower = grid[:, 0]
        measured = counting(nominal, nominal.measured[channel][:, j])
        upper.plot(nominal.t, plain * measured, label="measured", **LOOKS["measured"])
        middle.axhspan(-noise, noise, color="#dfe5ec", linewidth=0, label="noise (two sigma)")
        for name, residual in models.items():
            one = residual.motions[motion]
            upper.plot(one.t, plain * counting(one, one.predicted[channel][:, j]), label=name, **LOOKS[name])
            middle.plot(one.t, factor * counting(one, one.residual[channel][:, j]), **LOOKS[name])
        lower.plot(nominal.t, counting(nominal, nominal.state.motor_speed[:, j]), color="black", linewidth=0.8)
        upper.set_ylabel(f"{channel} [{shown}]")
        middle.set_ylabel(f"residual [{unit}]")
        lower.set_ylabel("motor [rad/s]")
        lower.set_xlabel("time [s]")
        figure.align_ylabels()
    return ReportFigure(
        name=f"time-{channel}-{j + 1}",
        title=f"{place.component}, {channel}: the motion in which it stands out most",
        caption=f"Motion {nominal.motion}. What is measured and predicted has gone through the same low-pass without "
        "delay.",
        figure=figure,
    )


_DIRECTIONS = {
    "both": ("#444444", "-", "both directions"),
    "forwards": (NEW, "-", "forwards"),
    "back": (OLD, "--", "back"),
}
"""Colour, line and words by direction of motion."""
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
        name: {log: compute_profiles(rows, component, joint, variable) for log, rows in logs.items()}
        for name, variable in VARIABLES.items()
    }
    shown = {name: of for name, of in found.items() if any(p.mean.size for one in of.values() for p in one.values())}
    if not shown:
        return None
    rows = -(-len(shown) // _WIDEST)
    with panels(rows, _WIDEST, size=(3.3 * _WIDEST + 0.3, 2.5 * rows + 0.5), sharey=True) as (figure, grid):
        for axes, (name, of_logs) in zip(grid.flat, shown.items(), strict=False):
            for k, (log, of_directions) in enumerate(of_logs.items()):
                width, alpha = (1.3, 1.0) if k == 0 else (0.8, 0.45)
                for direction, profile in of_directions.items():
                    colour, line, words = _DIRECTIONS[direction]
                    low, mean, high = factor * profile.low, factor * profile.mean, factor * profile.high
                    if k == 0:
                        axes.fill_between(profile.centre, low, high, color=colour, alpha=0.2, linewidth=0)
                    look: dict[str, Any] = {"color": colour, "linewidth": width, "alpha": alpha}
                    axes.plot(profile.centre, mean, line, label=f"{log}, {words}", **look)
            _name_axis(axes, VARIABLES[name], unit if name == "position" else VARIABLES[name].unit)
        for axes in grid.flat[len(shown) :]:
            axes.set_visible(False)
        for axes in grid[:, 0]:
            axes.set_ylabel(f"mean residual [{of_residual}]")
    return figure


def _name_axis(axes: "Axes", variable: Variable, unit: str) -> None:
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


FORMS: Mapping[Amplitude, str] = MappingProxyType(
    {"constant": "amplitude that is always the same", "torque": "amplitude that goes with the torque"}
)
"""Forms of what repeats that are shown, and what they are called."""


def _spectrum_figure(models: Mapping[str, Residual], place: Place, marked: Sequence[float]) -> ReportFigure | None:
    """Amplitude over cycles per turn of the motor, one panel for each form, one line for each model.

    None where the motor turns too little to tell; cycles per turn that were found are `marked`.
    """
    channel, j = place.channel, place.index
    found = {form: _amplitudes(models, place, form) for form in FORMS}
    if not all(found.values()):
        return None
    with panels(1, len(FORMS), size=(9.4, 3.0), sharey=True) as (figure, grid):
        for axes, (form, lines) in zip(grid[0], found.items(), strict=True):
            for name, (frequency, amplitude) in lines.items():
                shown = keep_peaks(amplitude)
                axes.plot(frequency[shown], amplitude[shown], label=name, color=LOOKS[name]["color"], linewidth=0.9)
            axes.set_title(FORMS[form], fontsize=9)
            axes.set_xscale("log")
            axes.set_xlabel("cycles per turn of the motor")
        grid[0, 0].set_ylim(bottom=0.0)
        grid[0, 0].set_ylabel(f"amplitude [{fine_scale_of(models[NOMINAL].robot, channel, j)[1]}]")
        for axes in grid[0]:
            for cycles in marked:
                axes.axvline(cycles, color="#5a6472", linewidth=0.8, linestyle=":")
                axes.text(cycles, axes.get_ylim()[1], f" {cycles:.2f}", fontsize=8, va="top")
    title = f"{place.component}, {channel}: what repeats with the motor"
    return ReportFigure(f"repeats-{channel}-{j + 1}", title, words_of("diagnosis_figures")["repeats"], figure)


def _amplitudes(models: Mapping[str, Residual], place: Place, form: Amplitude) -> dict[str, tuple[Array, Array]]:
    """Cycles per turn and amplitudes, in the unit in which people read them, by model; nothing if there are none."""
    channel, j, found = place.channel, place.index, {}
    for name, residual in models.items():
        of = components(channel, residual.robot)[j]
        spectrum = compute_turn_spectrum(residual, channel, of, place.component, amplitude=form)
        if spectrum is not None:
            # RMS of the residual about its mean over each motion.
            rows = collect_rows(residual, channel)
            known = np.isfinite(rows.residual[:, j])
            values, motion = rows.residual[known, j], rows.motion[known]
            count = np.bincount(motion, minlength=rows.motion.max() + 1)
            mean = np.bincount(motion, weights=values, minlength=len(count)) / np.maximum(count, 1)
            size = rms(values - mean[motion]) * fine_scale_of(residual.robot, channel, j)[0]
            found[name] = (spectrum.frequency, size * np.sqrt(2 * spectrum.share))
    return found


def _loops_figure(models: Mapping[str, Residual], place: Place, motions: Sequence[int]) -> ReportFigure:
    """One panel for each of `motions`, places in the log: torque without what the arm takes, over motor speed."""
    j = place.index
    factor, unit = scale_of(models[NOMINAL].robot, "torque", j)
    with panels(1, len(motions), size=(3.1 * len(motions) + 0.5, 3.2)) as (figure, grid):
        for axes, motion in zip(grid[0], motions, strict=True):
            nominal = models[NOMINAL].motions[motion]
            # What the nominal model predicts without its friction.
            state = nominal.state
            friction = state.friction_level * state.friction_sign + state.viscous * state.motor_speed
            rest = nominal.predicted["torque"][:, j] - friction[:, j]
            lines = {"measured": nominal.measured["torque"][:, j]}
            lines |= {name: residual.motions[motion].predicted["torque"][:, j] for name, residual in models.items()}
            for name, torque in lines.items():
                shown = factor * counting(nominal, torque - rest)
                axes.plot(state.motor_speed[:, j], shown, label=name, **LOOKS[name])
            axes.set_title(shorten(nominal.motion), fontsize=8)
            axes.set_xlabel("motor speed [rad/s]")
        grid[0, 0].set_ylabel(f"friction {'torque' if unit == 'N m' else 'force'} [{unit}]")
    caption = words_of("diagnosis_figures")["over_speed"]
    return ReportFigure(f"loops-{j + 1}", f"{place.component}: friction over speed", caption, figure)


def tool_figures(report: DiagnosisReport) -> list[ReportFigure]:
    """Path of the tool in the motion in which it stands out most; none without a tracker."""
    if report.before is None or "tool" not in report.before.channels:
        return []
    ratio = map_by_motion(report.before, "tool").ratio
    if np.isnan(ratio).all():
        return []
    worst = int(np.nanargmax(np.nanmax(ratio, axis=0, initial=0.0)))
    nominal = report.before.motions[worst]
    rows = nominal.valid & np.isfinite(nominal.measured["tool"]).all(axis=1)
    tracked = nominal.measured["tool"][rows]
    paths = [
        ToolPath(label=name, nearest=tracked, error=-residual.motions[worst].residual["tool"][rows], look=LOOKS[name])
        for name, residual in report.models.items()
    ]
    factor = choose_scale(paths, tracked)
    largest = ", ".join(f"{path.label} {1e6 * path.distance.max():.0f} µm" for path in paths)
    look = {"label": "tracked", "zorder": 1, **LOOKS["measured"]}
    sizes = ((6.4, 5.2), (10.4, 5.2))
    return [
        ReportFigure(
            name="tool",
            title="Path of the tool",
            caption=f"Motion {nominal.motion}. Position of the tool by the tracker, and by the models behind the "
            f"measured motors, their difference drawn {factor:g} times as large (largest, dots: {largest}).",
            figure=tool_path_figure(paths, tracked, look, factor, what="difference", sizes=sizes),
        )
    ]
