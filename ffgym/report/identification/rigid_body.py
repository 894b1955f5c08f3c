"""An identified rigid body as text, numbers and a page: combinations, parameters, and torque that was not fitted."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification.rigid_body import RigidBodyFit, TorqueErrors
from ffgym.recordings import Recording
from ffgym.report.figure import ReportFigure
from ffgym.report.identification.plots import torque_figure
from ffgym.report.page import Details, Note, Page, Section, words_of
from ffgym.report.table import Column, Kind, Table, underline, wrap_text
from ffgym.studies.torque_prediction import TorquePrediction

SURE = 0.9
"""Share of the data above which they alone determine a number."""

_MOST = 4
"""Largest number of recordings that are shown."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RigidBodyReport:
    """A rigid-body fit with its validation."""

    fit: RigidBodyFit
    held_out: Sequence[Recording]
    """Recordings that were not used."""
    doubts_of_logs: Sequence[str] = ()
    """Doubts about logs that were used all the same."""

    @property
    def doubts(self) -> tuple[str, ...]:
        """Doubts about logs and fit."""
        return (*self.doubts_of_logs, *self.fit.doubts)

    @property
    def validation(self) -> Mapping[str, TorqueErrors]:
        """Errors on the recordings that were used, and on each that was not."""
        errors = {"logs": self.fit.errors}
        return errors | {record.header.segment: self.fit.validate([record]) for record in self.held_out}


@dataclass(frozen=True, kw_only=True)
class ParameterRow:
    """A parameter, or a combination of parameters."""

    name: str
    unit: str
    before: float
    now: float
    low: float
    high: float
    share: float
    """Share of the data in the value."""
    verdict: str


def parameter_rows(fit: RigidBodyFit) -> list[ParameterRow]:
    """List rotors, friction, offsets, springs: all parameters but the bodies'."""
    places = [i for i, label in enumerate(fit.labels) if label.split(".")[0] not in (*fit.robot.links, "tool")]
    numbers = {"before": fit.described, "now": fit.estimate, "low": fit.intervals.low, "high": fit.intervals.high}
    numbers = {key: column[places] for key, column in (numbers | {"share": fit.shares}).items()}
    return _rows(fit, [fit.labels[i] for i in places], places, numbers)


def base_rows(fit: RigidBodyFit) -> list[ParameterRow]:
    """List the base parameters, which torque determines."""
    base, ends = fit.base, fit.base_intervals
    numbers = {
        "before": base.values(fit.described),
        "now": base.values(fit.estimate),
        "low": ends.low,
        "high": ends.high,
    }
    return _rows(fit, [base.text(i) for i in range(len(base.own))], base.own, numbers | {"share": fit.base_shares})


def _rows(
    fit: RigidBodyFit, names: Sequence[str], places: Iterable[int], numbers: Mapping[str, Array]
) -> list[ParameterRow]:
    """Make a row for each name, with numbers by field; unit and verdict are of the parameter at the same place."""
    rows = []
    for k, (name, place) in enumerate(zip(names, places, strict=True)):
        own = {key: float(column[k]) for key, column in numbers.items()}
        by = "data" if own["share"] >= SURE else "description" if own["share"] < 1 - SURE else "both"
        rows.append(
            ParameterRow(name=name, unit=fit.units[place], verdict=by if fit.fitted[place] else "not excited", **own)
        )
    return rows


def format_rigid_body(report: RigidBodyReport) -> str:
    """Format parameters with their sources (data or description), and the torque errors."""
    fit = report.fit
    title = f"Rigid body of {fit.robot.title} from {len(fit.segments)} logs"
    summary = f"{_summary(fit, f' (condition number {fit.condition:.3g})')}{fit.trade_off.chosen:g}"
    tried = len(fit.trade_off.spreads) > 1
    summary += ", the nearest that predicts held-out parts of the logs as well as any." if tried else "."
    parts = [underline(title), wrap_text(summary), ""]
    for table in (_row_table(fit, "parameter, motor side", parameter_rows(fit)), _bodies(fit)):
        if table.n_rows:
            parts += [table.text(), ""]
    if fit.not_excited:
        parts += [wrap_text(f"note: not excited, and so as described: {', '.join(fit.not_excited)}"), ""]
    parts += [wrap_text(f"note: {doubt}") for doubt in report.doubts]
    legend = words_of("rigid_body")["legend"].format(cutoff=fit.filtering.parallel.cutoff)
    return "\n".join([*parts, f"{wrap_text(legend)}\n\n{_errors(report).text()}"])


def render_rigid_body_page(report: RigidBodyReport, used: Recording, info: Mapping[str, Any]) -> str:
    """Render the page as HTML; shows `used`, a recording that was fitted, if no other was held out.

    `info` is its provenance by name. FFGymError if matplotlib or jinja2 is missing.
    """
    fit = report.fit
    excited = f"Not excited, and so as described: {', '.join(fit.not_excited)}." if fit.not_excited else ""
    left = words_of("rigid_body")["left"].format(cutoff=fit.filtering.parallel.cutoff)
    tables = {
        "Rotors, friction, offsets": _row_table(fit, "parameter, motor side", parameter_rows(fit), "parameters"),
        "Bodies": _bodies(fit),
    }
    combinations = _row_table(fit, "combination", base_rows(fit), "combinations", "prose")
    shown, words = (report.held_out[:_MOST], "not fitted") if report.held_out else ([used], "fitted")
    return Page(
        title=f"Rigid body of {fit.robot.title}",
        subtitle=f"Bodies, rotors and friction from {len(fit.segments)} logs, with {fit.level:.0%} intervals. "
        f"{_summary(fit)}{fit.trade_off.chosen}.",
        reading=[words_of("rigid_body")["reading"]],
        parts=[
            *map(Note, [*report.doubts, *filter(None, [excited])]),
            Section("What is left of the torque", [left, _errors(report)]),
            *(Section(title, [table]) for title, table in tables.items() if table.n_rows),
            Details(f"{combinations.n_rows} combinations that torque can tell", [combinations]),
            *(_figure(report, recording, words) for recording in shown),
        ],
        provenance=info,
    ).html()


