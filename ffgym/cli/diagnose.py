"""`ffgym diagnose`: compare logs of a machine with its model; name the causes of the misfit with intervals."""

import math
import shlex
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.cli import diagnose_table
from ffgym.cli.diagnose_inputs import ROBOT, Nominal, identify_nominal, logs_from, nominal_named
from ffgym.cli.log_options import Diagnose
from ffgym.cli.options import RECORD_DT_MS
from ffgym.cli.outputs import claim_outputs, given_options, hash_inputs, need_extra, print_places, provenance
from ffgym.cli.progress import progress_bar, stages_bar
from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.files import filled_folder, write_text
from ffgym.diagnosis import Diagnosis, Examination, ParameterPrior, examine
from ffgym.diagnosis.diagnosis_file import write_diagnosis
from ffgym.diagnosis.extended import save_extended
from ffgym.diagnosis.held_out import LoopLevel, check_comparable, compare_in_closed_loop, compare_replays, is_better
from ffgym.diagnosis.nominal import EXAMPLE_LOGS, EXAMPLE_ROBOT
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.thinning import read_notes
from ffgym.logs import write_corrected
from ffgym.logs.quality import accept_findings, judge_logs
from ffgym.recordings import Recording
from ffgym.report.diagnosis import (
    DiagnosisReport,
    compare_levels,
    format_diagnosis,
    render_diagnosis_page,
    simulation_note,
)
from ffgym.report.table import wrap_text
from ffgym.robot import ModelOptions, load_draft
from ffgym.simulation.plant import Machine, load_machine, save_machine
from ffgym.simulation.plant.machine_file import is_machine_file

REPORT, DOCUMENT, NOMINAL, EXTENDED, NEXT = (
    *("report.html", "diagnosis.json"),
    *("nominal.toml", "extended.toml", "next.toml"),
)
"""Files of the output folder: the nominal model if it was fitted, the extended one if there are causes and it predicts
better, and the next motions if rivals tie."""

COLUMNS = "columns.toml"
"""Corrected column map, written if columns are not what they are called."""

WORSE = (
    "The extended model predicts motions that were left out of its fit worse than the nominal one; it is not written."
)


def run(config: Diagnose) -> None:
    """Check, read, diagnose, write, print."""
    if config.table is not None:
        diagnose_table.run(config)
        return
    _check(config)
    with nullcontext() if config.out is None else filled_folder(config.out):
        if config.out is not None:
            names = (REPORT, DOCUMENT, ROBOT, NOMINAL, EXTENDED, NEXT, COLUMNS)
            places = {f"--out, {name}": config.out / name for name in names}
            claim_outputs({"--json": config.json} | places, inputs=_read_by(config))
        _diagnose(config)


def _diagnose(config: Diagnose) -> None:
    with stages_bar("reading logs") as tell:
        nominal, recordings = _inputs(config)
        held_out = _held_out(config, nominal)
        prior = nominal.prior or ParameterPrior()  # as fitted, or as usual
        if config.calibration is not None:
            prior = ParameterPrior.of_share(config.calibration)
        examined = examine(
            nominal.machine,
            recordings,
            prior=prior,
            seed=config.seed,
            report=tell,
            # soon and on stderr: what is printed is the verdict
            first=lambda look: print(look.sentence, file=sys.stderr, flush=True),
            most=config.most_causes,
            accept=config.accept,
        )
    # extended model, judged by replay and closed loop on recordings that were held out
    robot, origin = nominal.machine.robot, origin_of(config, nominal.machine)
    examined = replace(examined, diagnosis=replace(examined.diagnosis, provenance=origin))
    models = _models(config, examined, nominal, recordings)
    replayed, closed_loop = _compare(config, models, examined, nominal, held_out)
    if replayed and not is_better(replayed) and examined.diagnosis.causes:
        examined = replace(examined, diagnosis=replace(examined.diagnosis, gains=False))
        _remove(config, EXTENDED)
    step = next_step(config, examined.diagnosis, period_of(recordings))
    _write(config, examined, replayed, closed_loop, step.commands)
    # everything for people
    diagnosis = examined.diagnosis
    print(format_diagnosis(diagnosis, robot))
    if replayed:
        print(f"\n{compare_levels('held out, RMS of', replayed).text()}")
    if closed_loop:
        print(f"\n{compare_levels('closed loop, RMS of', closed_loop).text()}")
    if diagnosis.causes and not diagnosis.gains:
        print(f"\n{WORSE}")
    print(f"\n{step.text}")
    if config.out is not None:
        names = (REPORT, DOCUMENT, NOMINAL, EXTENDED, NEXT, COLUMNS)
        words = ("report", "diagnosis", "fitted model", "model", "next motions", "corrected columns")
        there = {what: config.out / name for what, name in zip(words, names, strict=True)}
        print_places(**{what: place for what, place in there.items() if place.exists()})
    print_places(numbers=config.json)


