"""JSON document of a diagnosis from a table."""

from dataclasses import asdict
from typing import Any

import numpy as np

from ffgym.core.provenance import versions
from ffgym.core.typed_json import to_json
from ffgym.diagnosis.tables.error_table import ErrorTable
from ffgym.diagnosis.tables.problem import MAX_SPREAD, RMS_SPREAD
from ffgym.diagnosis.tables.procedure import TableDiagnosis
from ffgym.diagnosis.tables.ranking import RankedStructure
from ffgym.diagnosis.tables.structure_fit import StructureFit

FORMAT, VERSION = "ffgym-table-diagnosis", 1
"""Entries `format` and `version` of the JSON document."""


def table_document(diagnosis: TableDiagnosis) -> dict[str, Any]:
    """Write a diagnosis as a JSON document; docs/diagnosis_tables.md lists its entries."""
    table = diagnosis.table
    rows = [
        {"cell": row.cell, "position": row.motion.position, "motion": row.motion.file}
        | {"speed_mm_s": row.motion.speed_mm_s}
        | {name: getattr(row, name) for name in ("table", "use", "radius_mm", "law", "statistic", "value_mm")}
        for row in table.rows
    ]
    return {
        "format": FORMAT,
        "version": VERSION,
        "verdict": diagnosis.verdict,
        "sentence": diagnosis.sentence,
        "structure": diagnosis.structure,
        "ties": list(diagnosis.ties),
        "structures": [_structure_document(one, table) for one in diagnosis.ranked],
        "separating_sessions": to_json(diagnosis.sessions),
        "rows": rows,
        "table": {"title": table.title, "source": table.source, "robot": table.robot},
        "sign_of": None if table.sign_of is None else asdict(table.sign_of),
        "spreads": {"rms": RMS_SPREAD, "max": MAX_SPREAD},
        "seed": diagnosis.seed,
        "steps": diagnosis.steps,
        "versions": versions(),
        "physics_fingerprint": diagnosis.fingerprint,
        "provenance": diagnosis.origin,
    }


def _structure_document(one: RankedStructure, table: ErrorTable) -> dict[str, Any]:
    """Write a structure as an object of the list `structures`."""
    fit = one.fit
    found: dict[str, Any] = {
        name: getattr(fit, name) for name in ("name", "title", "free_parameters", "cost", "prior_cost", "steps")
    }
    found |= {name: value for name, value in to_json(one).items() if name != "fit"} | {"fits": one.fits}
    found["left_out_by"] = fit.left_out_by
    found["leave_one_position_out"] = [_place_document(fit, table, place) for place in table.places]
    found["numbers"] = to_json(fit.numbers)
    found["predicted_mm"] = [_round(value) for value in fit.predicted_mm]
    found["left_out_mm"] = [_round(value) for value in fit.left_out_mm]
    found["physics_fingerprint"] = fit.fingerprint
    return found


def _place_document(fit: StructureFit, table: ErrorTable, place: str) -> dict[str, Any]:
    """Tell what a fit without a place leaves in its RMS rows."""
    rows = table.at(place) & table.is_rms
    logs = np.abs(np.log(np.array(fit.left_out_mm)[rows] / table.values[rows]))
    logs = logs[np.isfinite(logs)]
    found = {"position": place, "rows": int(rows.sum()), "within_1_5": int(np.sum(logs < np.log(1.5)))}
    return found | {"median_abs_log": float(np.median(logs)) if len(logs) else None}


def _round(value: float) -> float | None:
    """Round an error to a tenth of a micrometre; None if there is none."""
    return round(value, 4) if np.isfinite(value) else None
