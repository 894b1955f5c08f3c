"""`ffgym diagnose`: what a simulation gets wrong, why, and how sure that is, from logs of the machine."""

import sys
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import tyro

from ffgym.cli.diagnose_inputs import ROBOT, Nominal, draft_named, fit_nominal, logs_from, nominal_named
from ffgym.cli.outputs import check_outputs, need_extra, provenance
from ffgym.cli.progress import progress_bar, stages_bar
from ffgym.cli.unused import given_options
from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.files import made_folder, write_text
from ffgym.diagnosis import Calibration, Diagnosis, Examined, examine
from ffgym.diagnosis.document import write_diagnosis
from ffgym.diagnosis.excitation import FirstLook
from ffgym.diagnosis.extended import save_extended
from ffgym.diagnosis.held_out import HeldOut, LoopLevel, check_comparable, closed_loop_gain, held_out_levels
from ffgym.diagnosis.search.search import MOST
from ffgym.diagnosis.thinning import note_of
from ffgym.logs import write_corrected
from ffgym.logs.quality import accepted, judged
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions, RobotDescription
from ffgym.simulation.plant import Machine, load_machine, save_machine

REPORT, DOCUMENT, NOMINAL, EXTENDED, NEXT = (
    *("report.html", "diagnosis.json"),
    *("nominal.toml", "extended.toml", "next.toml"),
)
"""What is written to the folder: the nominal model if it was fitted, the extended one if there are causes and it is
better, and what to record if there is something."""

