"""Beyond the thesis: every family of agents on its 36 circles, and when learning is stable, which it leaves open."""

import numpy as np

from ffgym.agents.bspline import StaticBSN
from ffgym.agents.catalogue import CATALOGUE
from ffgym.agents.common.lessons import thesis_motions
from ffgym.agents.common.trials import SimulatedTrial
from ffgym.agents.stability.check import learning_curves
from ffgym.paths import SPEEDS
from ffgym.report import ReportFigure
from ffgym.report.circles.comparison import percent
from ffgym.report.learning.agents_plot import agents_figure
from ffgym.report.learning.learning_plot import LearningCurves, learning_caption, learning_figure
from ffgym.robot import RigidArm
from scripts.thesis.claims import Check, Claim
from scripts.thesis.comparisons import mean_path_reduction
from scripts.thesis.items import Item, PlainTable
from scripts.thesis.laboratory import Laboratory

BROKEN = 0.7
"""Share of the path error of dynamic LuGre that must be gone for its limit to count as broken; chosen."""
RATES = (0.4, 0.8, 1.6, 2.2)
"""Learning rates of the figure: half and all of that of thesis 5.3.1, and two beyond; chosen."""
ITERATIONS = 15
"""As in thesis 5.3.1."""


def mean_rms(laboratory: Laboratory) -> dict[str, list[float]]:
    """Mean RMS path error [mm] over the 12 circles at each speed, by law."""
    study = laboratory.all_circles
    return {
        each.law.name: [
            float(np.mean([cell.rms_mm for cell in study.only(laws=[each.law.name], speeds=[speed]).cells]))
            for speed in SPEEDS
        ]
        for each in laboratory.contenders
    }


def _table(laboratory: Laboratory) -> list[PlainTable]:
    errors = mean_rms(laboratory)
    rows = tuple(
        (
            each.entry.title,
            each.entry.track,
            f"{each.trials}",
            f"{each.robot_seconds:.0f}",
            *map(_error, errors[each.law.name], errors["none"]),
        )
        for each in laboratory.contenders
    )
    speeds = [f"{speed * 1e3:g} mm/s [µm]" for speed in SPEEDS]
    return [
        PlainTable(
            headings=("law", "what it may know", "trials", "robot time [s]", *speeds),
            rows=rows,
            note="Mean RMS path error over 3 radii and 4 positions, nominal robot; in brackets against none. "
            "Trials are those that a law learned from; one may run several motions. The oracle knows the machine's "
            "true parameters, which are the nominal ones here, and is not ranked. Laws that learn, but not per task, "
            "were trained at p1: the circles at p1, which they learned on, are among those that are scored; p2 to p4 "
            "are held out. Laws per task learned on every circle that is scored, and begin with laws of nominal "
            "parameters." + _left_out(),
        )
    ]


def _left_out() -> str:
    """Which members could not take part, and why; empty if all did."""
    missing = [f"{entry.title} ({entry.package})" for entry in CATALOGUE.values() if not entry.is_available]
    return f" Left out, as a package is not installed: {', '.join(missing)}." if missing else ""


def _error(value: float, without: float) -> str:
    """An error [mm] in micrometres, and how it compares to that without compensation."""
    change = "" if value == without else f" ({percent(1 - value / without)})"
    return f"{value * 1e3:.4g}{change}"


def _overview(laboratory: Laboratory) -> list[ReportFigure]:
    titles = {each.law.name: each.entry.title for each in laboratory.contenders}
    errors = {titles[law]: values for law, values in mean_rms(laboratory).items()}
    return [
        ReportFigure(
            name="agents",
            title="Mean path error of every law",
            thesis="",
            caption="Mean RMS path error over 12 circles at each speed, logarithmic.",
            figure=agents_figure(errors, [speed * 1e3 for speed in SPEEDS]),
        )
    ]


def _limit_is_elastic(laboratory: Laboratory) -> list[Check]:
    return [
        Check(
            where=f"elastic feed-forward, {speed * 1e3:g} mm/s, mean RMS path error / that of dynamic LuGre",
            value=1 - mean_path_reduction(laboratory.all_circles.only(speeds=[speed]), "elastic", "lugre_dynamic"),
            limit=1 - BROKEN,
        )
        for speed in SPEEDS[1:]
    ]


def _prior_helps(laboratory: Laboratory) -> list[Check]:
    study = laboratory.all_circles.only(speeds=[SPEEDS[1]])
    return [
        Check(
            where="mean RMS path error at 40 mm/s, extended network with prior against that of the thesis / none",
            value=1 - mean_path_reduction(study, "bsn_extended_prior"),
            limit=1 - mean_path_reduction(study, "bsn_extended"),
        )
    ]


def _curves(laboratory: Laboratory) -> list[LearningCurves]:
    arm = RigidArm(laboratory.axis)
    trial = SimulatedTrial(arm=arm, n_threads=laboratory.n_threads)
    return learning_curves(StaticBSN.zero(1), trial, thesis_motions(arm)[0], RATES, ITERATIONS)


def _stability(laboratory: Laboratory) -> list[ReportFigure]:
    curves = _curves(laboratory)
    return [
        ReportFigure(
            name="stability",
            title="Learning at several rates, predicted and simulated",
            thesis="",
            caption=learning_caption(curves),
            figure=learning_figure(curves),
        )
    ]


ITEMS = (
    Item(
        name="agents",
        chapter="beyond",
        title="every family of agents on the 36 circles",
        numbers=_table,
        figures=_overview,
        claims=(
            Claim(
                name="agents-elastic",
                statement="At higher speeds the flexible joints may be what bends the path (suspected in 4.5).",
                criterion=f"Elastic feed-forward removes at least {BROKEN:.0%} of what dynamic LuGre leaves, in "
                "simulation, where joints are flexible by construction.",
                checks=_limit_is_elastic,
            ),
            Claim(
                name="agents-prior",
                statement="First weights from a constant friction would help a network at higher speeds (5.5).",
                criterion="Mean RMS path error at 40 mm/s, with prior and training at 10 and 40 mm/s.",
                checks=_prior_helps,
            ),
        ),
    ),
    Item(
        name="stability",
        chapter="beyond",
        title="which learning rates are stable on one axis, which the thesis leaves open (7.2)",
        figures=_stability,
    ),
)
