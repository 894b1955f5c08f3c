"""`ffgym demo`: the circle test of the thesis with any feed-forward agents, and a diagnosis; as tables and as pages."""

from dataclasses import asdict, dataclass
from pathlib import Path

from ffgym.agents.catalogue import CATALOGUE
from ffgym.cli.laws import check_laws, make_laws, setting_for
from ffgym.cli.outputs import check_outputs, need_extra, provenance
from ffgym.core.files import write_json, write_text
from ffgym.diagnosis import Diagnosis, examine
from ffgym.diagnosis.document import diagnosis_document
from ffgym.diagnosis.nominal import EXAMPLE_ROBOT, example_logs
from ffgym.envs.machines import is_workcell, rig_of
from ffgym.paths import SPEEDS
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.simulation import Rig, SimulatedRig
from ffgym.studies import (
    CircleStudy,
    OneAxisStudy,
    circle_references,
    circle_study,
    one_axis_study,
    sine_references,
)

SEED = 0
"""Of the noise of a workcell's sensors, and of what a diagnosis draws."""


@dataclass(frozen=True)
class Demo:
    """Run the 36 circles with feed-forward agents, and diagnose the example logs; print the tables; write the pages."""

    agents: tuple[str, ...] = ("none", "lugre_static", "lugre_dynamic")
    """Names of docs/agents, model:<machine file>, or files of learned laws. Those that learn are trained first, on
    their standard motions."""
    parameters: Path | None = None
    """Parameter file for the agents' model of the robot; the simulated machine keeps its own numbers."""
    robot: str = "irb4600_60_205"
    """Built-in robot, a path to a description that ends in .toml, or workcell:<name or seed>."""
    report: Path = Path("report.html")
    """Report page to write; that of the diagnosis is beside it, its name ends in _diagnosis.html."""
    json: Path | None = None
    """Also write every number to this file."""
    positions: tuple[str, ...] = ()
    """Positions of the work area; none given is all."""
    speeds_mm_s: tuple[float, ...] = tuple(speed * 1e3 for speed in SPEEDS)
    """TCP speeds."""
    threads: int = 0
    """Threads of the simulation, 0 for all cores; results are the same at any number."""
    diagnosis: bool = True
    """End with a diagnosis of the example logs: those of a machine that has two faults."""

    def run(self) -> None:
        """Simulate, write, print; then diagnose."""
        need_extra("The demo", "matplotlib", "jinja2", "rich")
        places = {"--report": self.report, "--json": self.json}
        check_outputs(places | ({"--report, of the diagnosis": self._diagnosis_page} if self.diagnosis else {}))
        check_laws(self.agents, "--agents")
        from ffgym.report import format_one_axis, format_text, write_report

        circles = self._circles(rig_of(self.robot))
        one_axis = self._one_axis(load_robot("one_axis"))
        info = self.provenance(circles)
        page = write_report(self.report, circles, one_axis, info)  # files first: nobody may read what is printed
        rows = [asdict(cell) for cell in circles.cells]
        numbers = info | {"rows": rows, "one_axis": [asdict(result) for result in one_axis.results]}
        if self.json is not None:
            write_json(self.json, numbers)
        print(format_text(circles))
        print(format_one_axis(one_axis))
        print(f"report: {page}", flush=True)
        if self.diagnosis:
            numbers["diagnosis"] = diagnosis_document(self._diagnose())
            if self.json is not None:
                write_json(self.json, numbers)
        if self.json is not None:
            print(f"numbers: {self.json}")

    @property
    def _diagnosis_page(self) -> Path:
        return self.report.with_name(f"{self.report.stem}_diagnosis.html")

    def _diagnose(self) -> Diagnosis:
        """What the nominal model of the example logs lacks: a page, and the findings in print."""
        from ffgym.cli.progress import stages_bar
        from ffgym.report.diagnosis import DiagnosisReport, format_findings, render_diagnosis_page

        with stages_bar("diagnosing the example logs") as tell:
            examined = examine(load_robot(EXAMPLE_ROBOT), example_logs(), seed=SEED, report=tell)
        diagnosis = examined.diagnosis
        after = examined.after if diagnosis.causes else None
        page = DiagnosisReport(diagnosis=diagnosis, before=examined.before, after=after)
        write_text(self._diagnosis_page, render_diagnosis_page(page))
        print(f"\nDiagnosis of the example logs, recordings of a machine like {EXAMPLE_ROBOT}:")
        print(format_findings(diagnosis))
        print(f"diagnosis: {self._diagnosis_page}")
        return diagnosis

    def _circles(self, rig: Rig) -> CircleStudy:
        from ffgym.cli.progress import progress_bar

        positions, speeds = self.positions or None, [speed / 1e3 for speed in self.speeds_mm_s]
        references = [*circle_references(rig.arm, positions, speeds).values()]
        laws = make_laws(self.agents, setting_for(rig, references, self.parameters, self.threads))
        with progress_bar("simulating", "s") as progress:
            return circle_study(
                rig, laws=laws, positions=positions, speeds=speeds, seed=SEED, n_threads=self.threads, progress=progress
            )

    def _one_axis(self, robot: RobotDescription) -> OneAxisStudy:
        """The sine test with those agents that work on one axis; files and parameters are of another robot."""
        names = [name for name in self.agents if name in CATALOGUE and not CATALOGUE[name].needs_arm]
        rig = SimulatedRig(arm=RigidArm(robot))
        setting = setting_for(rig, [*sine_references(robot).values()], None, self.threads)
        return one_axis_study(robot, laws=make_laws(names or ["none"], setting))

    def provenance(self, study: CircleStudy) -> dict[str, object]:
        """Origin of the numbers of a study; the seed is null where nothing is random, as no sensor measures."""
        seed = SEED if is_workcell(self.robot) else None
        info = provenance("ffgym demo", self, study.robot.name, study.fingerprint, seed)
        info["config"]["positions"] = list(dict.fromkeys(cell.position for cell in study.cells))
        return info
