"""Predicted beside measured motor torque over time, one panel per joint."""

from typing import TYPE_CHECKING

from ffgym.report.figure import house_style, legend_above, new_figure
from ffgym.studies.torque_prediction import TorquePrediction

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LINES = (("#0072b2", "-"), ("#d55e00", "--"), ("#009e73", ":"))
"""Colour and line of the predictions, in order: all can be seen where they agree, and by the colour-blind."""


def torque_figure(prediction: TorquePrediction) -> "Figure":
    """Measured torque and every prediction of it, motor side; grey where a joint rests or the record ends."""
    joints = prediction.robot.joints
    with house_style():
        figure = new_figure(7.2, 1.6 * len(joints) + 0.6)
        panels = figure.subplots(len(joints), 1, squeeze=False, sharex=True)[:, 0]
        for j, (joint, axes) in enumerate(zip(joints, panels, strict=True)):
            axes.plot(prediction.t, prediction.measured[:, j], color="#999999", linewidth=0.7, label="measured")
            for (name, torque), (colour, line) in zip(prediction.predicted.items(), _LINES, strict=False):
                axes.plot(prediction.t, torque[:, j], color=colour, linestyle=line, linewidth=1.2, label=name)
            axes.fill_between(
                prediction.t,
                0,
                1,
                where=~prediction.scored[:, j],
                transform=axes.get_xaxis_transform(),
                color="#eeeeee",
                linewidth=0,
                label="not scored",
            )
            axes.set_ylabel(f"{joint} [N m]")
        panels[-1].set_xlabel("time [s]")
        legend_above(figure, *panels[0].get_legend_handles_labels())
        figure.align_ylabels()
    return figure