def _summary(fit: RigidBodyFit, condition: str = "") -> str:
    """Begin a sentence on the number of base parameters and the prior; the caller appends the spread."""
    told = int(np.sum(fit.base_shares >= SURE))
    return (
        f"Torque can tell {len(fit.base.own)} combinations of {len(fit.labels)} parameters; these logs tell {told} of "
        f"them{condition}. Masses and rotors are held near the description, relative standard deviation "
    )


def _row_table(
    fit: RigidBodyFit, heading: str, rows: Sequence[ParameterRow], name: str = "", kind: Kind = "name"
) -> Table:
    return Table(
        columns=[
            Column(heading, [row.name for row in rows], kind=kind),
            Column("unit", [row.unit for row in rows], kind="text"),
            Column("before", [row.before for row in rows], ".4g"),
            Column("now", [row.now for row in rows], ".4g"),
            Column(f"{fit.level:.0%} interval", [_interval(row) for row in rows]),
            Column("told by", [row.verdict for row in rows], kind="text"),
        ],
        name=name,
    )


def _interval(row: ParameterRow) -> str | None:
    """Write the interval; None for a parameter that the logs do not excite, which keeps its value."""
    return None if row.verdict == "not excited" else f"{row.low:.4g} to {row.high:.4g}"


def _bodies(fit: RigidBodyFit) -> Table:
    """Tabulate masses before and now, and the number of each body's ten parameters that the data determine."""
    at = [i for i, label in enumerate(fit.labels) if label.endswith(".mass")]
    return Table(
        columns=[
            Column("body", [fit.labels[i].removesuffix(".mass") for i in at], kind="name"),
            Column("mass before", [fit.described[i] for i in at], ".4g", unit="kg"),
            Column("now", [fit.estimate[i] for i in at], ".4g", unit="kg"),
            Column("told by the data", [f"{fit.shares[i : i + 10].sum():.1f} of 10 numbers" for i in at]),
        ],
        name="bodies",
    )


def _errors(report: RigidBodyReport) -> Table:
    rows = [
        (log, joint, j, e) for log, e in report.validation.items() for j, joint in enumerate(report.fit.robot.joints)
    ]
    kinds = (("torque", "measured"), ("before", "described"), ("now", "identified"), ("file", "in_file"))
    columns = [
        Column("log", [log for log, *_ in rows], kind="name"),
        Column("joint", [joint for _, joint, *_ in rows], kind="name"),
        *(Column(kind, [_known(getattr(e, field)[j]) for _, _, j, e in rows], ".4f") for kind, field in kinds),
    ]
    return Table(columns=columns, name="errors", fixed=2, ruled_by=0)


def _known(value: float) -> float | None:
    """Replace NaN, the error of a joint that does not move in a log, by None."""
    return float(value) if np.isfinite(value) else None


def rigid_body_numbers(report: RigidBodyReport) -> dict[str, Any]:
    """Collect all numbers for JSON."""
    fit = report.fit
    columns = (fit.described, fit.estimate, fit.intervals.low, fit.intervals.high, fit.shares)
    return {
        "logs": list(fit.segments),
        "level": fit.level,
        "spread": {
            "chosen": fit.trade_off.chosen,
            "tried": fit.trade_off.spreads.tolist(),
            "held_out_errors": _plain(fit.trade_off.errors),
        },
        "condition": fit.condition if np.isfinite(fit.condition) else None,
        "not_excited": list(fit.not_excited),
        "parameters": [
            {"name": label, "unit": unit, "described": x0, "value": x, "low": low, "high": high, "data_share": share}
            for label, unit, x0, x, low, high, share in zip(fit.labels, fit.units, *map(_plain, columns), strict=True)
        ],
        "base_parameters": [vars(row) for row in base_rows(fit)],
        "errors_nm": {
            name: {kind: _plain(values) for kind, values in vars(errors).items()}
            for name, errors in report.validation.items()
        },
        "doubts": list(report.doubts),
    }


def _plain(values: Array) -> list[float | None]:
    """Replace NaN, which JSON lacks, by None."""
    return [_known(value) for value in values]


def _figure(report: RigidBodyReport, recording: Recording, words: str) -> ReportFigure:
    """Draw the filtered torque of a recording, and the predictions of description and fit."""
    fit, segment = report.fit, recording.header.segment
    equations = fit.equations([recording])
    models = {"description": fit.described, "identified": fit.estimate}
    prediction = TorquePrediction(
        robot=fit.robot,
        t=equations.t,
        measured=equations.measured,
        predicted={name: equations.measured - equations.residual(values) for name, values in models.items()},
        scored=equations.counts,
    )
    return ReportFigure(
        name=f"torque-{segment}",
        title=f"Motor torque of {segment}",
        caption=f"This recording was {words}. Torque and predictions are filtered alike.",
        figure=torque_figure(prediction),
    )
