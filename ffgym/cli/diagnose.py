"""`ffgym diagnose`: what a simulation gets wrong, why, and how sure that is, from logs of the machine."""

import sys
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import tyro

from ffgym.cli.diagnose_inputs import Nominal, draft_named, fitted, logs_from, nominal_named
from ffgym.cli.outputs import check_outputs, need_extra, provenance
from ffgym.cli.progress import progress_bar, stages_bar
from ffgym.cli.unused import given_options
from ffgym.diagnosis import Calibration, Diagnosis, Examined, examine
from ffgym.diagnosis.closed_loop import LoopLevel, check_comparable, closed_loop_gain
from ffgym.diagnosis.document import write_diagnosis
from ffgym.diagnosis.extended import save_extended
from ffgym.diagnosis.first_look import FirstLook
from ffgym.diagnosis.search.search import MOST
from ffgym.errors import FFGymError, check_number, check_whole
from ffgym.files import made_folder, write_text
from ffgym.logs import write_corrected
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions

REPORT, DOCUMENT, EXTENDED, NEXT = "report.html", "diagnosis.json", "extended.toml", "next.toml"
"""What is written to the folder; the last two only if there are causes, and if there is something to record."""

COLUMNS = "columns.toml"
"""Corrected column map, which is written if columns are not what they are called."""


