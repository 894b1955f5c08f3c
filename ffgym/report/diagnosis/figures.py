"""Every picture of a diagnosis, with its caption."""

from collections.abc import Sequence

import numpy as np

from ffgym.diagnosis.regimes import log_rows, motion_map, regime_map
from ffgym.diagnosis.residual import Channel
from ffgym.report.diagnosis.diagnosis_report import DiagnosisReport, Place, worst_motions
from ffgym.report.diagnosis.evidence import (
    loops_figure,
    profiles_figure,
    spectrum_figure,
    time_figure,
    tool_caption,
    tool_figure,
)
from ffgym.report.diagnosis.maps import candidates_figure, levels_figure, map_figure
from ffgym.report.diagnosis.words import by_model, in_joint_units, scale_of
from ffgym.report.figure import ReportFigure

_LOOPS = 3
"""Motions whose friction loops are shown."""

_DEPENDS = (
    "Mean of measured minus predicted in bins of equally many rows. Bands: two standard errors, with one second of "
    "the log as one observation."
)
_REPEATS = "Amplitude (RMS times the root of two) of the sine of the motor angle that is nearest to the residual."
_OVER_SPEED = "Motor torque less what the nominal model gives apart from its friction (LuGre without bristle damping)."
_CELLS = (
    "RMS of measured minus predicted over the noise floor: 1 is what noise alone leaves. Grey cells: the log has "
    "too few such rows, or the model claims to know nothing of them."
)


def map_figures(report: DiagnosisReport) -> list[ReportFigure]:
    """Where the model is wrong: by regime, for torques and other channels that stand out; by motion, for all."""
    if report.before is None:
        return []
    channels = report.before.channels
    standing_out = {place.channel for place in report.places}
    shown = [channel for channel in channels if channel == "torque" or (channel in standing_out and channel != "tool")]
    return [*(_regimes(report, channel) for channel in shown), _motions(report, channels)]


def place_figures(report: DiagnosisReport, place: Place) -> list[ReportFigure]:
    """What the residual of one joint looks like."""
    assert report.before is not None
    models = by_model(report.before, report.after)
    channel, j = place.channel, place.index
    worst = worst_motions(motion_map(report.before, channel), j, _LOOPS)
    rows = {name: log_rows(residual, channel) for name, residual in models.items()}
    name = report.before.motions[worst[0]].motion
    figures = [
        ReportFigure(
            f"time-{channel}-{j + 1}",
            f"{place.component}, {channel}: the motion in which it stands out most",
            f"Motion {name}. What is measured and predicted has gone through the same low-pass without delay.",
            time_figure(models, channel, j, j, worst[0]),
        ),
    ]
    unit, scale = report.before.robot.kinematics.units[j], scale_of(report.before.robot, channel, j)
    if (depends := profiles_figure(rows, channel, j, j, unit, scale)) is not None:
        title = f"{place.component}, {channel}: what the residual depends on"
        figures.append(ReportFigure(f"depends-{channel}-{j + 1}", title, _DEPENDS, depends))
    figures += _spectrum(report, place)
    if channel == "torque":
        loops = loops_figure(models, j, worst)
        figures.append(ReportFigure(f"loops-{j + 1}", f"{place.component}: friction over speed", _OVER_SPEED, loops))
    return figures


def _spectrum(report: DiagnosisReport, place: Place) -> list[ReportFigure]:
    """How the residual of one joint repeats; nothing where its motor turns too little to tell."""
    assert report.before is not None
    marked = [
        pattern.frequency
        for pattern in report.diagnosis.patterns
        if pattern.kind == "periodic" and pattern.component == place.component and pattern.frequency is not None
    ]
    models = by_model(report.before, report.after)
    figure = spectrum_figure(models, place.channel, place.index, place.component, marked)
    title = f"{place.component}, {place.channel}: what repeats with the motor"
    name = f"repeats-{place.channel}-{place.index + 1}"
    return [] if figure is None else [ReportFigure(name, title, _REPEATS, figure)]


def tool_figures(report: DiagnosisReport) -> list[ReportFigure]:
    """Path of the tool in the motion in which it stands out most; none without a tracker."""
    if report.before is None or "tool" not in report.before.channels:
        return []
    motions = motion_map(report.before, "tool")
    if np.isnan(motions.ratio).all():
        return []
    worst = int(np.nanargmax(np.nanmax(motions.ratio, axis=0, initial=0.0)))
    models = by_model(report.before, report.after)
    return [ReportFigure("tool", "Path of the tool", tool_caption(models, worst), tool_figure(models, worst))]


def candidate_figures(report: DiagnosisReport) -> list[ReportFigure]:
    """Causes beside their rivals; none without causes."""
    if not report.diagnosis.causes:
        return []
    caption = (
        "Share of the residual's energy above the noise floor that each effect removes on rows that were not used to "
        "fit it. Only effects are tried whose score on such rows is above what the best of all reaches by chance in "
        "one of a thousand logs of a perfect model: "
        f"{report.diagnosis.threshold:.2g} times the energy of noise in one component."
    )
    return [ReportFigure("candidates", "Causes and rivals", caption, candidates_figure(report.diagnosis))]


def level_figures(report: DiagnosisReport) -> list[ReportFigure]:
    """What is gained; none if nothing was compared, or nothing changed."""
    levels = in_joint_units(report.diagnosis, None if report.before is None else report.before.robot).levels
    if not levels or not report.diagnosis.causes:
        return []
    caption = (
        "RMS of the residual over all rows that are judged, from the nominal to the extended model, each motion by one "
        "that was fitted without it."
    )
    return [ReportFigure("levels", "Residuals before and after", caption, levels_figure(levels))]


def _regimes(report: DiagnosisReport, channel: Channel) -> ReportFigure:
    assert report.before is not None
    models = by_model(report.before, report.after)
    panels = [[(name, regime_map(residual, channel))] for name, residual in models.items()]
    over = motion_map(report.before, channel)
    known = [(c, ratio) for c, ratio in zip(over.components, over.overall, strict=True) if np.isfinite(ratio)]
    whole = ", ".join(f"{c} {ratio:.1f}" for c, ratio in known)
    caption = f"{_CELLS} The whole log, nominal model: {whole}."
    title = f"Residual over noise floor by what the joint was doing, {channel}"
    return ReportFigure(f"regimes-{channel}", title, caption, map_figure(panels))


def _motions(report: DiagnosisReport, channels: Sequence[Channel]) -> ReportFigure:
    assert report.before is not None
    models = by_model(report.before, report.after)
    panels = [[(f"{c}, {name}", motion_map(one, c)) for name, one in models.items()] for c in channels]
    return ReportFigure("motions", "Residual over noise floor by motion", _CELLS, map_figure(panels))
