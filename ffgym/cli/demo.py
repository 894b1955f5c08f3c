"""`ffgym demo`: the circle test of the thesis with any feed-forward agents, as tables and as a report page."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from agents.catalogue import CATALOGUE, Setting, entry_of, law_named
from agents.common.law_files import load_law
from ffgym.control import FeedForwardLaw
from ffgym.errors import FFGymError
from ffgym.files import check_writable, write_json
from ffgym.paths import SPEEDS
from ffgym.provenance import installed, versions
from ffgym.robot import RigidArm, RobotDescription, load_robot, with_parameters
from ffgym.studies import (
    CircleStudy,
    OneAxisStudy,
    circle_references,
    circle_study,
    one_axis_study,
    sine_references,
)


@dataclass(frozen=True)
class Demo:
    """Run the 36 circles with feed-forward agents; print the tables; write the report."""

    agents: tuple[str, ...] = ("none", "lugre_static", "lugre_dynamic")
    """Names of docs/agents, or files of learned laws. Those that learn are trained first, on their standard motions."""
    parameters: Path | None = None
    """Parameter file for the agents' model of the robot; the simulated machine keeps its own numbers."""
    robot: str = "irb4600_60_205"
    """Built-in robot, or a path to a description that ends in .toml."""
    report: Path = Path("report.html")
    """Report page to write."""
    json: Path | None = None
    """Also write every number to this file."""
    positions: tuple[str, ...] = ()
    """Positions of the work area; none given is all."""
    speeds_mm_s: tuple[float, ...] = tuple(speed * 1e3 for speed in SPEEDS)
    """TCP speeds."""
    threads: int = 0
    """Threads of the simulation, 0 for all cores; results are the same at any number."""

    def run(self) -> None:
        """Simulate, write, print."""
        _need_report_extra()
        check_writable(self.report)
        if self.json is not None:
            check_writable(self.json)
            if self.json.resolve() == self.report.resolve():
                raise FFGymError(f"--report and --json are both {self.json}; they need two files.")
        self._check_agents()
        from ffgym.report import format_one_axis, format_text, write_report

        circles = self._circles(load_robot(self.robot))
        one_axis = self._one_axis(load_robot("one_axis"))
        info = self.provenance(circles)
        page = write_report(self.report, circles, one_axis, info)  # files first: nobody may read what is printed
        if self.json is not None:
            rows = [asdict(cell) for cell in circles.cells]
            write_json(self.json, info | {"rows": rows, "one_axis": [asdict(result) for result in one_axis.results]})
        print(format_text(circles))
        print(format_one_axis(one_axis))
        print(f"report: {page}")
        if self.json is not None:
            print(f"numbers: {self.json}")

    def _check_agents(self) -> None:
        """Refuse wrong agents before any is made, as some take minutes to learn."""
        if not self.agents:
            raise FFGymError(
                f"There is no agent to run. Name some, e.g. --agents none elastic; {', '.join(CATALOGUE)}."
            )
        if len(set(self.agents)) < len(self.agents):
            raise FFGymError(f"Agents must have different names, got {' '.join(self.agents)}.")
        for name in self.agents:
            if name.endswith(".npz"):
                load_law(name)
            else:
                entry_of(name)

    def _circles(self, robot: RobotDescription) -> CircleStudy:
        from ffgym.cli.progress import progress_bar

        positions, speeds = self.positions or None, [speed / 1e3 for speed in self.speeds_mm_s]
        setting = Setting.of(robot, n_threads=self.threads)
        setting = replace(setting, references=[*circle_references(setting.arm, positions, speeds).values()])
        if self.parameters is not None:
            model = RigidArm(with_parameters(robot, self.parameters))
            setting = replace(setting, arm=model, controller=setting.arm, truth=robot)
        laws = self._laws(self.agents, setting)
        with progress_bar("simulating", "s") as progress:
            return circle_study(
                robot, laws=laws, positions=positions, speeds=speeds, n_threads=self.threads, progress=progress
            )

    def _one_axis(self, robot: RobotDescription) -> OneAxisStudy:
        """The sine test with those agents that work on one axis; files and parameters are of another robot."""
        names = [name for name in self.agents if name in CATALOGUE and not CATALOGUE[name].needs_arm]
        setting = replace(Setting.of(robot, n_threads=self.threads), references=[*sine_references(robot).values()])
        return one_axis_study(robot, laws=self._laws(names or ["none"], setting))

    def _laws(self, names: Sequence[str], setting: Setting) -> list[FeedForwardLaw]:
        from ffgym.cli.progress import progress_bar

        laws = []
        with progress_bar("making agents", "agents") as progress:
            for i, name in enumerate(names):
                progress(i, len(names))
                laws.append(law_named(name, setting))
        return laws

    def provenance(self, study: CircleStudy) -> dict[str, object]:
        """Origin of the numbers of a study. Nothing in it is random, so that the seed is null."""
        config = {name: str(value) if isinstance(value, Path) else value for name, value in asdict(self).items()}
        config["positions"] = list(dict.fromkeys(cell.position for cell in study.cells))
        return {
            "command": "ffgym demo",
            "config": config,
            "robot": study.robot.name,
            "seed": None,
            "versions": versions(),
            "physics_fingerprint": study.fingerprint,
        }


def _need_report_extra() -> None:
    missing = [name for name in ("matplotlib", "jinja2", "rich") if not installed(name)]
    if missing:
        raise FFGymError(f"The demo needs {', '.join(missing)}; pip install 'ffgym[cli,report]'.")