WORSE = "The extended model leaves more than the nominal one of motions that were left out; it is not written."

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
    accept: tuple[str, ...] = ()
    """Checks of quality that are overruled, e.g. coarse: a log that they refuse is used all the same, and the page says
    so. Others that are refused are left out."""
    validate: tuple[Path, ...] = ()
    """Recordings or folders that are not diagnosed: both models, read from their files if there is --out, are replayed
    along them, and run their references in closed loop where they have reference.position and the servo is known."""
    out: Path | None = None
    """Folder for report.html, diagnosis.json, extended.toml (the model with the causes), next.toml (what to record to
    tell rivals apart), and with --fit nominal.toml; it is made if there is none. Older models in it go."""
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
                accept=self.accept,
            )
        physics = nominal.machine.physics(ModelOptions(looks=False))
        info = provenance("ffgym diagnose", self, nominal.machine.robot.name, physics, self.seed)
        examined = replace(examined, diagnosis=replace(examined.diagnosis, provenance=_lasting(info)))
        models = self._models(examined, nominal, recordings)
        compared = self._compare(models, examined, held_out)
        if compared is not None and not compared.is_better and examined.diagnosis.causes:
            examined = replace(examined, diagnosis=replace(examined.diagnosis, gains=False))
            self._remove(EXTENDED)
        closed_loop = self._run_closed_loop(models, nominal, examined, held_out)
        self._write(examined, compared, closed_loop)
        self._tell(examined.diagnosis, compared, closed_loop, nominal.machine.robot)

    def _check(self) -> None:
        """Refuse what cannot be run or written, before long work."""
        if self.robot is None and (self.logs or self.fit):
            raise FFGymError("Name the model that the logs are compared with: --robot ROBOT.")
        if not self.logs and (given := given_options(self, ("columns",))):
            raise FFGymError(f"{given[0]} has no effect on the example logs. Leave it out, or name logs.")
        accepted(self.accept)
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
        names = (REPORT, DOCUMENT, ROBOT, NOMINAL, EXTENDED, NEXT, COLUMNS)
        check_outputs({"--json": self.json} | {f"--out, {name}": self.out / name for name in names}, inputs=inputs)

    def _inputs(self) -> tuple[Nominal, list[Recording]]:
        """The model and the logs."""
        if not self.fit:
            nominal = nominal_named(self.robot)
            return nominal, logs_from(self.logs, self.columns, nominal.machine.robot)
        assert self.robot is not None
        draft = draft_named(self.robot)
        recordings = logs_from(self.logs, self.columns, draft.description_for("identification"))
        sound = judged(recordings, needs=("diagnosis",), accept=self.accept).recordings
        return fit_nominal(draft, self.robot, sound or recordings), recordings

    def _calibration(self, nominal: Nominal) -> Calibration:
        """Standard deviations of the numbers: as told, as fitted, or as usual."""
        if self.calibration is not None:
            return Calibration.of_share(self.calibration)
        return nominal.calibration or Calibration()

    def _held_out(self, nominal: Nominal) -> list[Recording]:
        """Logs that are not diagnosed, read before long work."""
        if not self.validate:
            return []
        read = logs_from(self.validate, self.columns, nominal.machine.robot)
        sound = judged(read, nominal.machine.physical, needs=("diagnosis",), accept=self.accept)
        held_out = [*sound.recordings]
        for note in note_of(held_out):
            print(f"--validate: {note}", file=sys.stderr, flush=True)
        if not held_out:
            raise FFGymError(f"--validate: none of these logs can be used: {sound.left_out[0]}")
        if _runs_again(nominal, held_out):
            check_comparable(nominal.machine, held_out)
        return held_out

    def _models(self, examined: Examined, nominal: Nominal, recordings: Sequence[Recording]) -> tuple[Machine, Machine]:
        """Nominal and extended model; written and read back, if there is a folder for them."""
        if self.out is None:
            return examined.nominal, examined.machine
        self._remove(NOMINAL, EXTENDED, NEXT, COLUMNS)
        robot, before = nominal.describe_in(self.out), examined.nominal
        if nominal.calibration is not None:
            source = "fitted to the logs before the diagnosis"
            title = f"{before.robot.title}, fitted by ffgym diagnose"
            save_machine(before, self.out / NOMINAL, title=title, source=source, robot=robot)
            before = load_machine(self.out / NOMINAL)
        if not (examined.diagnosis.causes and examined.diagnosis.gains):
            return before, examined.machine
        save_extended(
            self.out / EXTENDED,
            examined.diagnosis,
            nominal.machine,
            robot=robot,
            origins=nominal.origins,
            recordings=recordings,
        )
        return before, load_machine(self.out / EXTENDED)

    def _remove(self, *names: str) -> None:
        if self.out is None:
            return
        for name in names:
            (self.out / name).unlink(missing_ok=True)

    def _compare(
        self, models: tuple[Machine, Machine], examined: Examined, held_out: Sequence[Recording]
    ) -> HeldOut | None:
        """Replay both models along logs that were not diagnosed."""
        if not held_out or examined.before is None:
            return None
        return held_out_levels(*models, held_out, cutoff=examined.before.cutoff)

    def _run_closed_loop(
        self, models: tuple[Machine, Machine], nominal: Nominal, examined: Examined, held_out: Sequence[Recording]
    ) -> Sequence[LoopLevel]:
        """Run both models under the documented controller, along the set-points of logs that were not diagnosed."""
        if examined.before is None or not _runs_again(nominal, held_out):
            return ()
        with progress_bar("closed loops", "s") as progress:
            return closed_loop_gain(*models, held_out, n_threads=self.threads, progress=progress)

    def _write(self, examined: Examined, compared: HeldOut | None, closed_loop: Sequence[LoopLevel]) -> None:
        """Files first: nobody may read what is printed."""
        diagnosis = examined.diagnosis
        if self.json is not None:
            write_diagnosis(self.json, diagnosis)
        if self.out is None:
            return
        from ffgym.report.diagnosis import DiagnosisReport, render_diagnosis_page

        after = examined.after if diagnosis.causes else None
        page = DiagnosisReport(
            diagnosis=diagnosis,
            before=examined.before,
            after=after,
            held_out=() if compared is None else compared.levels,
            closed_loop=closed_loop,
        )
        write_text(self.out / REPORT, render_diagnosis_page(page))
        write_diagnosis(self.out / DOCUMENT, diagnosis)
        if diagnosis.separating_motion is not None:
            write_text(self.out / NEXT, diagnosis.separating_motion.toml)
        if diagnosis.wiring:
            notes = [mistake.message for mistake in diagnosis.wiring]
            write_corrected(self.out / COLUMNS, examined.rewiring, self.columns, notes)

    def _tell(
        self, diagnosis: Diagnosis, compared: HeldOut | None, closed_loop: Sequence[LoopLevel], robot: RobotDescription
    ) -> None:
        """Everything for people."""
        from ffgym.report.diagnosis import compared_table, format_diagnosis

        print(format_diagnosis(diagnosis, robot))
        if compared is not None:
            print(f"\n{compared_table('held out, RMS of', compared.levels).text()}")
        if closed_loop:
            print(f"\n{compared_table('closed loop, RMS of', closed_loop).text()}")
        if diagnosis.causes and not diagnosis.gains:
            print(f"\n{WORSE}")
        print(f"\nnext: {self._next(diagnosis)}")
        if self.out is not None:
            places = [self.out / name for name in (REPORT, DOCUMENT, NOMINAL, EXTENDED, NEXT, COLUMNS)]
            words = ("report", "diagnosis", "fitted model", "model", "next motions", "corrected columns")
            for what, place in zip(words, places, strict=True):
                if place.exists():
                    print(f"{what}: {place}")
        if self.json is not None:
            print(f"numbers: {self.json}")

    def _next(self, diagnosis: Diagnosis) -> str:
        """Say what to do now, as a command where there is one."""
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


def _runs_again(nominal: Nominal, held_out: Sequence[Recording]) -> bool:
    """Tell whether closed loops can be simulated along recordings: they have set-points, and the servo is known."""
    return bool(held_out) and nominal.knows_servo and all(one.has("reference.position") for one in held_out)


def _say(look: FirstLook) -> None:
    """Soon and on stderr: what is printed is the verdict."""
    print(look.sentence, file=sys.stderr, flush=True)


def _lasting(info: dict[str, Any]) -> dict[str, Any]:
    """Collect what a diagnosis depends on, without options that only say where it goes and how it is made."""
    passing = ("out", "json", "threads")
    config = {name: value for name, value in info["config"].items() if name not in passing}
    return info | {"config": config}
