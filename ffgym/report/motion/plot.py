"""Figures of any motion: path of the tool with its error magnified, errors and torques over time."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.types import Array
from ffgym.recordings import Recording
from ffgym.recordings.metrics import Contour, motor_error
from ffgym.report.figure import ReportFigure, keep_peaks, panels
from ffgym.report.laws import law_styles
from ffgym.report.tool_path import ToolPath, choose_scale, choose_sights, tool_path_figure
from ffgym.studies import MotionStudy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NEAR = 80.0
"""Torque [% of peak] from which on the limits are drawn beside it; below them they would only flatten the curves."""
Signal = Callable[[Recording], tuple[Array, Array]]
"""Function from a recording to times (T,) [s] and curves, one column per panel, (T, P)."""


def motion_figures(study: MotionStudy, motion: str) -> list[ReportFigure]:
    """Draw the figures of one motion; those of the tool only if it was measured."""
    figures = [_motor_errors(study, motion), _torques(study, motion)]
    if any(result.path for result in study.results_of(motion)):
        figures = [_tool_paths(study, motion), _path_error(study, motion), *figures]
    return figures


def _motor_errors(study: MotionStudy, motion: str) -> ReportFigure:
    """Draw motor error [mrad] over time, one panel per joint, one line per law."""
    joints, styles, worst = study.robot.joints, law_styles(study.agents), []
    for result in study.results_of(motion):
        joint = int(np.argmax(result.motor_rms_rad))
        size = result.motor_rms_rad[joint] * 1e3
        worst.append(f"{styles[result.agent].label}: {joints[joint]}, {size:.2f} mrad RMS")
    return ReportFigure(
        name="motor-errors",
        title="Motor errors",
        caption="Reference minus motor angle, motor side. Grey: standstill. "
        f"Joint that strays most: {'; '.join(worst)}.",
        figure=_panels(study, motion, lambda run: (run.t, motor_error(run) * 1e3), joints, "motor error [mrad]"),
    )


def _torques(study: MotionStudy, motion: str) -> ReportFigure:
    """Draw the commanded torque of each drive over time, in percent of its peak torque, with the limits dashed."""
    joints, peak, styles = study.robot.joints, study.robot.drive.peak_torque, law_styles(study.agents)

    def signal(recording: Recording) -> tuple[Array, Array]:
        return recording.t, 100 * recording.joint_array("command.effort") / peak

    figure = _panels(study, motion, signal, joints, "torque [% of peak]")
    for axes in figure.axes:
        if max(np.abs(axes.get_ylim())) > NEAR:
            for limit in (-100.0, 100.0):
                axes.axhline(limit, color="#444444", linewidth=0.9, linestyle=(0, (5, 3)))
    nearest = []
    for result in study.results_of(motion):
        joint = int(np.argmax(result.torque_use))
        nearest.append(f"{styles[result.agent].label}: {joints[joint]}, {result.torque_use[joint]:.0%}")
    limits = ", ".join(f"{joint} {own:.3g}" for joint, own in zip(joints, peak, strict=True))
    return ReportFigure(
        name="torques",
        title="Torque beside its limit",
        caption="Torque asked of each drive (feedback, rigid feed-forward and what the law adds), motor side, in "
        f"percent of its peak torque [N m]: {limits}. A drive gives no more than 100 %. Largest: {'; '.join(nearest)}.",
        figure=figure,
    )


def _path_error(study: MotionStudy, motion: str) -> ReportFigure:
    """Draw the distance of the TCP from its path, and its lag along it [mm], over time."""

    def signal(recording: Recording) -> tuple[Array, Array]:
        contour = Contour.of(recording)
        return recording.t[contour.rows], 1e3 * np.stack([contour.distance, contour.lag], axis=1)

    titles, styles, worst = ("across the path", "along the path, > 0 is behind"), law_styles(study.agents), []
    for result in study.results_of(motion):
        whole, *stretches = result.path
        where = max(stretches, key=lambda stretch: stretch.max_mm, default=whole)
        worst.append(f"{styles[result.agent].label} {where.max_mm:.3f} mm ({where.label}, from {where.start:.2f} s)")
    return ReportFigure(
        name="path-error",
        title="Path error over time",
        caption="Across: distance of the tool from the nearest point of its path. Along: how far it is behind its "
        "reference in the direction of motion. Offset at the start removed. Grey: standstill. "
        f"Largest distance: {'; '.join(worst)}.",
        figure=_panels(study, motion, signal, titles, "TCP error [mm]"),
    )


def _panels(study: MotionStudy, motion: str, signal: Signal, titles: Sequence[str], label: str) -> "Figure":
    """Draw one panel below the other, all laws in each."""
    with panels(len(titles), 1, size=(10.0, 1.35 * len(titles) + 0.9), sharex=True) as (figure, grid):
        for law, style in law_styles(study.agents).items():
            recording = study.recordings[law, motion]
            t, values = signal(recording)
            for axes, column in zip(grid[:, 0], values.T, strict=True):
                kept = keep_peaks(column)
                axes.plot(t[kept], column[kept], color=style.colour, linewidth=1.0, label=style.label)
        for axes, title in zip(grid[:, 0], titles, strict=True):
            axes.set_title(title, loc="left")
            for phase in recording.phases_of("standstill"):
                axes.axvspan(phase.start, phase.end, color="#f0f0f0", zorder=0)
        figure.supylabel(label, fontsize=9.0)
        grid[-1, 0].set_xlabel("time [s]")
        grid[-1, 0].set_xlim(recording.t[0], recording.t[-1])
    return figure


def _tool_paths(study: MotionStudy, motion: str) -> ReportFigure:
    """Draw the path of the tool with every law, and the reference dashed."""
    styles, paths = law_styles(study.agents), []
    widths = (
        np.linspace(2.4, 1.0, len(styles)) if len(styles) > 1 else [1.3]
    )  # lower lines stay visible beside upper ones
    for (law, style), width in zip(styles.items(), widths, strict=True):
        contour = Contour.of(study.recordings[law, motion])
        look = {"color": style.colour, "linestyle": style.line, "linewidth": width}
        paths.append(ToolPath(label=style.label, nearest=contour.nearest, error=contour.error, look=look))
    reference = study.recordings[study.agents[0], motion].vector("tcp_reference.position")
    factor, sights = choose_scale(paths, reference), choose_sights(reference)
    worst = ", ".join(f"{path.label} {1e3 * path.distance.max():.3f} mm" for path in paths)
    drawn = "drawn to scale" if factor == 1 else f"drawn {factor:g} times as large"
    hidden = max(float(np.abs(path.error @ sights[0].normal).max()) for path in paths)
    looked = f"Seen along its normal, up to {1e3 * hidden:.3f} mm are out of its plane. " if len(sights) == 1 else ""
    dashed = {"color": "k", "linewidth": 0.7, "linestyle": (0, (5, 3)), "label": "reference"}
    return ReportFigure(
        name="path",
        title="Path of the tool",
        caption=f"{looked}Dashed: reference. Deviations from it are {drawn}; where the tool is late on the right path "
        f"there is none. The offset at the start is removed. Dots: largest deviation in space ({worst}).",
        figure=tool_path_figure(paths, reference, dashed, factor),
    )