def _check(config: Diagnose) -> None:
    """Refuse options that cannot be run or written, before long work."""
    if config.robot is None and (config.logs or config.fit):
        raise FFGymError("Name the model that the logs are compared with: --robot ROBOT.")
    if not config.logs and (given := given_options(config, ("columns",))):
        raise FFGymError(f"{given[0]} has no effect on the example logs. Leave it out, or name logs.")
    if given := given_options(config, ("structures", "pairs", "refits", "steps", "executor", "address", "jobs")):
        raise FFGymError(f"{given[0]} has no effect on logs. Leave it out, or give --table FILE.")
    accept_findings(config.accept)
    check_whole("--seed", config.seed, low=0)
    check_whole("--most-causes", config.most_causes, low=1, high=settings().search.most_causes)
    if config.calibration is not None:
        check_number("--calibration", config.calibration, low=0.0, high=1.0, open_low=True)
    claim_outputs({"--json": config.json}, inputs=_read_by(config))
    if config.out is not None:
        need_extra("The report", "matplotlib", "jinja2")


def _read_by(config: Diagnose) -> tuple[str | Path | None, ...]:
    """Inputs, which must not be written over."""
    return (config.robot or EXAMPLE_ROBOT, config.columns, *(config.logs or (EXAMPLE_LOGS,)), *config.validate)


def origin_of(config: Diagnose, machine: Machine) -> dict[str, Any]:
    """Origin of a diagnosis: the command without what only says where results go, the model, and the input files."""
    passing, physics = ("out", "json", "threads"), machine.physics(ModelOptions(looks=False))
    origin = provenance("ffgym diagnose", config, machine.robot.name, physics, config.seed, passing=passing)
    return origin | {"inputs": hash_inputs(_read_by(config))}


def period_of(recordings: Sequence[Recording]) -> float | None:
    """Sample period of recordings [s]; None if it is that of `ffgym record`."""
    period = float(np.median(np.diff(recordings[0].t)))
    return None if math.isclose(1e3 * period, RECORD_DT_MS) else period


def _inputs(config: Diagnose) -> tuple[Nominal, list[Recording]]:
    """The model and the logs."""
    if not config.fit:
        nominal = nominal_named(config.robot)
        return nominal, logs_from(config.logs, config.columns, nominal.machine.robot)
    assert config.robot is not None
    if is_machine_file(config.robot):
        raise FFGymError(
            f"--fit {config.robot}: is a machine file, which has fitted numbers. Name a built-in robot or a "
            "description (.toml), or leave --fit out."
        )
    draft = load_draft(config.robot)
    recordings = logs_from(config.logs, config.columns, draft.description_for("identification"))
    sound = judge_logs(recordings, needs=("diagnosis",), accept=config.accept).recordings
    return identify_nominal(draft, config.robot, sound or recordings), recordings


def _held_out(config: Diagnose, nominal: Nominal) -> list[Recording]:
    """Logs that are not diagnosed, read before long work."""
    if not config.validate:
        return []
    read = logs_from(config.validate, config.columns, nominal.machine.robot)
    sound = judge_logs(read, nominal.machine.physical, needs=("diagnosis",), accept=config.accept)
    held_out = [*sound.recordings]
    for note in read_notes(held_out):
        print(f"--validate: {note}", file=sys.stderr, flush=True)
    if not held_out:
        raise FFGymError(
            f"--validate: the quality gate refuses all {len(read)} logs; the first: {sound.left_out[0]} Name other "
            "logs, or overrule the check with --accept CHECK."
        )
    if _runs_again(nominal, held_out):
        check_comparable(nominal.machine, held_out)
    return held_out


def _runs_again(nominal: Nominal, held_out: Sequence[Recording]) -> bool:
    """Tell whether closed loops can be simulated along recordings: they have set-points, and the servo is known."""
    return bool(held_out) and nominal.knows_servo and all(one.has("reference.position") for one in held_out)


def _models(
    config: Diagnose, examined: Examination, nominal: Nominal, recordings: Sequence[Recording]
) -> tuple[Machine, Machine]:
    """Nominal and extended model; written and read back, if there is a folder for them."""
    if config.out is None:
        return examined.nominal, examined.machine
    _remove(config, NOMINAL, EXTENDED, NEXT, COLUMNS)
    robot, before = nominal.describe_in(config.out), examined.nominal
    if nominal.prior is not None:
        source = "fitted to the logs before the diagnosis"
        title = f"{before.robot.title}, fitted by ffgym diagnose"
        save_machine(before, config.out / NOMINAL, title=title, source=source, robot=robot)
        before = load_machine(config.out / NOMINAL)
    if not (examined.diagnosis.causes and examined.diagnosis.gains):
        return before, examined.machine
    save_extended(
        config.out / EXTENDED,
        examined.diagnosis,
        nominal.machine,
        robot=robot,
        origins=nominal.origins,
        recordings=recordings,
    )
    return before, load_machine(config.out / EXTENDED)


def _remove(config: Diagnose, *names: str) -> None:
    """Remove files of the folder that are not of this diagnosis."""
    if config.out is not None:
        for name in names:
            (config.out / name).unlink(missing_ok=True)


