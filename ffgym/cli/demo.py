"""`ffgym demo`: the circle test of the thesis on the built-in robot, as tables and as a report page."""

from dataclasses import asdict, dataclass
from pathlib import Path

from ffgym.errors import FFGymError
from ffgym.files import check_writable, write_json
from ffgym.paths import SPEEDS
from ffgym.provenance import installed, versions
from ffgym.robot import load_robot
from ffgym.studies import CircleStudy, circle_study, one_axis_study


@dataclass(frozen=True)
class Demo:
    """Run the 36 circles with no compensation, static and dynamic LuGre; print the tables; write the report."""

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
        from ffgym.cli.progress import progress_bar
        from ffgym.report import format_one_axis, format_text, write_report

        robot = load_robot(self.robot)
        with progress_bar("simulating", "s") as progress:
            circles = circle_study(
                robot,
                positions=self.positions or None,
                speeds=[speed / 1e3 for speed in self.speeds_mm_s],
                n_threads=self.threads,
                progress=progress,
            )
            one_axis = one_axis_study(load_robot("one_axis"))
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
