"""`python -m scripts.exam`: an exam of the diagnosis, by seed: hidden effects, and whether they are found."""

import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from ffgym.cli.main import run_command
from ffgym.cli.outputs import claim_outputs, given_options, provenance
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError, check_whole
from ffgym.core.files import write_json
from ffgym.report import check_figure, save_figure
from scripts.exam.bench import RECORD_DT, RESOLVER_NOISE
from scripts.exam.exams import EXAMS, Exam, ExamName, hold
from scripts.exam.marks import Mark, read_marks, write_marks
from scripts.exam.sizes import CASES, STEPS, SizesExam

_MOST = 10_000
"""Most questions of a row; more are surely a slip."""

_OF_ROBOT = ("protocol", "resolver_noise", "torque_noise", "tracker_noise", "record_dt_ms", "effects", "steps")
"""Options that say something of a robot of the user."""


@dataclass(frozen=True)
class HoldExam:
    """Hide effects in logs of a simulated robot, drawn by seed, diagnose them, and mark the answers."""

    seed: int = 7
    """Seed of the exam: what is hidden, where, how large, with which errors of calibration and noise."""
    exam: ExamName = "own"
    """own: logs of the built-in robot, simulated; independent: logs of drawn machines by a plant that shares no
    equation, integrator, controller or motion with the simulation."""
    rows: tuple[str, ...] = ()
    """Kinds of questions; none given is all: clean, single, foreign, outside, periodic, pair, poor, poor_clean,
    no_tracker, no_temperature; of the independent exam clean, single, outside, arm, arm_blind."""
    cases: int | None = None
    """Questions of each kind; none given is a whole exam, some hundred."""
    robot: str | None = None
    """Built-in robot, or path of its description, on which single effects are hidden at several sizes: from what size
    on would a diagnosis find each of them on this machine?"""
    protocol: str | None = None
    """Motions of that robot: name or file (docs/protocols.md); none given is the protocol diagnosis."""
    resolver_noise: float = RESOLVER_NOISE
    """Standard deviation of its measured motor angles, motor side [rad]."""
    torque_noise: tuple[float, ...] = ()
    """The same of its measured torques, motor side [N m], one for each joint or one for all; none given is 3 % of the
    Coulomb torque."""
    tracker_noise: float | None = None
    """The same of each tracked coordinate of its tool [m]; none given is that of the description."""
    record_dt_ms: float = RECORD_DT * 1e3
    """Time between the rows of its logs."""
    effects: tuple[str, ...] = ()
    """Effects that are hidden in it; none given is all that the log can show."""
    steps: int = STEPS
    """Sizes of each effect. With --robot, --cases is how often each effect is drawn, on one joint after the other."""
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
        claim_outputs({"--json": self.json, "--figure": self.figure})
        if self.figure is not None:
            check_figure(self.figure)
        if self.cases is not None:
            check_whole("--cases", self.cases, low=1, high=_MOST)
        exam = self._exam()
        questions = exam.questions(self.rows, self.cases)
        place, head = self._place(exam), exam.head(self.seed)
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
        self._report(exam, sorted(marks, key=lambda mark: order[mark.row, mark.number]))

    def _exam(self) -> Exam:
        """The exam that the options describe."""
        if self.robot is None:
            if given := given_options(self, _OF_ROBOT):
                raise FFGymError(f"{given[0]} has no effect without --robot. Leave it out, or name a robot.")
            return EXAMS[self.exam]
        if given := given_options(self, ("exam", "rows")):
            raise FFGymError(
                f"{given[0]} has no effect with --robot, whose questions are sizes. Leave one of them out."
            )
        return SizesExam(
            robot=self.robot,
            protocol=self.protocol,
            resolver_noise=self.resolver_noise,
            torque_noise=self.torque_noise,
            tracker_noise=self.tracker_noise,
            record_dt=self.record_dt_ms / 1e3,
            effects=self.effects,
            cases=self.cases or CASES,
            steps=self.steps,
        )

    def _place(self, exam: Exam) -> Path | None:
        """File in which the marks are kept."""
        if self.out is None:
            return None
        try:
            self.out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FFGymError(f"{self.out}: cannot be made a folder: {error.strerror}; choose another place.") from error
        place = self.out / exam.file_of(self.seed)
        claim_outputs({"--out": place})
        return place

    def _report(self, exam: Exam, marks: Sequence[Mark]) -> None:
        print("\n\n".join(part for part in exam.texts(marks) if part))
        if self.figure is not None:
            print(f"\npicture: {save_figure(exam.picture(marks), self.figure)}")
        if self.json is not None:
            origin = provenance("python -m scripts.exam", self, exam.robot, exam.fingerprint, self.seed)
            write_json(self.json, origin | exam.document(marks) | {"marks": [asdict(mark) for mark in marks]})
            print(f"\nnumbers: {self.json}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Hold the exam with these arguments; the process' if None are given."""
    return run_command(HoldExam, "python -m scripts.exam", arguments)


if __name__ == "__main__":
    sys.exit(main())
