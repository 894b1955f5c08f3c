"""`ffgym diagnose --table`: structures of the model against measured path errors, without logs."""

import sys
from pathlib import Path

from ffgym.agents.catalogue import find_law_name
from ffgym.agents.table_laws import learn_in_model
from ffgym.cli.log_options import Diagnose
from ffgym.cli.outputs import claim_outputs, given_options, hash_inputs, print_places, provenance
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError, check_whole, errors_at
from ffgym.core.executors import Executor
from ffgym.core.files import filled_folder, write_json, write_text
from ffgym.diagnosis.tables.document import table_document
from ffgym.diagnosis.tables.error_table import ErrorTable
from ffgym.diagnosis.tables.procedure import TableDiagnosis, diagnose_table
from ffgym.diagnosis.tables.published import thesis_table
from ffgym.diagnosis.tables.table_file import load_table, write_table
from ffgym.report.diagnosis import format_table_diagnosis

THESIS = "thesis"
"""Name of the table that ships with the package."""

DOCUMENT, NEXT, TABLE, FITS = "table_diagnosis.json", "next.toml", "table.toml", "structures"
"""Entries of the output folder: the result, the session that separates the best two, the table, and a file for each
structure, from which a diagnosis goes on."""

_OF_LOGS = ("robot", "columns", "calibration", "fit", "accept", "validate")
"""Options that have no effect on a table."""


def run(config: Diagnose) -> None:
    """Check, fit, write, print."""
    assert config.table is not None
    if config.logs or (given := given_options(config, _OF_LOGS)):
        what = "logs" if config.logs else given[0]
        raise FFGymError(f"--table takes no {what}: a table names its robot and has its own rows. Leave {what} out.")
    check_whole("--seed", config.seed, low=0)
    check_whole("--steps", config.steps, low=1, high=100)
    executor = Executor(kind=config.executor, jobs=config.jobs, address=config.address)
    table = thesis_table() if config.table == THESIS else load_table(config.table)
    with errors_at(table.title):
        for law in dict.fromkeys(row.law for row in table.rows):
            find_law_name(law)
    inputs = () if config.table == THESIS else (config.table,)
    if config.out is None:
        claim_outputs({"--json": config.json}, inputs=inputs)
        diagnosis = _diagnose(config, table, executor, None)
    else:
        with filled_folder(config.out):
            places = {f"--out, {name}": config.out / name for name in (DOCUMENT, NEXT)}
            claim_outputs({"--json": config.json} | places, inputs=inputs)
            diagnosis = _diagnose(config, table, executor, config.out / FITS)
            _write(config.out, diagnosis)
    if config.json is not None:
        write_json(config.json, table_document(diagnosis))
    print(format_table_diagnosis(diagnosis))
    if config.out is not None:
        session = config.out / NEXT if diagnosis.sessions else None
        print_places(diagnosis=config.out / DOCUMENT, table=config.out / TABLE, session=session)
    print_places(numbers=config.json)


def _diagnose(config: Diagnose, table: ErrorTable, executor: Executor, folder: Path | None) -> TableDiagnosis:
    """Fit and judge, with a bar that tells the time that is left."""
    with progress_bar("structures", "%") as progress:

        def report(text: str, share: float) -> None:
            progress(100 * share, 100.0)
            print(text, file=sys.stderr, flush=True)

        found = diagnose_table(
            table,
            structures=config.structures,
            pairs=config.pairs,
            left_out_by="refit" if config.refits else "one step",
            folder=folder,
            executor=executor,
            steps=config.steps,
            seed=config.seed,
            learn=learn_in_model,
            report=report,
        )
    passing = ("out", "json", "threads", "jobs", "executor", "address")
    origin = provenance("ffgym diagnose", config, table.robot, found.fingerprint, config.seed, passing=passing)
    files = {} if config.table == THESIS else hash_inputs([config.table])
    found.origin.update(origin | {"inputs": files})
    return found


def _write(folder: Path, diagnosis: TableDiagnosis) -> None:
    """Write result and table, and the session that separates the best two structures."""
    write_json(folder / DOCUMENT, table_document(diagnosis))
    write_table(folder / TABLE, diagnosis.table)
    if diagnosis.sessions:
        write_text(folder / NEXT, diagnosis.sessions[0].toml)
