"""Beyond thesis 6.2: NARX networks with more data and with slip elements, on motions they were not fitted to."""

from collections.abc import Sequence

import numpy as np

from ffgym.diagnosis.identification.narx import Misfit
from ffgym.published import ESTIMATION_RECORDS, FRICTION_RECORDS
from ffgym.report import ReportFigure
from ffgym.report.identification.narx_plot import fits_figure
from ffgym.studies.narx_study import ESTIMATION, VALIDATION, NarxFit, record_name, static_misfit
from scripts.thesis.claims import CLEAR, MOST, ROUGH, Check, Claim
from scripts.thesis.items import Item, PlainTable
from scripts.thesis.laboratory import Laboratory
from scripts.thesis.narx import of_starts, spread

VALIDATING = [each.number for each in FRICTION_RECORDS if each.number not in ESTIMATION_RECORDS]
"""Set V of thesis 6.1.2."""


def _predicts_well(laboratory: Laboratory) -> list[Check]:
    errors = laboratory.narx_published["output"].errors[VALIDATION]
    where = "RMS error on validation data, one step ahead against a tenth of that in free run [N m]"
    return of_starts(errors.prediction.rms, 0.1 * errors.simulation.rms, where)


def _captured(laboratory: Laboratory, names: Sequence[str]) -> list[Check]:
    """Whether the extension, median of its starts, is clearly better than the static curve, and good enough itself."""
    fit, checks = laboratory.narx_extended["slip_set_d"], []
    for name in names:
        missed, floor = float(np.median(fit.rms(name))), float(_static(laboratory, name).rms[0])
        share = float(np.median(fit.errors[name].simulation.share))
        where = f"{name}, RMS error against {1 - CLEAR:.0%} of the static curve's [N m]"
        checks.append(Check(where=where, value=missed, limit=(1 - CLEAR) * floor))
        checks.append(Check(where=f"{name}, RMS error / RMS friction", value=share, limit=ROUGH))
    return checks


def _holds(laboratory: Laboratory) -> list[Check]:
    return _captured(laboratory, [VALIDATION, ESTIMATION, *map(record_name, VALIDATING)])


def _reaches(laboratory: Laboratory) -> list[Check]:
    return _captured(laboratory, list(laboratory.narx_reach))


def _table(laboratory: Laboratory) -> list[PlainTable]:
    rows = [_row(fit) for fit in (laboratory.narx_published | laboratory.narx_extended).values()]
    names = (ESTIMATION, VALIDATION, *map(record_name, VALIDATING))
    floor = {name: _floor(laboratory, name) for name in names}
    records = [floor[record_name(number)] for number in VALIDATING]
    rows.append(
        (
            "static curve",
            *(f"{floor[name]:.1f}" for name in (ESTIMATION, VALIDATION)),
            "",
            *map("{:.1f}".format, (np.median(records), min(records))),
        )
    )
    headings = (
        "network",
        f"{ESTIMATION} [%]",
        f"{VALIDATION} [%]",
        f"{VALIDATION}, one step [%]",
        "set V, median [%]",
        "set V, worst record [%]",
    )
    note = (
        "Fit, in free run but where it says one step: median of random starts (least to most). Networks are "
        "fitted to A = 1, f = 1, or where it says so to set D, records 2, 4, 7, 9, 12 and 14 of Table 6.1; set V is "
        "its other records."
    )
    return [PlainTable(headings=headings, rows=tuple(rows), note=note)]


def _row(fit: NarxFit) -> tuple[str, ...]:
    on_v = np.stack([fit.errors[record_name(number)].simulation.fit for number in VALIDATING])
    columns = (
        fit.errors[ESTIMATION].simulation.fit,
        fit.errors[VALIDATION].simulation.fit,
        fit.errors[VALIDATION].prediction.fit,
        np.median(on_v, axis=0),
        on_v.min(axis=0),
    )
    return (fit.candidate.label, *map(spread, columns))


def _floor(laboratory: Laboratory, name: str) -> float:
    return float(_static(laboratory, name).fit[0])


def _static(laboratory: Laboratory, name: str) -> Misfit:
    """What the static curve leaves of a record."""
    samples = (laboratory.narx_records | laboratory.narx_reach)[name]
    return static_misfit(laboratory.axis.friction, samples)


def _overview(laboratory: Laboratory) -> list[ReportFigure]:
    names = [ESTIMATION, VALIDATION, *map(record_name, VALIDATING), *laboratory.narx_reach]
    fits = {
        fit.candidate.label: np.stack([fit.errors[name].simulation.fit for name in names], axis=1)
        for fit in laboratory.narx_extended.values()
    }
    return [
        ReportFigure(
            name="narx-reach",
            title="Fit of the networks on motions they were not fitted to",
            thesis="",
            caption="Free run; marks are medians of the random starts, bars reach from worst to best. What is below 0 "
            "errs more than the mean torque would, and is not drawn. The four on the right are unlike all records of "
            "Table 6.1; A in rad/s, f in Hz.",
            figure=fits_figure(fits, np.array([_floor(laboratory, name) for name in names]), names),
        )
    ]


ITEMS = (
    Item(
        name="narx",
        chapter="beyond",
        title="an extension of the NARX regressors that holds, which 6.2.3 of the thesis expects to exist",
        figures=_overview,
        numbers=_table,
        claims=(
            Claim(
                name="narx-prediction",
                statement="Predicting one step ahead says little about the free run.",
                criterion="(6.20) errs at least ten times less one step ahead than in free run.",
                checks=_predicts_well,
                share=MOST,
            ),
            Claim(
                name="narx-extension",
                statement="There might be an extension of the regressors that captures the LuGre dynamics (6.2.3).",
                criterion="Speed and slip elements, fitted to set D, on every record not fitted to: median RMS "
                f"error in free run at least {CLEAR:.0%} below that of the static curve, and below {ROUGH:.0%} of the "
                "RMS friction.",
                checks=_holds,
            ),
            Claim(
                name="narx-reach",
                statement="The extension also holds on motions unlike Table 6.1.",
                criterion="The same on a sum of sines, beyond the fitted speeds, slower, and within presliding.",
                checks=_reaches,
            ),
        ),
    ),
)
