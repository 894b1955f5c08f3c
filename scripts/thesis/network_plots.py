"""Figures of networks that learn, and of NARX networks: thesis Figures 5.2 to 5.18, 6.10 and 6.11."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification.narx import Samples
from ffgym.recordings import Recording
from ffgym.report.figure import house_style, legend_above, new_figure, panels
from ffgym.report.laws import law_styles
from scripts.thesis.narx import ESTIMATION, VALIDATION, NarxFit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def basis_figure(speeds: Array, values: Array, close_up: float) -> "Figure":
    """All basis functions (T, S) over motor speeds [rad/s] (T,), and a close-up of those near zero speed."""
    with panels(1, 2, size=(10.0, 2.6), sharey=True) as (figure, grid):
        both = grid[0]
        for axes, reach in zip(both, (float(speeds[-1]), close_up), strict=True):
            axes.plot(speeds, values, linewidth=0.9)
            axes.set(xlim=(-reach, reach), xlabel="motor speed [rad/s]")
        both[0].set(title="all splines", ylabel="value")
        both[1].set_title(f"within ±{close_up:g} rad/s")
    return figure


def orders_figure(
    places: Array, plain: Mapping[int, Array], printed: Mapping[int, Array], ends: Array, repeated: Mapping[int, Array]
) -> "Figure":
    """Splines by order: on plain knots (T, S) with the first one as printed (T,) above, on repeated knots below."""
    with panels(2, len(plain), size=(10.0, 4.2), sharex=True, sharey=True) as (figure, grid):
        for column, order in enumerate(plain):
            above, below = grid[0][column], grid[1][column]
            above.plot(places, plain[order], linewidth=1.2)
            if order in printed:
                above.plot(places, printed[order], color="black", linestyle=":", linewidth=1.2)
            below.plot(ends, repeated[order], linewidth=1.2)
            above.set_title(f"order {order}")
            below.set_xlabel("x")
        grid[0][0].set_ylabel("plain knots")
        grid[1][0].set_ylabel("outermost knots\nrepeated")
    return figure


_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""One per joint, shades of Okabe and Ito."""
_MARKERS = ("o", "s", "^", "D", "v", "P")


Training = Mapping[str, Array]
"""Mean squares of motor position 'error' and learning 'signal' over those of the first trial, shape (K, N) each."""

_ROWS = (("error", "position error $e_p$"), ("signal", "learning signal $u_p$"))


def training_figure(trainings: Mapping[str, Training], joints: Sequence[str]) -> "Figure":
    """Normalised mean squares on a logarithmic scale: two rows, one column per law, one line per joint."""
    with panels(
        2,
        len(trainings),
        size=(max(4.4 * len(trainings), 5.0), 5.2),
        legend=len(joints) > 1,
        sharex="col",
        sharey="row",
    ) as (figure, grid):
        for j, (title, training) in enumerate(trainings.items()):
            for i, (name, words) in enumerate(_ROWS):
                axes, left = grid[i][j], training[name]
                for k, joint in enumerate(joints):
                    colour, marker = _COLOURS[k % len(_COLOURS)], _MARKERS[k % len(_MARKERS)]
                    axes.plot(left[:, k], color=colour, marker=marker, markersize=3.5, label=joint)
                axes.set_yscale("log")
                grid[i][0].set_ylabel(f"mean square of\n{words} / first")
            grid[0][j].set_title(title)
            grid[1][j].set_xlabel("iteration")
            grid[1][j].xaxis.get_major_locator().set_params(integer=True)
    return figure


def training_caption(trainings: Mapping[str, Training], joints: Sequence[str]) -> str:
    """Write the caption of the figure, and what is left after the last trial."""
    ends = []
    for title, training in trainings.items():
        each = ", ".join(
            f"{joint} {error:.2g} and {signal:.2g}"
            for joint, error, signal in zip(joints, training["error"][-1], training["signal"][-1], strict=True)
        )
        ends.append(f"{title}: {each}")
    return (
        "Mean squares of motor position error and learning signal without standstill, over those of the first trial, "
        "which has no compensation; logarithmic. A joint that no longer improves is locked, so that its line goes on "
        f"level. Left at the end (error and signal): {'; '.join(ends)}."
    )


_COLUMNS = 3
_TOTAL, _WITHOUT_INTEGRAL = "#D55E00", "#0072B2"


