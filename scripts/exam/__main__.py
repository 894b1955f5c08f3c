"""`python -m scripts.exam`: an exam of the diagnosis, by seed: hidden effects, and whether they are found."""

import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from ffgym.cli.main import run_command
from ffgym.cli.outputs import check_outputs, provenance
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError, check_choice, check_whole
from ffgym.core.files import write_json
from ffgym.report import check_figure, save_figure
from scripts.exam.exams import EXAMS, Exam, ExamName, hold
from scripts.exam.marks import Mark, read_marks, write_marks
from scripts.exam.paper import ROWS, Question
from scripts.exam.report import figures_text, misses_text, outcomes_figure, outcomes_text

_MOST = 10_000
"""Most questions of a row; more are surely a slip."""


@dataclass(frozen=True)
class HoldExam:
    """Hide effects in logs of a simulated robot, drawn by seed, diagnose them, and mark the answers."""

    seed: int = 7
    """Of the exam: what is hidden, where, how large, with which errors of calibration and noise."""
    exam: ExamName = "own"
    """own: logs of the built-in robot, simulated; independent: logs of drawn machines by a plant that shares no
    equation, integrator, controller or motion with the simulation."""
    rows: tuple[str, ...] = ()
    """Kinds of questions; none given is all: clean, single, foreign, outside, periodic, pair, poor, poor_clean,
    no_tracker, no_temperature; of the independent exam clean, single, outside."""
    cases: int | None = None
    """Questions of each kind; none given is a whole exam, some hundred."""
    out: Path | None = None
    """Folder for the marks, one line for each question, as soon as it is answered. Those in it are not asked again."""
    json: Path | None = None
    """Also write every figure and mark to this file."""
    figure: Path | None = None
    """Also draw the answers over loudness to this file: svg, png or pdf."""
    jobs: int = 1
    """Questions that are answered at the same time, each in a process of its own; marks are the same at any number."""

    def run(self) -> None:
        """Check, ask, mark, write, print."""
        check_whole("--seed", self.seed, low=0)
        check_whole("--jobs", self.jobs, low=1, high=1024)
        check_outputs({"--json": self.json, "--figure": self.figure})
        if self.figure is not None:
            check_figure(self.figure)
        exam, place = self._exam, self._place()
        head = exam.head(self.seed)
        questions = self._questions()
        kept = [] if place is None else read_marks(place, head)
        known = {(mark.row, mark.number) for mark in kept}
        asked = set(questions)
        marks = [mark for mark in kept if (mark.row, mark.number) in asked]
        todo = [question for question in questions if question not in known]
        with progress_bar("diagnosing", "logs") as progress:
            for mark in hold(todo, exam=exam, seed=self.seed, jobs=self.jobs, progress=progress):
                marks.append(mark)
                if place is not None:
                    kept.append(mark)
                    write_marks(place, head, kept)
        order = {question: k for k, question in enumerate(questions)}
        self._report(sorted(marks, key=lambda mark: order[mark.row, mark.number]))

    def _questions(self) -> list[Question]:
        """Questions that are asked."""
        counts = self._exam.counts
        rows = [check_choice("row of the exam", row, [one for one in ROWS if one in counts]) for row in self.rows]
        if self.cases is not None:
            check_whole("--cases", self.cases, low=1, high=_MOST)
        asked = [row for row in counts if row in rows or not rows]
        return [(row, k) for row in asked for k in range(self.cases or counts[row])]

    @property
    def _exam(self) -> Exam:
        return EXAMS[self.exam]

    def _place(self) -> Path | None:
        """File in which the marks are kept."""
        if self.out is None:
            return None
        try:
            self.out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FFGymError(f"{self.out}: cannot be made a folder: {error.strerror}; choose another place.") from error
        place = self.out / self._exam.file_of(self.seed)
        check_outputs({"--out": place})
        return place

    def _report(self, marks: Sequence[Mark]) -> None:
        lines = self._exam.table(marks)
        print("\n\n".join(part for part in (figures_text(lines), outcomes_text(marks), misses_text(marks)) if part))
        if self.figure is not None:
            print(f"\npicture: {save_figure(outcomes_figure(marks), self.figure)}")
        if self.json is not None:
            origin = provenance("python -m scripts.exam", self, self._exam.robot, self._exam.fingerprint, self.seed)
            figures = [asdict(line) for line in lines]
            write_json(self.json, origin | {"figures": figures, "marks": [asdict(mark) for mark in marks]})
            print(f"\nnumbers: {self.json}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Hold the exam with these arguments; the process' if None are given."""
    return run_command(HoldExam, "python -m scripts.exam", arguments)


if __name__ == "__main__":
    sys.exit(main())
