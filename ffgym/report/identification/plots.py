"""Friction and motor torque, measured and by models, over speed and over time: thesis Figures 6.1 to 6.7."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification import (
    FrictionIdentification,
    FrictionTorque,
    JointFriction,
    ModelError,
    predict_friction,
)
from ffgym.report.figure import panels
from ffgym.robot.friction import LuGreParameters
from ffgym.studies.torque_prediction import TorquePrediction

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


MEASURED, NEW, OLD = "#999999", "#0072b2", "#d55e00"
"""Colours of measurements, and of new and old parameters; safe for colour-blind readers, and different in line."""

LINES = ((NEW, "-"), (OLD, "--"), ("#009e73", ":"))
"""Colour and line of models, in order."""

_WIDEST = 3
"""Largest number of panels side by side."""


@contextmanager
def _small_panels(n: int, width: float, height: float) -> Iterator[tuple["Figure", Any]]:
    """Draw on n panels of that size [inch] in rows of _WIDEST."""
    columns = min(max(n, 1), _WIDEST)
    rows = -(-max(n, 1) // columns)
    with panels(rows, columns, size=(width * columns + 0.4, height * rows + 0.5)) as (figure, grid):
        yield figure, grid
        for axes in grid.flat[n:]:
            axes.set_visible(False)


def stribeck_figure(identification: FrictionIdentification) -> "Figure":
    """Draw one panel per joint with constant speeds: both directions, the fitted curve, and that of old parameters.

    The even part, which the LuGre model lacks, is subtracted from the measurements.
    """
    joints = [j for j, joint in enumerate(identification.joints) if joint.stribeck is not None]
    with _small_panels(len(joints), 3.6, 2.7) as (figure, grid):
        for axes, j in zip(grid.flat, joints, strict=False):
            _draw(axes, identification, identification.joints[j], j)
    return figure


def _draw(axes: "Axes", identification: FrictionIdentification, joint: JointFriction, j: int) -> None:
    assert joint.stribeck is not None
    fit = joint.stribeck
    speed, friction = fit.data.levels()
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


def friction_loops_figure(
    torques: Sequence[FrictionTorque],
    joint: int,
    models: Mapping[str, LuGreParameters],
    *,
    known: ModelError | None = None,
) -> "Figure":
    """Draw friction over motor speed, one panel per record.

    Args:
        torques: friction along the records.
        joint: number of the joint, from 0.
        models: LuGre parameters of all joints by their name in the legend; none draws the measurements alone.
        known: errors of the model of the arm, which belong to no model's friction.
    """
    with _small_panels(len(torques), 3.2, 2.6) as (figure, grid):
        for axes, torque in zip(grid.flat, torques, strict=False):
            _draw_models(axes, torque, joint, models, known, torque.signals.motor_dq[:, joint], 0.7)
            axes.set_title(torque.signals.segment, fontsize=8)
            axes.set_xlabel("motor speed [rad/s]")
        for axes in grid[:, 0]:
            axes.set_ylabel("friction torque [N m]")
    return figure


def friction_over_time_figure(
    torque: FrictionTorque,
    joint: int,
    models: Mapping[str, LuGreParameters],
    *,
    known: ModelError | None = None,
) -> "Figure":
    """Draw friction and motor speed of one record over time; arguments as `friction_loops_figure`."""
    t, valid = torque.signals.t, torque.valid
    with panels(2, 1, size=(7.2, 4.0), sharex=True) as (figure, grid):
        upper, lower = grid[:, 0]
        _draw_models(upper, torque, joint, models, known, t, 0.8)
        lower.plot(t[valid], torque.signals.motor_dq[valid, joint], color="black", linewidth=0.8)
        upper.set_ylabel("friction torque [N m]")
        lower.set_ylabel("motor speed [rad/s]")
        lower.set_xlabel("time [s]")
        figure.align_ylabels()
    return figure


def _draw_models(
    axes: "Axes",
    torque: FrictionTorque,
    joint: int,
    models: Mapping[str, LuGreParameters],
    known: ModelError | None,
    over: Array,
    width: float,
) -> None:
    """Draw friction of a record, measured less its `known` other parts, and by each model, over speed or time."""
    valid, measured = torque.valid, torque.friction[:, joint]
    if known is not None:
        measured = measured - known.torque(torque)[:, joint]
    axes.plot(over[valid], measured[valid], color=MEASURED, linewidth=width, label="measured")
    for (name, friction), (colour, line) in zip(models.items(), LINES, strict=False):
        model = predict_friction(friction, torque)[:, joint]
        axes.plot(over[valid], model[valid], color=colour, linestyle=line, linewidth=1.2, label=name)


def torque_figure(prediction: TorquePrediction) -> "Figure":
    """Draw measured torque and every prediction of it, motor side; grey where a joint rests or the record ends."""
    joints = prediction.robot.joints
    with panels(len(joints), 1, size=(7.2, 1.6 * len(joints) + 0.6), sharex=True) as (figure, grid):
        for j, (joint, axes) in enumerate(zip(joints, grid[:, 0], strict=True)):
            axes.plot(prediction.t, prediction.measured[:, j], color="#999999", linewidth=0.7, label="measured")
            for (name, torque), (colour, line) in zip(prediction.predicted.items(), LINES, strict=False):
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
