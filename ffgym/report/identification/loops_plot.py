"""Friction over motor speed and over time, measured and by LuGre models: thesis Figures 6.2 to 6.7."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ffgym.core.types import Array
from ffgym.diagnosis.identification import FrictionTorque, predicted_friction
from ffgym.report.figure import house_style, legend_above, new_figure
from ffgym.report.identification.stribeck_plot import MEASURED, NEW, OLD
from ffgym.robot.friction import LuGreParameters

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LINES = ((NEW, "-"), (OLD, "--"), ("#009e73", ":"))
"""Colour and line of models, in order."""

_WIDEST = 3
"""Panels side by side."""


def friction_loops_figure(
    torques: Sequence[FrictionTorque],
    joint: int,
    models: Mapping[str, LuGreParameters],
    *,
    known: Mapping[str, Array] | None = None,
) -> "Figure":
    """Friction over motor speed, one panel per record.

    Args:
        torques: friction along the records.
        joint: which joint, 0 is the first.
        models: LuGre parameters of all joints by what they are called in the legend; none shows what was measured.
        known: `inertia_error` and `offset` of an identification, which belong to no model's friction.
    """
    with house_style():
        columns = min(len(torques), _WIDEST)
        rows = -(-len(torques) // columns)
        figure = new_figure(3.2 * columns + 0.4, 2.6 * rows + 0.5)
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes, torque in zip(panels, torques, strict=False):
            valid, speed = torque.valid, torque.signals.motor_dq[:, joint]
            measured = _measured(torque, joint, known)
            axes.plot(speed[valid], measured[valid], color=MEASURED, linewidth=0.7, label="measured")
            for (name, friction), (colour, line) in zip(models.items(), LINES, strict=False):
                model = predicted_friction(friction, torque)[:, joint]
                axes.plot(speed[valid], model[valid], color=colour, linestyle=line, linewidth=1.2, label=name)
            axes.set_title(torque.signals.segment, fontsize=8)
            axes.set_xlabel("motor speed [rad/s]")
        for axes in panels[len(torques) :]:
            axes.set_visible(False)
        for axes in panels[::columns]:
            axes.set_ylabel("friction torque [N m]")
        legend_above(figure, *panels[0].get_legend_handles_labels())
    return figure


def friction_over_time_figure(
    torque: FrictionTorque,
    joint: int,
    models: Mapping[str, LuGreParameters],
    *,
    known: Mapping[str, Array] | None = None,
) -> "Figure":
    """Friction and motor speed of one record over time; arguments as `friction_loops_figure`."""
    t, valid = torque.signals.t, torque.valid
    with house_style():
        figure = new_figure(7.2, 4.0)
        upper, lower = figure.subplots(2, 1, sharex=True)
        upper.plot(t[valid], _measured(torque, joint, known)[valid], color=MEASURED, linewidth=0.8, label="measured")
        for (name, friction), (colour, line) in zip(models.items(), LINES, strict=False):
            model = predicted_friction(friction, torque)[:, joint]
            upper.plot(t[valid], model[valid], color=colour, linestyle=line, linewidth=1.2, label=name)
        lower.plot(t[valid], torque.signals.motor_dq[valid, joint], color="black", linewidth=0.8)
        upper.set_ylabel("friction torque [N m]")
        lower.set_ylabel("motor speed [rad/s]")
        lower.set_xlabel("time [s]")
        legend_above(figure, *upper.get_legend_handles_labels())
        figure.align_ylabels()
    return figure


def _measured(torque: FrictionTorque, joint: int, known: Mapping[str, Array] | None) -> Array:
    """Friction torque without what is known to be none [N m], shape (T,)."""
    measured: Array = torque.friction[:, joint]
    if known is not None:
        measured = measured - known["inertia_error"][joint] * torque.inertia[:, joint] - known["offset"][joint]
    return measured
