"""`ffgym log check`: what logs are good for, before anything is concluded from them."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, get_args

import tyro

from ffgym.cli.descriptions import described_robot
from ffgym.cli.outputs import check_outputs, need_extra, provenance
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError
from ffgym.core.files import write_json, write_text
from ffgym.logs import read_logs
from ffgym.logs.quality import QualityReport, check_quality
from ffgym.logs.quality.check import Overall
from ffgym.logs.quality.wiring import Mistake, find_wiring
from ffgym.recordings.io import recording_files
from ffgym.robot import RobotDescription, load_draft
from ffgym.simulation.plant.machine_file import is_machine_file


@dataclass(frozen=True)
class Check:
    """Judge clock, columns, units, torque, tracker and coverage of logs; fails if one is insufficient."""

    logs: tyro.conf.Positional[tuple[str, ...]]
    """Recordings (.npz, .csv) or folders of them; files of other tools with --columns."""
    robot: str | None = None
    """Built-in robot, or a description (.toml); without it, or if it lacks entries, nothing is judged that hangs on
    masses, ranges or limits."""
    columns: str | None = None
    """Column map for files of other tools: a built-in name, or a file that ends in .toml."""
    needs: tuple[str, ...] = ()
    """Uses that the logs must serve, e.g. friction tracker temperature; see docs/quality.md."""
    figures: bool = False
    """Also print every figure beside its limit, and what was not judged."""
    report: Path | None = None
    """Page with a picture to write, .html, in one file that can be sent."""
    json: Path | None = None
    """Also write every finding to this file."""

    def run(self) -> None:
        """Check, read, judge, write, print.

        Raises:
            FFGymError: at the end, if a log is insufficient.
        """
        if not self.logs:
            raise FFGymError("There is nothing to check: name at least one log.")
        if self.report is not None:
            need_extra("The report", "matplotlib", "jinja2")
        inputs = (*self.logs, self.robot, self.columns)
        check_outputs({"--report": self.report, "--json": self.json}, inputs=inputs)
        reports, wiring = self._judged()
        info = provenance("ffgym log check", self, self.robot or "", None, None)
        self._write(reports, wiring, info)
        from ffgym.report.quality import format_quality
        from ffgym.report.table import filled

        for name, report in reports:
            print(f"{name}: {format_quality(report, figures=self.figures)}")
        if len(reports) > 1:
            print(_counts([report.verdict for _, report in reports]))
        for mistake in wiring:
            print(filled(f"wiring of all logs: {mistake.message}"))
        for what, place in (("report", self.report), ("numbers", self.json)):
            if place is not None:
                print(f"{what}: {place}")
        bad = [name for name, report in reports if report.verdict == "insufficient"]
        if wiring and not bad:
            raise FFGymError("Columns are not what they are called, see above; `ffgym diagnose --out` writes a map.")
        if bad:
            raise FFGymError(f"Insufficient: {', '.join(bad)}; see above what is refused, and the way out.")

    def _judged(self) -> tuple[list[tuple[str, QualityReport]], tuple[Mistake, ...]]:
        """File names, each with the report of a motion in it; and what is wired wrongly in all logs together."""
        whose, robot = self._described()
        reports, read = [], []
        with progress_bar("checking", "logs") as progress:
            files = [file for path in self.logs for file in self._files(path)]
            for done, path in enumerate(files):
                progress(done, len(files))
                recordings = read_logs(path, self.columns, robot=whose if self.columns else None)
                reports += [(path, check_quality(recording, robot, self.needs)) for recording in recordings]
                read += recordings if robot is not None else []
        wiring = find_wiring(read, robot).mistakes if robot is not None and len(read) > 1 else ()
        return reports, wiring

    def _described(self) -> tuple[RobotDescription | None, RobotDescription | None]:
        """The robot that logs are of, and the one to judge them by: None if its description lacks entries."""
        if self.robot is None:
            return None, None
        known = self.robot.endswith(".toml") and not is_machine_file(self.robot)
        if known and (draft := load_draft(self.robot)).missing:
            lacking = f"{draft.missing[0]} and {len(draft.missing) - 1} more" if draft.missing[1:] else draft.missing[0]
            print(f"note: {self.robot} lacks {lacking}; nothing is judged that hangs on masses, ranges or limits")
            return draft.description_for("kinematics", "drive.gear_ratio"), None
        robot = described_robot(self.robot)
        return robot, robot

    def _files(self, path: str) -> list[str]:
        """The log, or the recordings in a folder; with a column map a folder may be one log."""
        if self.columns is None and Path(path).is_dir():
            return [str(file) for file in recording_files(path)]
        return [path]

    def _write(
        self, reports: list[tuple[str, QualityReport]], wiring: tuple[Mistake, ...], info: dict[str, Any]
    ) -> None:
        """Files first: nobody may read what is printed."""
        if self.report is not None:
            from ffgym.report.quality import render_quality_page

            write_text(self.report, render_quality_page(reports, info))
        if self.json is not None:
            logs = [{"file": name} | report.numbers() for name, report in reports]
            write_json(self.json, info | {"logs": logs, "wiring": [asdict(mistake) for mistake in wiring]})


def _counts(verdicts: list[Overall]) -> str:
    """How many logs have which verdict."""
    counts = [f"{verdicts.count(verdict)} {verdict}" for verdict in get_args(Overall)]
    return f"{len(verdicts)} logs: {', '.join(counts)}."
