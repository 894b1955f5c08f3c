"""What the residual of one joint looks like (over time, variables, the motor's turn, speed), and the tool's path."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.patterns import cycles_per_turn
from ffgym.diagnosis.patterns.periodic import Amplitude
from ffgym.diagnosis.profiles import VARIABLES, Profile, Variable, profiles
from ffgym.diagnosis.regimes import LogRows, log_rows
from ffgym.diagnosis.residual import UNITS, Channel, MotionResidual, Residual, components
from ffgym.report.diagnosis.words import LOOKS, NOMINAL, counting, fine_scale_of, motor_speed, scale_of
from ffgym.report.figure import panels, peaks_kept
from ffgym.report.identification.friction_plots import NEW, OLD
from ffgym.report.table import shortened
from ffgym.report.tool_path import ToolPath, scale_of_error, tool_path_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def time_figure(models: Mapping[str, Residual], channel: Channel, component: int, joint: int, motion: int) -> "Figure":
    """Measured and predicted, residuals with the noise floor, and the speed of a motor, over time.

    Args:
        models: residuals by model, the nominal one among them.
        channel: what is shown.
        component: which component of it.
        joint: whose motor's speed stands below.
        motion: which motion of the log.
    """
    robot, nominal = models[NOMINAL].robot, models[NOMINAL].motions[motion]
    (factor, unit), (plain, shown) = fine_scale_of(robot, channel, joint), scale_of(robot, channel, joint)
    noise = 2 * factor * models[NOMINAL].floor[channel][motion, component]
    with panels(3, 1, size=(8.6, 5.4), sharex=True, height_ratios=(3, 2, 1.2)) as (figure, grid):
        upper, middle, lower = grid[:, 0]
        measured = counting(nominal, nominal.measured[channel][:, component])
        upper.plot(nominal.t, plain * measured, label="measured", **LOOKS["measured"])
        middle.axhspan(-noise, noise, color="#dfe5ec", linewidth=0, label="noise (two sigma)")
        for name, residual in models.items():
            one = residual.motions[motion]
            predicted = plain * counting(one, one.predicted[channel][:, component])
            upper.plot(one.t, predicted, label=name, **LOOKS[name])
            middle.plot(one.t, factor * counting(one, one.residual[channel][:, component]), **LOOKS[name])
        lower.plot(nominal.t, counting(nominal, motor_speed(nominal, joint)), color="black", linewidth=0.8)
        upper.set_ylabel(f"{channel} [{shown}]")
        middle.set_ylabel(f"residual [{unit}]")
        lower.set_ylabel("motor [rad/s]")
        lower.set_xlabel("time [s]")
        figure.align_ylabels()
    return figure


_DIRECTIONS = {"both": "#444444", "forwards": NEW, "back": OLD}
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
    rows = -(-len(shown) // _WIDEST)
    with panels(rows, _WIDEST, size=(3.3 * _WIDEST + 0.3, 2.5 * rows + 0.5), sharey=True) as (figure, grid):
        for axes, (name, of_logs) in zip(grid.flat, shown.items(), strict=False):
            for log, (place, of_directions) in zip(of_logs, enumerate(of_logs.values()), strict=True):
                _draw_profile(axes, of_directions, log, factor, pale=place > 0)
            _name_axis(axes, VARIABLES[name], unit if name == "position" else VARIABLES[name].unit)
        for axes in grid.flat[len(shown) :]:
            axes.set_visible(False)
        for axes in grid[:, 0]:
            axes.set_ylabel(f"mean residual [{of_residual}]")
    return figure


def _draw_profile(axes: "Axes", found: Mapping[str, Profile], log: str, factor: float, *, pale: bool) -> None:
    for direction, profile in found.items():
        label = f"{log}, {direction}" if direction != "both" else f"{log}, both directions"
        colour = _DIRECTIONS[direction]
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


def spectrum_figure(
    models: Mapping[str, Residual], channel: Channel, component: int, joint: str, marked: Sequence[float]
) -> "Figure | None":
    """Amplitude over cycles per turn, one panel for each form, one line for each model.

    Args:
        models: residuals by model.
        channel: which channel of them.
        component: which component of the channel.
        joint: whose motor turns.
        marked: cycles per turn of what was found.

    Returns:
        None where the motor turns too little to tell.
    """
    found = {form: _amplitudes(models, channel, component, joint, form) for form in FORMS}
    if not all(found.values()):
        return None
    unit = fine_scale_of(next(iter(models.values())).robot, channel, component)[1]
    with panels(1, len(FORMS), size=(9.4, 3.0), sharey=True) as (figure, grid):
        for axes, (form, lines) in zip(grid[0], found.items(), strict=True):
            for name, (frequency, amplitude) in lines.items():
                shown = peaks_kept(amplitude)
                axes.plot(frequency[shown], amplitude[shown], label=name, color=LOOKS[name]["color"], linewidth=0.9)
            axes.set_title(FORMS[form], fontsize=9)
            axes.set_xscale("log")
            axes.set_xlabel("cycles per turn of the motor")
        grid[0, 0].set_ylim(bottom=0.0)
        grid[0, 0].set_ylabel(f"amplitude [{unit}]")
        for axes in grid[0]:
            _mark(axes, marked)
    return figure


def _mark(axes: "Axes", marked: Sequence[float]) -> None:
    for frequency in marked:
        axes.axvline(frequency, color="#5a6472", linewidth=0.8, linestyle=":")
        axes.text(frequency, axes.get_ylim()[1], f" {frequency:.2f}", fontsize=8, va="top")


def _amplitudes(
    models: Mapping[str, Residual], channel: Channel, component: int, joint: str, form: Amplitude
) -> dict[str, tuple[Array, Array]]:
    """Cycles per turn and amplitudes, in the unit in which people read them, by model; nothing if there are none."""
    found = {}
    for name, residual in models.items():
        of = components(channel, residual.robot)[component]
        spectrum = cycles_per_turn(residual, channel, of, joint, amplitude=form)
        if spectrum is not None:
            size = _deviation(log_rows(residual, channel), component)
            size *= fine_scale_of(residual.robot, channel, component)[0]
            found[name] = (spectrum.frequency, size * np.sqrt(2 * spectrum.share))
    return found


def _deviation(rows: LogRows, component: int) -> float:
    """RMS of a residual about its mean over each motion, in the unit of the channel."""
    values, motion = rows.residual[:, component], rows.motion
    known = np.isfinite(values)
    count = np.bincount(motion[known], minlength=motion.max() + 1)
    mean = np.bincount(motion[known], weights=values[known], minlength=len(count)) / np.maximum(count, 1)
    return rms(values[known] - mean[motion[known]])


def loops_figure(models: Mapping[str, Residual], joint: int, motions: Sequence[int]) -> "Figure":
    """One panel for each of `motions`, places in the log: torque without what the arm takes, over motor speed."""
    factor, unit = scale_of(models[NOMINAL].robot, "torque", joint)
    with panels(1, len(motions), size=(3.1 * len(motions) + 0.5, 3.2)) as (figure, grid):
        for axes, place in zip(grid[0], motions, strict=True):
            nominal = models[NOMINAL].motions[place]
            rest = nominal.predicted["torque"][:, joint] - _friction(nominal, joint)
            lines = {"measured": nominal.measured["torque"][:, joint]}
            lines |= {name: residual.motions[place].predicted["torque"][:, joint] for name, residual in models.items()}
            for name, torque in lines.items():
                axes.plot(
                    motor_speed(nominal, joint), factor * counting(nominal, torque - rest), label=name, **LOOKS[name]
                )
            axes.set_title(shortened(nominal.motion), fontsize=8)
            axes.set_xlabel("motor speed [rad/s]")
        grid[0, 0].set_ylabel(f"friction {'torque' if unit == 'N m' else 'force'} [{unit}]")
    return figure


def _friction(motion: MotionResidual, joint: int) -> Array:
    """Friction of the nominal model along a motion [N m], shape (R,)."""
    state = motion.state
    peak = (state.static - state.coulomb) * np.exp(-((state.motor_speed / state.stribeck_velocity) ** 2))
    friction: Array = ((state.coulomb + peak) * state.friction_sign + state.viscous * state.motor_speed)[:, joint]
    return friction


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
