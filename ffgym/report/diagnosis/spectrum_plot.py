"""How a residual repeats with the turn of a motor: its periodogram over the motor angle."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.patterns import cycles_per_turn
from ffgym.diagnosis.patterns.periodic import Amplitude
from ffgym.diagnosis.regimes import LogRows, log_rows
from ffgym.diagnosis.residual import Channel, Residual, components
from ffgym.report.diagnosis.joint_units import fine_scale_of
from ffgym.report.diagnosis.models import LOOKS
from ffgym.report.figure import house_style, legend_above, new_figure
from ffgym.report.thinning import peaks_kept

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FORMS: Mapping[Amplitude, str] = MappingProxyType(
    {"constant": "amplitude that is always the same", "torque": "amplitude that goes with the torque"}
)
"""Forms of what repeats that are shown, and what they are called."""


def spectrum_figure(
    models: Mapping[str, Residual], channel: Channel, component: int, joint: str, marked: Sequence[float]
) -> "Figure | None":
    """Amplitude over cycles per turn, one panel for each form, one line for each model.

    Args:
        models: residuals by model.
        channel: which channel of them.
        component: which component of the channel.
        joint: whose motor turns.
        marked: cycles per turn of what was found.

    Returns:
        None where the motor turns too little to tell.
    """
    found = {form: _amplitudes(models, channel, component, joint, form) for form in FORMS}
    if not all(found.values()):
        return None
    unit = fine_scale_of(next(iter(models.values())).robot, channel, component)[1]
    with house_style():
        figure = new_figure(9.4, 3.0)
        panels = figure.subplots(1, len(FORMS), sharey=True)
        for axes, (form, lines) in zip(panels, found.items(), strict=True):
            for name, (frequency, amplitude) in lines.items():
                shown = peaks_kept(amplitude)
                axes.plot(frequency[shown], amplitude[shown], label=name, color=LOOKS[name]["color"], linewidth=0.9)
            axes.set_title(FORMS[form], fontsize=9)
            axes.set_xscale("log")
            axes.set_xlabel("cycles per turn of the motor")
        panels[0].set_ylim(bottom=0.0)
        panels[0].set_ylabel(f"amplitude [{unit}]")
        for axes in panels:
            _mark(axes, marked)
        legend_above(figure, *panels[0].get_legend_handles_labels())
    return figure


def _mark(axes: "Axes", marked: Sequence[float]) -> None:
    for frequency in marked:
        axes.axvline(frequency, color="#5a6472", linewidth=0.8, linestyle=":")
        axes.text(frequency, axes.get_ylim()[1], f" {frequency:.2f}", fontsize=8, va="top")


def _amplitudes(
    models: Mapping[str, Residual], channel: Channel, component: int, joint: str, form: Amplitude
) -> dict[str, tuple[Array, Array]]:
    """Cycles per turn and amplitudes, in the unit in which people read them, by model; nothing if there are none."""
    found = {}
    for name, residual in models.items():
        of = components(channel, residual.robot)[component]
        spectrum = cycles_per_turn(residual, channel, of, joint, amplitude=form)
        if spectrum is not None:
            size = _deviation(log_rows(residual, channel), component)
            size *= fine_scale_of(residual.robot, channel, component)[0]
            found[name] = (spectrum.frequency, size * np.sqrt(2 * spectrum.share))
    return found


def spectrum_caption() -> str:
    """What is drawn."""
    return "Amplitude (RMS times the root of two) of the sine of the motor angle that is nearest to the residual."


def _deviation(rows: LogRows, component: int) -> float:
    """RMS of a residual about its mean over each motion, in the unit of the channel."""
    values, motion = rows.residual[:, component], rows.motion
    known = np.isfinite(values)
    count = np.bincount(motion[known], minlength=motion.max() + 1)
    mean = np.bincount(motion[known], weights=values[known], minlength=len(count)) / np.maximum(count, 1)
    return rms(values[known] - mean[motion[known]])
