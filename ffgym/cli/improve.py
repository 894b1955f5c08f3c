"""`ffgym improve`: what a diagnosis is worth in control: record, diagnose, extend, in rounds; then compare laws."""

from dataclasses import dataclass
from pathlib import Path

from ffgym.cli.outputs import check_outputs, need_extra, provenance
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError, check_whole
from ffgym.core.files import write_json, write_text
from ffgym.diagnosis import diagnose
from ffgym.diagnosis.search.search import MOST
from ffgym.envs.machines import is_workcell, rig_of
from ffgym.envs.workcell_circles import CONTROLLER
from ffgym.paths import SPEEDS
from ffgym.robot import load_robot
from ffgym.simulation.plant import Machine, load_machine
from ffgym.simulation.plant.machine_file import is_machine_file, origins_of, robot_reference
from ffgym.simulation.protocols import load_protocols

PAGE, NUMBERS = "improvement.html", "improvement.json"
"""What is written beside the rounds, with the page's pictures."""

DPI = 100
"""Pixels per inch of the pictures."""


@dataclass(frozen=True)
class Improve:
    """Record a machine, diagnose and extend its model, in rounds; compare feed-forward from it with that of others."""

    rig: str = "workcell:thesis"
    """The machine: workcell:<name or seed>, a machine file, or a built-in robot or description."""
    robot: str | None = None
    """Nominal model to begin with: a built-in robot, a description, or a machine file; none is what the machine's
    controller knows."""
    out: Path | None = None
    """Folder for recordings, diagnoses, models and the comparison; what is complete in it is not made again."""
    fit: bool = False
    """Fit all numbers of the model to the first recordings before it is diagnosed: for a machine that is far from its
    description in many at once."""
    protocols: tuple[str, ...] = ("diagnosis",)
    """What is recorded in each round, as for ffgym record; what a diagnosis proposes is added to the next round."""
    rounds: int = 4
    """At most; there are fewer where a diagnosis finds nothing to add."""
    most_causes: int = 3
    """Causes that are looked for in each round, 1 to 8. Time grows with their square, and what is left the next round
    finds beside numbers that were fitted again."""
    positions: tuple[str, ...] = ()
    """Positions of the circles that laws are compared on; none given is all but the first, where protocols draw
    theirs."""
    speeds_mm_s: tuple[float, ...] = tuple(speed * 1e3 for speed in SPEEDS)
    """Speeds of these circles."""
    radii_mm: tuple[float, ...] = (1.0, 5.0)
    """Radii of these circles; protocols draw circles of 3 mm."""
    seed: int = 0
    """Of the sensors' noise, and of what the diagnosis draws."""
    json: Path | None = None
    """File for all numbers; none is improvement.json in the folder."""
    threads: int = 0
    """Threads of the simulation, 0 for all cores; results are the same at any number."""

    def run(self) -> None:
        """Check, run, write, print."""
        folder = self._check()
        from ffgym.improvement import Plan, format_improvement, improve, improvement_figures, render_improvement
        from ffgym.report import save_figure

        rig = rig_of(self.rig)
        reference, nominal = self._nominal()
        origins = origins_of(nominal) if nominal is not None else ()
        plan = Plan(
            nominal=Machine(robot=load_robot(reference)) if nominal is None else load_machine(nominal),
            robot=reference,
            origins=origins,
            fit=self.fit,
            protocols=self.protocols,
            rounds=self.rounds,
            most_causes=self.most_causes,
            seed=self.seed,
            n_threads=self.threads,
        )
        result = improve(
            rig,
            plan,
            folder,
            diagnose=lambda machine, recordings, calibration, most: diagnose(
                machine, recordings, calibration=calibration, seed=self.seed, most=most
            ),
            stage=progress_bar,
            positions=self.positions or None,
            speeds=[speed / 1e3 for speed in self.speeds_mm_s],
            radii=[radius / 1e3 for radius in self.radii_mm],
        )
        info = provenance("ffgym improve", self, rig.robot.name, rig.fingerprint, self.seed)
        numbers = self.json or folder / NUMBERS
        write_text(folder / PAGE, render_improvement(result, info))
        write_json(numbers, info | result.document())
        for each in improvement_figures(result):
            save_figure(each.figure, folder / f"{each.name}.png", DPI)
        print(format_improvement(result))
        for what, place in (("report", folder / PAGE), ("model", result.rounds[-1].model), ("numbers", numbers)):
            print(f"{what}: {place}")

    def _check(self) -> Path:
        """Refuse what cannot be run or written; returns the folder."""
        need_extra("ffgym improve", "matplotlib", "jinja2")
        if self.out is None:
            raise FFGymError("Say where recordings, diagnoses and models go: --out FOLDER.")
        if self.out.exists() and not self.out.is_dir():
            raise FFGymError(f"--out {self.out}: is a file, must be a folder; choose another name.")
        check_whole("--most-causes", self.most_causes, low=1, high=MOST)
        for name in self.protocols:
            load_protocols(name)
        check_outputs({"--json": self.json}, inputs=(self.rig, self.robot, *self.protocols))
        return self.out

    def _nominal(self) -> tuple[str | Path, str | None]:
        """What files call the nominal robot, and the machine file of the nominal model if it is one."""
        if self.robot is not None:
            return (robot_reference(self.robot), self.robot) if is_machine_file(self.robot) else (self.robot, None)
        if is_workcell(self.rig):
            return CONTROLLER, None
        return (robot_reference(self.rig) if is_machine_file(self.rig) else self.rig), None
