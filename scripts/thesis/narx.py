"""Thesis 6.2, friction as a NARX network: Figures 6.10 and 6.11."""

from collections.abc import Callable, Sequence

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.narx import Misfit, Samples
from ffgym.report import ReportFigure
from ffgym.report.identification.narx_plot import narx_figure
from ffgym.studies.narx_study import ESTIMATION, VALIDATION, NarxFit
from scripts.thesis.claims import CLEAR, MAJORITY, MOST, Check, Claim
from scripts.thesis.items import Item
from scripts.thesis.laboratory import Laboratory

GOOD_FIT = 90.0
"""Fit [%] from which a curve is called a good fit; chosen: the difference is then a tenth of the friction's swing."""

Fit = Callable[[Laboratory], NarxFit]


def _speeds(laboratory: Laboratory) -> NarxFit:
    return laboratory.narx_published["speeds"]


def _output(laboratory: Laboratory) -> NarxFit:
    return laboratory.narx_published["output"]


def of_starts(values: Array, limits: Array | float, where: str) -> list[Check]:
    """One comparison per random start."""
    bounds = np.broadcast_to(limits, np.shape(values))
    return [
        Check(where=f"start {i + 1}, {where}", value=float(value), limit=float(limit))
        for i, (value, limit) in enumerate(zip(values, bounds, strict=True))
    ]


def _fits_estimation(laboratory: Laboratory) -> list[Check]:
    fit = _speeds(laboratory).errors[ESTIMATION].simulation.fit
    return of_starts(100 - fit, 100 - GOOD_FIT, "what is missing to a fit of 100 % on estimation data [%]")


def _worse_on_validation(laboratory: Laboratory) -> list[Check]:
    fit = _speeds(laboratory)
    where = "RMS error in free run, estimation against validation [N m]"
    return of_starts(fit.rms(ESTIMATION), (1 - CLEAR) * fit.rms(VALIDATION), where)


def branch_errors(fit: NarxFit, samples: Samples) -> tuple[Array, Array]:
    """RMS error in free run [N m] of each start while the speed rises, and while it falls, shape (S,) each."""
    copies = np.repeat(samples.motor_dq, fit.model.n_joints, axis=1)
    simulated, rises = fit.model.simulated(copies), np.gradient(samples.motor_dq[:, 0]) > 0

    def rms(rows: BoolArray) -> Array:
        return Misfit.of(simulated[rows], samples.torque[rows]).rms

    return rms(rises), rms(~rises)


def _fails_rising(laboratory: Laboratory) -> list[Check]:
    rising, falling = branch_errors(_speeds(laboratory), laboratory.narx_records[VALIDATION])
    return of_starts(falling, rising, "RMS error in validation, falling against rising speed [N m]")


def _worse_estimation(laboratory: Laboratory) -> list[Check]:
    ours, theirs = _output(laboratory).rms(ESTIMATION), _speeds(laboratory).rms(ESTIMATION)
    return of_starts(np.full(len(ours), np.median(theirs)), ours, "RMS error, median of (6.19) against (6.20) [N m]")


def _better_validation(laboratory: Laboratory) -> list[Check]:
    ours, theirs = _output(laboratory).rms(VALIDATION), _speeds(laboratory).rms(VALIDATION)
    return of_starts(ours, float(np.median(theirs)), "RMS error, (6.20) against median of (6.19) [N m]")


def _not_its_hysteresis(laboratory: Laboratory) -> list[Check]:
    fit = _output(laboratory).errors[VALIDATION].simulation.fit
    return of_starts(fit, GOOD_FIT, "fit in free run on validation data [%]")


def _models(name: str, fit: Fit) -> Callable[[Laboratory], Sequence[ReportFigure]]:
    def figures(laboratory: Laboratory) -> Sequence[ReportFigure]:
        found = fit(laboratory)
        return [
            ReportFigure(
                name=name,
                title=f"NARX network of {found.candidate.label} and the LuGre model",
                thesis="",
                caption=_caption(found),
                figure=narx_figure(found, laboratory.narx_records),
            )
        ]

    return figures


def _caption(fit: NarxFit) -> str:
    parts = []
    for name, what in ((ESTIMATION, "estimation"), (VALIDATION, "validation")):
        errors = fit.errors[name]
        parts.append(f"{what}: free run {spread(errors.simulation.fit)} %, one step {spread(errors.prediction.fit)} %")
    starts = fit.model.n_joints
    return f"Fit, median of {starts} random starts (least to most); {'; '.join(parts)}. Drawn is the free run."


def spread(values: Array) -> str:
    """Median, least and most."""
    return f"{np.median(values):.1f} ({values.min():.1f} to {values.max():.1f})"


ITEMS = (
    Item(
        name="figure-6.10",
        chapter="chapter-6",
        title="NARX network of v(k) and v(k-1) on data of a LuGre model",
        figures=_models("figure-6.10", _speeds),
        claims=(
            Claim(
                name="6.10-estimation",
                statement="The first network is a good fit to the estimation data.",
                criterion=f"Fit of at least {GOOD_FIT:g} %, over random starts.",
                checks=_fits_estimation,
                share=MOST,
            ),
            Claim(
                name="6.10-validation",
                statement="It does not perform well on the validation data.",
                criterion=f"RMS error at least {CLEAR:.0%} lower on estimation data, over random starts.",
                checks=_worse_on_validation,
                share=MOST,
            ),
            Claim(
                name="6.10-rising",
                statement="In validation it fails where the acceleration is positive.",
                criterion="RMS error larger while the speed rises than while it falls, over random starts.",
                checks=_fails_rising,
                share=MOST,
            ),
        ),
    ),
    Item(
        name="figure-6.11",
        chapter="chapter-6",
        title="NARX network of v(k) and y(k-1) on data of a LuGre model",
        figures=_models("figure-6.11", _output),
        claims=(
            Claim(
                name="6.11-estimation",
                statement="The second network fits the estimation data worse than the first.",
                criterion="RMS error in free run above the median of the first, over random starts.",
                checks=_worse_estimation,
                share=MAJORITY,
            ),
            Claim(
                name="6.11-validation",
                statement="It fits the validation data better than the first.",
                criterion="RMS error in free run below the median of the first, over random starts.",
                checks=_better_validation,
                share=MAJORITY,
            ),
            Claim(
                name="6.11-hysteresis",
                statement="Still its hysteresis in validation is not that of the LuGre model.",
                criterion=f"Fit below {GOOD_FIT:g} %, over random starts.",
                checks=_not_its_hysteresis,
                share=MOST,
            ),
        ),
    ),
)