@dataclass(frozen=True)
class Diagnose:
    """Compare logs of a machine with its nominal model: where that is wrong, which cause explains it, how sure."""

    logs: tyro.conf.Positional[tuple[Path, ...]] = ()
    """Recordings (.npz, .csv) or folders of them, one for each motion; files of other tools with --columns. None given
    are the example logs of a machine with two faults."""
    robot: str | None = None
    """Nominal model: a built-in robot or its parameters, a description, or a machine file (.toml), such as the
    extended.toml of an earlier diagnosis."""
    columns: str | None = None
    """Column map for files of other tools: a built-in name, or a file that ends in .toml."""
    calibration: float | None = None
    """How well the nominal numbers are known: their relative standard deviation. None given is 0.005, or with --fit
    what the fit says."""
    fit: bool = False
    """Fit masses, rotors and friction to the logs before, for a robot whose numbers are not known; its description may
    lack them."""
    validate: tuple[Path, ...] = ()
    """Recordings or folders that are not diagnosed; both models run their references in closed loop, and are compared
    with what was measured. Takes reference.position."""
    out: Path | None = None
    """Folder for report.html, diagnosis.json, extended.toml (the model with the causes) and next.toml (what to record
    to tell rivals apart); it is made if there is none. An older extended.toml or next.toml in it goes."""
    most_causes: int = MOST
    """Causes to look for; fewer take less time, and a diagnosis of the extended model finds further ones. Each wave of
    one that repeats with an angle counts."""
    seed: int = 0
    """Of the noise of simulated logs and of resamples."""
    json: Path | None = None
    """Also write diagnosis.json under this name."""
    threads: int = 0
    """Threads of the closed loops, 0 for all cores; results are the same at any number."""

    def run(self) -> None:
        """Check, read, diagnose, write, print."""
        self._check()
        with nullcontext() if self.out is None else made_folder(self.out):
            self._check_folder()
            self._diagnose()

    def _diagnose(self) -> None:
        with stages_bar("reading logs") as tell:
            nominal, recordings = self._inputs()
            held_out = self._held_out(nominal)
            examined = examine(
                nominal.machine,
                recordings,
                calibration=self._calibration(nominal),
                seed=self.seed,
                report=tell,
                first=_say,
                most=self.most_causes,
            )
        physics = nominal.machine.physics(ModelOptions(looks=False))
        info = provenance("ffgym diagnose", self, nominal.machine.robot.name, physics, self.seed)
        diagnosis = replace(examined.diagnosis, provenance=_lasting(info))
        closed_loop = self._closed_loop(examined, held_out)
        self._write(replace(examined, diagnosis=diagnosis), nominal, recordings, closed_loop)
        self._tell(diagnosis, closed_loop)

    def _check(self) -> None:
        """Refuse what cannot be run or written, before long work."""
        if self.robot is None and (self.logs or self.fit):
            raise FFGymError("Name the model that the logs are compared with: --robot ROBOT.")
        if not self.logs and (given := given_options(self, ("columns",))):
            raise FFGymError(f"{given[0]} has no effect on the example logs. Leave it out, or name logs.")
        check_whole("--seed", self.seed, low=0)
        check_whole("--most-causes", self.most_causes, low=1, high=MOST)
        if self.calibration is not None:
            check_number("--calibration", self.calibration, low=0.0, high=1.0, open_low=True)
        inputs = (self.robot, self.columns, *self.logs, *self.validate)
        check_outputs({"--json": self.json}, inputs=inputs)
        if self.out is not None:
            need_extra("The report", "matplotlib", "jinja2")

    def _check_folder(self) -> None:
        """Refuse a folder that cannot be written to."""
        if self.out is None:
            return
        inputs = (self.robot, self.columns, *self.logs, *self.validate)
        names = (REPORT, DOCUMENT, EXTENDED, NEXT, COLUMNS)
        check_outputs({"--json": self.json} | {f"--out, {name}": self.out / name for name in names}, inputs=inputs)

    def _inputs(self) -> tuple[Nominal, list[Recording]]:
        """The model and the logs."""
        if not self.fit:
            nominal = nominal_named(self.robot)
            return nominal, logs_from(self.logs, self.columns, nominal.machine.robot)
        assert self.robot is not None
        draft = draft_named(self.robot)
        recordings = logs_from(self.logs, self.columns, draft.description_for("identification"))
        return fitted(draft, self.robot, recordings), recordings

    def _calibration(self, nominal: Nominal) -> Calibration:
        """How well the numbers are known: as told, as fitted, or as usual."""
        if self.calibration is not None:
            return Calibration.of_share(self.calibration)
        return nominal.calibration or Calibration()

    def _held_out(self, nominal: Nominal) -> list[Recording]:
        """Logs that are not diagnosed, read before long work."""
        if not self.validate:
            return []
        held_out = logs_from(self.validate, self.columns, nominal.machine.robot)
        check_comparable(nominal.machine, held_out)
        return held_out

    def _closed_loop(self, examined: Examined, held_out: Sequence[Recording]) -> Sequence[LoopLevel]:
        """Both models beside the machine, on logs that were not diagnosed."""
        if not held_out or examined.diagnosis.verdict in ("insufficient", "wiring"):
            return ()
        with progress_bar("closed loops", "s") as progress:
            return closed_loop_gain(
                examined.nominal, examined.machine, held_out, n_threads=self.threads, progress=progress
            )

    def _write(
        self, examined: Examined, nominal: Nominal, recordings: Sequence[Recording], closed_loop: Sequence[LoopLevel]
    ) -> None:
        """Files first: nobody may read what is printed."""
        diagnosis = examined.diagnosis
        if self.json is not None:
            write_diagnosis(self.json, diagnosis)
        if self.out is None:
            return
        from ffgym.report.diagnosis import DiagnosisReport, render_diagnosis_page

        after = examined.after if diagnosis.causes else None
        page = DiagnosisReport(diagnosis=diagnosis, before=examined.before, after=after, closed_loop=closed_loop)
        write_text(self.out / REPORT, render_diagnosis_page(page))
        write_diagnosis(self.out / DOCUMENT, diagnosis)
        for name in (EXTENDED, NEXT):
            (self.out / name).unlink(missing_ok=True)
        if diagnosis.causes:
            save_extended(
                self.out / EXTENDED,
                diagnosis,
                nominal.machine,
                robot=nominal.reference,
                origins=nominal.origins,
                recordings=recordings,
            )
        if diagnosis.separating_motion is not None:
            write_text(self.out / NEXT, diagnosis.separating_motion.toml)
        if diagnosis.wiring:
            notes = [mistake.message for mistake in diagnosis.wiring]
            write_corrected(self.out / COLUMNS, examined.rewiring, self.columns, notes)

    def _tell(self, diagnosis: Diagnosis, closed_loop: Sequence[LoopLevel]) -> None:
        """Everything for people."""
        from ffgym.report.diagnosis import format_closed_loop, format_diagnosis

        print(format_diagnosis(diagnosis))
        if closed_loop:
            print(f"\n{format_closed_loop(closed_loop)}")
        print(f"\nnext: {self._next(diagnosis)}")
        if self.out is not None:
            places = [self.out / name for name in (REPORT, DOCUMENT, EXTENDED, NEXT)]
            if diagnosis.wiring:
                print(f"corrected columns: {self.out / COLUMNS}")
            for what, place in zip(("report", "diagnosis", "model", "next motions"), places, strict=True):
                if place.exists():
                    print(f"{what}: {place}")
        if self.json is not None:
            print(f"numbers: {self.json}")

    def _next(self, diagnosis: Diagnosis) -> str:
        """What to do now, as a command where there is one."""
        logs, robot = " ".join(map(str, self.logs)) or "LOGS", self.robot or diagnosis.robot
        folder = "FOLDER" if self.out is None else str(self.out)
        first = "" if self.out is not None else "diagnose again with --out FOLDER, then "
        if diagnosis.separating_motion is not None:
            return (
                f"{first}ffgym record MACHINE {folder}/{NEXT} --out more_logs; "
                f"ffgym diagnose {logs} more_logs --robot {robot}"
            )
        if diagnosis.verdict in ("named", "partly", "ambiguous"):
            return (
                f"{first}record other motions on the machine, and see whether the extended model explains them: "
                f"ffgym diagnose OTHER_LOGS --robot {folder}/{EXTENDED}"
            )
        if diagnosis.verdict == "wiring":
            return f"{first}ffgym diagnose {logs} --robot {robot} --columns {folder}/{COLUMNS}"
        if diagnosis.verdict == "insufficient":
            return f"ffgym log check {logs} --robot {robot} --needs diagnosis"
        if diagnosis.verdict == "unknown":
            return "record motions that vary what the patterns name, and nothing else; ffgym record --list shows some"
        return "record motions in other regimes, if the simulation is wrong in those; ffgym record --list shows some"


def _say(look: FirstLook) -> None:
    """Soon and on stderr: what is printed is the verdict."""
    print(look.sentence, file=sys.stderr, flush=True)


def _lasting(info: dict[str, Any]) -> dict[str, Any]:
    """What a diagnosis depends on, without options that only say where it goes and how it is made."""
    passing = ("out", "json", "threads")
    config = {name: value for name, value in info["config"].items() if name not in passing}
    return info | {"config": config}
