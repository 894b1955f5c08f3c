"""One motion over time: measured, by both models, and what is left."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ffgym.diagnosis.residual import Channel, Residual
from ffgym.report.diagnosis.joint_units import fine_scale_of, scale_of
from ffgym.report.diagnosis.models import LOOKS, NOMINAL, counting, motor_speed
from ffgym.report.figure import house_style, legend_above, new_figure

if TYPE_CHECKING:
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
    with house_style():
        figure = new_figure(8.6, 5.4)
        upper, middle, lower = figure.subplots(3, 1, sharex=True, height_ratios=(3, 2, 1.2))
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
        entries = [axes.get_legend_handles_labels() for axes in (upper, middle)]
        legend_above(figure, entries[0][0] + entries[1][0], entries[0][1] + entries[1][1])
        figure.align_ylabels()
    return figure
