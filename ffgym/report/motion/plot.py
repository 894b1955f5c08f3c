"""The path of the tool on any motion with its error magnified; errors and torques over time."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.types import Array
from ffgym.recordings import Recording
from ffgym.recordings.metrics import Contour, motor_error
from ffgym.report.figure import panels
from ffgym.report.laws import law_styles
from ffgym.report.thinning import peaks_kept
from ffgym.report.tool_path import ToolPath, scale_of_error, sights_of, tool_path_figure
from ffgym.studies import MotionStudy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NEAR = 80.0
"""Torque [% of peak] from which on the limits are drawn beside it; below them they would only flatten the curves."""
Signal = Callable[[Recording], tuple[Array, Array]]
"""Times (T,) [s] and what to draw of a recording, one column per panel, (T, P)."""


def motor_errors_figure(study: MotionStudy, motion: str) -> "Figure":
    """Motor error [mrad] over time, one panel per joint, one line per law."""

    def signal(recording: Recording) -> tuple[Array, Array]:
        return recording.t, motor_error(recording) * 1e3

    return _panels(study, motion, signal, study.robot.joints, "motor error [mrad]")


def motor_errors_caption(study: MotionStudy, motion: str) -> str:
    """What the figure shows, and the joint that strays most with each law."""
    styles = law_styles(study.agents)
    worst = []
    for result in study.results_of(motion):
        joint = int(np.argmax(result.motor_rms_rad))
        size = result.motor_rms_rad[joint] * 1e3
        worst.append(f"{styles[result.agent].label}: {study.robot.joints[joint]}, {size:.2f} mrad RMS")
    return f"Reference minus motor angle, motor side. Grey: standstill. Joint that strays most: {'; '.join(worst)}."


def torques_figure(study: MotionStudy, motion: str) -> "Figure":
    """Torque that is asked of each drive over time, in percent of its peak torque, with the limits dashed."""
    peak = study.robot.drive.peak_torque

    def signal(recording: Recording) -> tuple[Array, Array]:
        return recording.t, 100 * recording.joint_array("command.effort") / peak

    figure = _panels(study, motion, signal, study.robot.joints, "torque [% of peak]")
    for axes in figure.axes:
        if max(np.abs(axes.get_ylim())) > NEAR:
            for limit in (-100.0, 100.0):
                axes.axhline(limit, color="#444444", linewidth=0.9, linestyle=(0, (5, 3)))
    return figure


def torques_caption(study: MotionStudy, motion: str) -> str:
    """What the figure shows, and the drive that is nearest to its limit with each law."""
    styles = law_styles(study.agents)
    nearest = []
    for result in study.results_of(motion):
        joint = int(np.argmax(result.torque_use))
        nearest.append(f"{styles[result.agent].label}: {study.robot.joints[joint]}, {result.torque_use[joint]:.0%}")
    limits = ", ".join(
        f"{joint} {peak:.3g}" for joint, peak in zip(study.robot.joints, study.robot.drive.peak_torque, strict=True)
    )
    return (
        "Torque asked of each drive (feedback, rigid feed-forward and what the law adds), motor side, in percent of "
        f"its peak torque [N m]: {limits}. A drive gives no more than 100 %. Largest: {'; '.join(nearest)}."
    )


def path_error_figure(study: MotionStudy, motion: str) -> "Figure":
    """Distance of the TCP from its path, and how far it is behind along it [mm], over time."""

    def signal(recording: Recording) -> tuple[Array, Array]:
        contour = Contour.of(recording)
        return recording.t[contour.rows], 1e3 * np.stack([contour.distance, contour.lag], axis=1)

    return _panels(study, motion, signal, ("across the path", "along the path, > 0 is behind"), "TCP error [mm]")


def path_error_caption(study: MotionStudy, motion: str) -> str:
    """What the figure shows, and the stretch with the largest deviation of each law."""
    styles = law_styles(study.agents)
    worst = []
    for result in study.results_of(motion):
        whole, *stretches = result.path
        where = max(stretches, key=lambda stretch: stretch.max_mm, default=whole)
        worst.append(f"{styles[result.agent].label} {where.max_mm:.3f} mm ({where.label}, from {where.start:.2f} s)")
    return (
        "Across: distance of the tool from the nearest point of its path. Along: how far it is behind its reference in "
        f"the direction of motion. Offset at the start removed. Grey: standstill. Largest distance: {'; '.join(worst)}."
    )


def _panels(study: MotionStudy, motion: str, signal: Signal, titles: Sequence[str], label: str) -> "Figure":
    """One panel below the other, all laws in each."""
    styles = law_styles(study.agents)
    with panels(len(titles), 1, size=(10.0, 1.35 * len(titles) + 0.9), sharex=True) as (figure, grid):
        for law, style in styles.items():
            recording = study.recordings[law, motion]
            t, values = signal(recording)
            for axes, column in zip(grid[:, 0], values.T, strict=True):
                kept = peaks_kept(column)
                axes.plot(t[kept], column[kept], color=style.colour, linewidth=1.0, label=style.label)
        for axes, title in zip(grid[:, 0], titles, strict=True):
            axes.set_title(title, loc="left")
            _shade_rests(axes, recording)
        figure.supylabel(label, fontsize=9.0)
        grid[-1, 0].set_xlabel("time [s]")
        grid[-1, 0].set_xlim(recording.t[0], recording.t[-1])
    return figure


def _shade_rests(axes: "Axes", recording: Recording) -> None:
    for phase in recording.phases_of("standstill"):
        axes.axvspan(phase.start, phase.end, color="#f0f0f0", zorder=0)


def motion_path_figure(study: MotionStudy, motion: str) -> "Figure":
    """Path of the tool with every law beside the reference, dashed."""
    paths, reference = _paths(study, motion), _reference(study, motion)
    look = {"color": "k", "linewidth": 0.7, "linestyle": (0, (5, 3)), "label": "reference"}
    return tool_path_figure(paths, reference, look, scale_of_error(paths, reference))


def motion_path_caption(study: MotionStudy, motion: str) -> str:
    """What the figure shows, with its magnification and the largest deviation of each law."""
    paths, reference = _paths(study, motion), _reference(study, motion)
    factor, sights = scale_of_error(paths, reference), sights_of(reference)
    worst = ", ".join(f"{path.label} {1e3 * path.distance.max():.3f} mm" for path in paths)
    drawn = "drawn to scale" if factor == 1 else f"drawn {factor:g} times as large"
    hidden = max(float(np.abs(path.error @ sights[0].normal).max()) for path in paths)
    looked = f"Seen along its normal, up to {1e3 * hidden:.3f} mm are out of its plane. " if len(sights) == 1 else ""
    return (
        f"{looked}Dashed: reference. Deviations from it are {drawn}; where the tool is late on the right path there is "
        f"none. The offset at the start is removed. Dots: largest deviation in space ({worst})."
    )


def _paths(study: MotionStudy, motion: str) -> list[ToolPath]:
    styles = law_styles(study.agents)
    widths = np.linspace(2.4, 1.0, len(styles)) if len(styles) > 1 else [1.3]  # what lies below shows beside
    contours = [Contour.of(study.recordings[law, motion]) for law in styles]
    return [
        ToolPath(
            label=style.label,
            nearest=contour.nearest,
            error=contour.error,
            look={"color": style.colour, "linestyle": style.line, "linewidth": width},
        )
        for style, contour, width in zip(styles.values(), contours, widths, strict=True)
    ]


def _reference(study: MotionStudy, motion: str) -> Array:
    return study.recordings[study.agents[0], motion].vector("tcp_reference.position")
