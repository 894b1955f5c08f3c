"""What the feedback does along a motion: over speed for every joint, and in its parts: thesis Figures 5.2 and 5.5."""

from typing import TYPE_CHECKING

import numpy as np

from ffgym.recordings import Recording
from ffgym.report.figure import house_style, legend_above, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLUMNS = 3
_TOTAL, _WITHOUT_INTEGRAL = "#D55E00", "#0072B2"


def feedback_over_speed_figure(recording: Recording) -> "Figure":
    """Feedback torque over motor speed, one panel per joint, standstill left out."""
    joints = recording.header.joints
    moving = ~recording.mask(kind="standstill")
    speed = np.where(moving[:, None], recording.joint_array("reference.velocity"), np.nan)
    feedback = recording.joint_array("feedback.effort")
    n_rows = -(-len(joints) // _COLUMNS)
    with house_style():
        figure = new_figure(10.0, 2.3 * n_rows)
        grid = figure.subplots(n_rows, _COLUMNS, squeeze=False)
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
    with house_style():
        figure = new_figure(10.0, 3.0)
        axes = figure.subplots()
        axes.plot(recording.t, feedback, color=_TOTAL, label="feedback $u_c$")
        axes.plot(recording.t, proportional, color=_WITHOUT_INTEGRAL, label="without its integral part, $u_p$")
        axes.set(xlabel="time [s]", ylabel=f"torque of {recording.header.joints[joint]} [N m]")
        legend_above(figure, *axes.get_legend_handles_labels())
    return figure
