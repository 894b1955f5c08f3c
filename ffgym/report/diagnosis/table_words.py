"""Diagnosis from a table in words for a terminal."""

from ffgym.diagnosis.tables.procedure import TableDiagnosis
from ffgym.report.table import Column, Table, wrap_text


def format_table_diagnosis(diagnosis: TableDiagnosis) -> str:
    """Format verdict, ranking, fitted numbers of the best structure, and the sessions that separate the best two."""
    ranked = diagnosis.ranked
    columns = [
        Column("structure", [one.fit.name for one in ranked], kind="code"),
        Column("free", [one.fit.free_parameters for one in ranked]),
        Column("unseen", [one.score for one in ranked], ".3f"),
        Column("ties", ["yes" if one.is_tied else "" for one in ranked], kind="text"),
        Column("fitted", [f"{one.fitted_within_1_5} of {one.fitted_rms}" for one in ranked], kind="text"),
        Column("held out", [f"{one.held_out_within_1_5} of {one.held_out_rms}" for one in ranked], kind="text"),
        Column("left out", [f"{one.left_out_within_1_5} of {one.fitted_rms}" for one in ranked], kind="text"),
    ]
    legend = (
        "free: fitted numbers; unseen: mean square of ln(predicted / measured) in RMS rows that they were not fitted "
        "to; fitted, held out, left out: RMS rows within a factor 1.5, those left out predicted by a fit without their "
        "position; cost: misfit and priors of the fit."
    )
    if diagnosis.table.sign_of is not None:
        right = [f"{one.sign_right} of {one.sign_cells}" for one in ranked]
        columns.append(Column("sign", right, kind="text"))
        legend += " sign: cells in which the law of sign_of helps, or harms, as it does in the table."
    columns.append(Column("cost", [one.fit.cost for one in ranked], ".0f"))
    parts = [
        wrap_text(f"{diagnosis.verdict}: {diagnosis.sentence}"),
        Table(columns=columns).text(),
        wrap_text(legend),
    ]
    best = next(one for one in ranked if one.fit.name == diagnosis.structure).fit
    if best.numbers:
        numbers = [
            Column(f"numbers of {best.name}", [number.name for number in best.numbers], kind="text"),
            Column("value", [number.value for number in best.numbers], ".3g"),
            Column("90 % interval", [f"{number.low:.3g} to {number.high:.3g}" for number in best.numbers], kind="text"),
            Column("before", [number.typical for number in best.numbers], ".3g"),
            Column("unit", [number.unit for number in best.numbers], kind="text"),
        ]
        parts.append(Table(columns=numbers).text())
    if diagnosis.sessions:
        first = diagnosis.sessions[0]
        parts.append(
            wrap_text(
                f"next: record {first.protocol} ({first.why}) with a tracker: the tool beside where the motors put it "
                f"differs between {' and '.join(first.between)} by up to {first.unexplained_max_mm:.3f} mm that no "
                f"other numbers make up for, {first.over_noise:.1f} times the noise."
            )
        )
    return "\n\n".join(parts)
