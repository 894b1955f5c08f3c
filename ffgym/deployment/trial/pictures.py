"""Pictures of a trial: the errors of all runs in their order, and the gains with their intervals."""

from typing import Any

import numpy as np

from ffgym.deployment.trial.gains import OVERALL
from ffgym.deployment.trial.reading import RunResult, TrialResult
from ffgym.report.figure import ReportFigure, panels

_OFF, _ON, _PALE = "#5C5C5C", "#0072B2", "#bbbbbb"
"""Colours of runs without and with the correction, and of those that do not count."""
_CLAIMS = {"gain": "#009E73", "worse": "#D55E00", "none": "#8a8a8a", "too few": "#8a8a8a"}
"""Colours of gains by what may be claimed."""
_WORDS = {"gain": "gain", "worse": "worse", "none": "no gain shown", "too few": "too few pairs"}
_FAR = 2.0
"""Ratio of the largest and the smallest error of a program from which on its axis begins at zero; below it, what
differs would be flattened."""


def draw_runs(result: TrialResult) -> ReportFigure:
    """Draw the error of every run in the order of the plan, program by program; lines join the runs of a pair."""
    programs = result.plan.programs
    with panels(len(programs), 1, size=(10.0, 2.1 * len(programs) + 0.7), sharex=True) as (figure, grid):
        for program, axes in zip(programs, grid[:, 0], strict=True):
            own = [one for one in result.runs if one.run.program == program.name and np.isfinite(one.error)]
            _draw_program(axes, own)
            axes.set_title(program.name, loc="left")
            axes.set_ylabel(f"error [{result.unit.name}]")
            axes.set_xlim(0.2, len(result.runs) + 0.8)
        grid[-1, 0].set_xlabel("run, in the order of the plan")
    return ReportFigure(
        name="runs",
        title="Errors of all runs in their order",
        caption=f"{result.unit.words}, without the noise of the sensor. Lines join the two runs of a pair, whose order "
        "was drawn by chance. Pale: runs to warm up. Crosses do not count.",
        figure=figure,
    )


def _draw_program(axes: Any, own: list[RunResult]) -> None:
    """Draw the runs of one program."""
    pairs = dict.fromkeys(one.run.pair for one in own if one.counts)
    for pair in pairs:
        both = [one for one in own if one.run.pair == pair]
        axes.plot([one.run.number for one in both], [one.error for one in both], color=_PALE, linewidth=1.0, zorder=1)
    groups = [
        ("without the correction", "o", _OFF, [one for one in own if one.counts and not one.run.corrected]),
        ("with it", "s", _ON, [one for one in own if one.counts and one.run.corrected]),
        ("warm-up", "^", _PALE, [one for one in own if one.run.is_warm_up]),
        ("does not count", "x", _CLAIMS["worse"], [one for one in own if not one.counts and not one.run.is_warm_up]),
    ]
    for label, marker, colour, runs in groups:
        if runs:
            places = [one.run.number for one in runs]
            axes.scatter(places, [one.error for one in runs], s=26, marker=marker, color=colour, label=label, zorder=2)
    errors = [one.error for one in own]
    axes.margins(y=0.15)
    if errors and max(errors) > _FAR * min(errors):
        axes.set_ylim(bottom=0.0)


def draw_gains(result: TrialResult) -> ReportFigure:
    """Draw the gain of each program, and over all, with its 95 % interval."""
    gains = [gain for gain in result.gains if np.isfinite(gain.gain)]
    with panels(size=(10.0, 1.1 + 0.4 * len(gains))) as (figure, grid):
        axes = grid[0, 0]
        for row, gain in enumerate(gains):
            colour, weight = _CLAIMS[gain.claim], 2.6 if gain.name == OVERALL else 1.6
            if np.isfinite(gain.low):
                axes.plot([100 * gain.low, 100 * gain.high], [row, row], color=colour, linewidth=weight)
            axes.scatter(100 * gain.gain, row, s=40, color=colour, label=_WORDS[gain.claim], zorder=2)
        axes.axvline(0.0, color="#444444", linewidth=1.0)
        axes.set_yticks(range(len(gains)), [gain.name for gain in gains])
        axes.set_ylim(len(gains) - 0.5, -0.5)
        axes.set_xlabel("gain [%], > 0 is less error")
    return ReportFigure(
        name="gains",
        title="Gain with its 95 % interval",
        caption="Share of the error that the correction takes away: geometric mean over pairs, with its 95 % interval. "
        "Coloured where a claim may be made of all places together (Holm).",
        figure=figure,
    )