def _compare(
    config: Diagnose,
    models: tuple[Machine, Machine],
    examined: Examination,
    nominal: Nominal,
    held_out: Sequence[Recording],
) -> tuple[Sequence[LoopLevel], Sequence[LoopLevel]]:
    """Replay both models along logs that were not diagnosed, and run them along their set-points if they have some."""
    if not held_out or examined.before is None:
        return (), ()
    replayed = compare_replays(*models, held_out, cutoff=examined.before.cutoff)
    if not _runs_again(nominal, held_out):
        return replayed, ()
    with progress_bar("closed loops", "s") as progress:
        return replayed, compare_in_closed_loop(*models, held_out, n_threads=config.threads, progress=progress)


def _write(
    config: Diagnose,
    examined: Examination,
    replayed: Sequence[LoopLevel],
    closed_loop: Sequence[LoopLevel],
    commands: Sequence[str],
) -> None:
    """Write page, JSON and protocol or column map, before anything is printed."""
    diagnosis = examined.diagnosis
    if config.json is not None:
        write_diagnosis(config.json, diagnosis)
    if config.out is None:
        return
    page = DiagnosisReport(
        diagnosis=diagnosis,
        before=examined.before,
        after=examined.after if diagnosis.causes else None,
        held_out=replayed,
        closed_loop=closed_loop,
        commands=commands,
    )
    write_text(config.out / REPORT, render_diagnosis_page(page))
    write_diagnosis(config.out / DOCUMENT, diagnosis)
    if diagnosis.separating_motion is not None:
        write_text(config.out / NEXT, diagnosis.separating_motion.toml)
    if diagnosis.wiring:
        notes = [mistake.message for mistake in diagnosis.wiring]
        write_corrected(config.out / COLUMNS, examined.rewiring, config.columns, notes)


@dataclass(frozen=True)
class NextStep:
    """Advice after a diagnosis, with commands that run as they are printed."""

    advice: str
    commands: tuple[str, ...]

    @property
    def text(self) -> str:
        """Advice and commands for a terminal, a line each."""
        lines, note = [wrap_text(f"next: {self.advice}"), *self.commands], simulation_note(self.commands)
        return "\n  ".join(lines) + (f"\n{wrap_text(note.replace('`', ''))}" if note else "")


def next_step(config: Diagnose, diagnosis: Diagnosis, period: float | None = None) -> NextStep:
    """Choose the next step after a diagnosis; without an output folder the first command makes one.

    Args:
        config: options of the diagnosis.
        diagnosis: its result.
        period: sample period of the logs [s], which those that stand beside them must have; None is the usual one.
    """
    robot, logs = config.robot or EXAMPLE_ROBOT, [str(path) for path in config.logs]
    folder = Path("found") if config.out is None else config.out
    # options to be repeated, so that the next diagnosis is comparable
    options = ["--fit"] * config.fit + (["--accept", *config.accept] if config.accept else [])
    options += [] if config.calibration is None else ["--calibration", f"{config.calibration:g}"]
    columns = [] if config.columns is None else ["--columns", config.columns]
    first = []
    if config.out is None:
        given = [] if config.robot is None else ["--robot", robot, *options, *columns]
        first = [["diagnose", *logs, *given, "--out", str(folder)]]
    machine = str(folder / NOMINAL) if config.fit else robot
    rows = [] if period is None else ["--record-dt-ms", f"{1e3 * period:.6g}"]
    # rivals that tie: the motion that separates them
    if diagnosis.separating_motion is not None:
        # logs of another tool need their column map, so that recordings cannot stand beside them
        more = f"{folder}_more_logs"  # of this diagnosis alone: a folder holds one session
        both = [*([] if columns else logs), more]
        record = ["record", machine, str(folder / NEXT), *rows, "--out", more]
        again = ["diagnose", *both, "--robot", robot, *options, "--out", f"{folder}_again"]
        return _step("record the motions that tell the rivals apart, and diagnose all logs:", *first, record, again)
    # causes found: validation on motions of their own
    if diagnosis.verdict in ("named", "partly", "ambiguous"):
        if not diagnosis.gains:
            return _step("record motions in other regimes; protocols are listed by", ["record", "--list"])
        other = f"{folder}_other_logs"
        record = ["record", machine, "diagnosis", *rows, "--out", other]
        again = ["diagnose", other, "--robot", str(folder / EXTENDED)]
        advice = "record motions that were not used, and see whether the extended model explains them:"
        return _step(advice, *first, record, again)
    # faulty columns or logs: mend these before anything else
    if diagnosis.verdict == "wiring":
        mended = ["diagnose", *logs, "--robot", robot, *options, "--columns", str(folder / COLUMNS)]
        return _step("diagnose again with the corrected column map:", *first, mended)
    if diagnosis.verdict == "insufficient":
        check = ["log", "check", *logs, "--robot", robot, "--needs", "diagnosis", *columns]
        return _step("see which check refuses each log, and its limit:", check)
    advice = "record motions in other regimes, if the simulation is wrong in those"
    if diagnosis.verdict == "unknown":
        advice = "record motions that vary the variables that the patterns name, one at a time"
    return _step(f"{advice}; protocols are listed by", ["record", "--list"])


def _step(advice: str, *commands: Sequence[str]) -> NextStep:
    return NextStep(advice, tuple(shlex.join(["ffgym", *command]) for command in commands))
