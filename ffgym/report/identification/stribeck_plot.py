"""Friction over constant speed, measured and fitted: thesis Figure 6.1."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ffgym.diagnosis.identification import FrictionIdentification, JointFriction
from ffgym.report.figure import house_style, legend_above, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MEASURED, NEW, OLD = "#999999", "#0072b2", "#d55e00"
"""Colours of what was measured, and of new and old parameters; also told apart by the colour-blind, and by line."""


def stribeck_figure(identification: FrictionIdentification) -> "Figure":
    """One panel per joint with constant speeds: both directions, the fitted curve, and that of the old parameters.

    The even part, which the LuGre model has not, is taken from what was measured.
    """
    joints = [j for j, joint in enumerate(identification.joints) if joint.stribeck is not None]
    with house_style():
        columns = min(max(len(joints), 1), 3)
        rows = -(-max(len(joints), 1) // columns)
        figure = new_figure(3.6 * columns + 0.4, 2.7 * rows + 0.5)
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes, j in zip(panels, joints, strict=False):
            _draw(axes, identification, identification.joints[j], j)
        for axes in panels[len(joints) :]:
            axes.set_visible(False)
        if joints:
            legend_above(figure, *panels[0].get_legend_handles_labels())
    return figure


def _draw(axes: "Axes", identification: FrictionIdentification, joint: JointFriction, j: int) -> None:
    assert joint.stribeck is not None
    fit = joint.stribeck
    speed, friction, _ = fit.data.levels()
    odd = np.sign(speed) * (friction - fit.offset - fit.asymmetry * np.abs(speed))
    style: dict[str, Any] = {"linestyle": "none", "markerfacecolor": "none", "color": MEASURED, "markersize": 5}
    for sign, marker, label in ((1, "o", "measured, forwards"), (-1, "s", "measured, back")):
        rows = np.sign(speed) == sign
        axes.plot(np.abs(speed[rows]), odd[rows], marker=marker, label=label, **style)
    fine = np.geomspace(0.5 * np.abs(speed).min(), np.abs(speed).max(), 300)
    axes.plot(fine, fit.curve(fine), color=NEW, label="identified")
    before = identification.prior.friction
    old = np.array([before.steady_torque(np.full(before.n_joints, v))[j] for v in fine])
    axes.plot(fine, old, color=OLD, linestyle="--", label="before")
    axes.set_xscale("log")
    axes.set_title(joint.joint)
    axes.set_xlabel("motor speed [rad/s]")
    axes.set_ylabel("friction torque [N m]")
