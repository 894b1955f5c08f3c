"""Predicted beside measured motor torque over time, one panel per joint."""

from typing import TYPE_CHECKING

from ffgym.report.figure import panels
from ffgym.studies.torque_prediction import TorquePrediction

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LINES = (("#0072b2", "-"), ("#d55e00", "--"), ("#009e73", ":"))
"""Colour and line of the predictions, in order: all can be seen where they agree, and by the colour-blind."""


def torque_figure(prediction: TorquePrediction) -> "Figure":
    """Measured torque and every prediction of it, motor side; grey where a joint rests or the record ends."""
    joints = prediction.robot.joints
    with panels(len(joints), 1, size=(7.2, 1.6 * len(joints) + 0.6), sharex=True) as (figure, grid):
        for j, (joint, axes) in enumerate(zip(joints, grid[:, 0], strict=True)):
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
        axes.set_xlabel("time [s]")
        figure.align_ylabels()
    return figure