def feedback_over_speed_figure(recording: Recording) -> "Figure":
    """Feedback torque over motor speed, one panel per joint, standstill left out."""
    joints = recording.header.joints
    moving = ~recording.mask(kind="standstill")
    speed = np.where(moving[:, None], recording.joint_array("reference.velocity"), np.nan)
    feedback = recording.joint_array("feedback.effort")
    n_rows = -(-len(joints) // _COLUMNS)
    with panels(n_rows, _COLUMNS, size=(10.0, 2.3 * n_rows)) as (figure, grid):
        for axes, joint in zip(grid.flat, range(len(joints)), strict=False):
            axes.plot(speed[:, joint], feedback[:, joint], color=_TOTAL, linewidth=0.9)
            axes.set_title(joints[joint])
        for axes in grid.flat[len(joints) :]:
            axes.set_visible(False)
        for row in grid:
            row[0].set_ylabel("feedback $u_c$ [N m]")
        for axes in grid[-1]:
            axes.set_xlabel("motor speed of the reference [rad/s]")
    return figure


def feedback_parts_figure(recording: Recording, joint: int) -> "Figure":
    """Feedback torque of one joint (counted from 0) over time, with and without its integral part."""
    feedback = recording.joint_array("feedback.effort")[:, joint]
    proportional = feedback - recording.joint_array("feedback.integral")[:, joint]
    with panels(size=(10.0, 3.0)) as (figure, grid):
        axes = grid[0, 0]
        axes.plot(recording.t, feedback, color=_TOTAL, label="feedback $u_c$")
        axes.plot(recording.t, proportional, color=_WITHOUT_INTEGRAL, label="without its integral part, $u_p$")
        axes.set(xlabel="time [s]", ylabel=f"torque of {recording.header.joints[joint]} [N m]")
    return figure


SHOWN = 2.0
"""Length that is drawn [s], the last of each record, where the start is forgotten; a period at 0.5 Hz."""
_MARGIN = 1.3
"""Torque axis over the largest friction: networks that run away leave the picture."""
_APART = 0.15
"""Between marks of one record, which is 1 wide."""
_SYMBOLS = "osD^v<>p"
_TRUE: dict[str, Any] = {"color": "black", "linewidth": 1.8, "label": "LuGre model"}


def narx_figure(fit: NarxFit, records: Mapping[str, Samples]) -> "Figure":
    """Free run over time (left) and over motor speed (right), on estimation (top) and validation data (bottom)."""
    with house_style():
        figure = new_figure(9.6, 5.6)
        grid = figure.subplots(2, 2, sharex="col", sharey="row")
        for row, name in zip(grid, (ESTIMATION, VALIDATION), strict=True):
            what = "estimation" if name == ESTIMATION else "validation"
            _draw_row(row, fit, records[name])
            row[0].set(title=f"{what}, {name}, over time", ylabel="friction torque [N m]")
            row[1].set_title(f"{what}, {name}, over speed")
        grid[1][0].set_xlabel("time [s]")
        grid[1][1].set_xlabel("motor speed [rad/s]")
        handles, labels = grid[0][0].get_legend_handles_labels()
        legend_above(figure, handles, labels)
    return figure


def _draw_row(row: "Sequence[Axes]", fit: NarxFit, samples: Samples) -> None:
    n_starts = fit.model.n_joints
    shown = slice(-round(SHOWN / samples.dt) - 1, None)
    t = samples.dt * np.arange(len(samples.torque))[shown]
    speed, torque = samples.motor_dq[shown, 0], samples.torque[shown, 0]
    networks = fit.model.simulate(np.repeat(samples.motor_dq, n_starts, axis=1))[shown]
    colour = law_styles(["narx"])["narx"].colour
    for axes, x in zip(row, (t, speed), strict=True):
        axes.plot(x, torque, **_TRUE)
        axes.plot(x, networks, color=colour, linewidth=0.6, alpha=0.5)
        axes.plot(x, networks[:, fit.typical], color=colour, linewidth=1.5, label="network, median start")
        axes.plot([], [], color=colour, linewidth=0.6, alpha=0.5, label="the other starts")
        size = _MARGIN * float(np.abs(torque).max())
        axes.set_ylim(-size, size)


def fits_figure(fits: Mapping[str, Array], floor: Array, records: Sequence[str]) -> "Figure":
    """Fit in free run on each record [%], one mark per network, with the static curve as floor (records,).

    Of the starts of a network (S, records) marks are medians; bars reach from the worst to the best.
    """
    with house_style():
        figure = new_figure(9.6, 4.2)
        axes = figure.subplots()
        x = np.arange(len(records))
        axes.plot(x, floor, color="black", linestyle="none", marker="_", markersize=22, label="static curve")
        for i, (label, values) in enumerate(fits.items()):
            middle = np.median(values, axis=0)
            reach = np.abs(np.quantile(values, [0, 1], axis=0) - middle)
            places = x + _APART * (i - (len(fits) - 1) / 2)
            axes.errorbar(places, middle, reach, fmt=_SYMBOLS[i], markersize=4, elinewidth=0.8, label=label)
        axes.set(ylim=(0, 102), ylabel="fit in free run [%]")
        axes.set_xticks(x, records, rotation=35, ha="right")
        legend_above(figure, *axes.get_legend_handles_labels())
    return figure
