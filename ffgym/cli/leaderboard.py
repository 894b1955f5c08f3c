"""`ffgym leaderboard`: all agents on the same circles and plants; a table, result files, a page."""

import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ffgym.agents.entrants import ENTRANTS, REGISTRY
from ffgym.cli.outputs import check_outputs, need_extra, provenance
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError, check_choice, check_whole
from ffgym.core.executors import Executor
from ffgym.core.files import write_json, write_text
from ffgym.leaderboard.board import Board
from ffgym.leaderboard.entrants import Entrant, Registry, entrants_in
from ffgym.leaderboard.plants import NOMINAL, ROBOT, THESIS_WORKCELL, draw_name, plant_named
from ffgym.leaderboard.results import Row
from ffgym.leaderboard.submission.process import isolation_note
from ffgym.leaderboard.tasks import SPLITS, THESIS
from ffgym.robot import load_robot
from ffgym.simulation.bare import bare_rate

GROUPS = ("fixed", "all")
"""Groups of agents: laws that need no practice; everybody, those who practise on every task included."""
_BARE = 16
"""Simulations per core side by side when the bare engine is timed."""


@dataclass(frozen=True)
class Leaderboard:
    """Run agents on the circles of the thesis and on held-out ones; print standings; write results and a page."""

    agents: tuple[str, ...] = ("fixed",)
    """Names; or fixed, all laws but those that practise on every task first; or all; and submissions, files .zip."""
    plants: tuple[str, ...] = (NOMINAL, THESIS_WORKCELL)
    """nominal, workcell:<name or seed>, draw:<number>."""
    draws: int = 0
    """Drawn plants beside these: draw:0 to one less than this number."""
    splits: tuple[str, ...] = THESIS
    """Circles: train and positions are the 36 of the thesis; radii and speeds are others; or all."""
    seeds: int = 1
    """Trainings of each row that a seed changes; five ship."""
    out: Path | None = None
    """Folder of result files, one per row. What is complete in it is not run again."""
    page: Path | None = None
    """Page to write, one file with tables, pictures and cards."""
    json: Path | None = None
    """Also write every circle to this file."""
    executor: Literal["local", "ray"] = "local"
    """Where the work is done: on this machine, or on a Ray cluster."""
    address: str | None = None
    """Of a running Ray cluster; none begins one on this machine."""
    jobs: int = 0
    """Processes, or pieces that a cluster works on at once; 0 is one per core. Results are the same at any number."""

    def run(self) -> None:
        """Check, run what is missing, write, print."""
        registry = self._registry()
        entrants, plants, splits = self._entrants(registry), self._plants(), self._splits()
        check_whole("--seeds", self.seeds, low=1, high=1000)
        check_outputs({"--json": self.json, "--page": self.page})
        if self.json is not None and self.out is not None and self.json.resolve().parent == self.out.resolve():
            raise FFGymError(f"--json {self.json}: lies among the result files of --out; choose another folder.")
        if self.page is not None:
            need_extra("The page of the leaderboard", "jinja2", "matplotlib")
        executor = Executor(kind=self.executor, jobs=self.jobs, address=self.address)
        if registry.files and (note := isolation_note()) is not None:
            print(note)
        board = Board(registry=registry, folder=self.out)
        began = time.perf_counter()
        with progress_bar("leaderboard", "s of motion") as progress:
            simulated = board.run(entrants, plants, splits, self.seeds, executor, progress)
        took = time.perf_counter() - began
        rows, left_out = board.current()
        self._tell(rows, plants, splits)
        for words in left_out:
            print(f"not shown: {words}")
        bare = self._bare(simulated) if simulated else 0.0
        if simulated:
            print(
                f"{simulated:.0f} s of motion in {took:.1f} s, {took / bare:.1f} times what the bare engine takes for "
                f"it on all cores ({bare:.1f} s)"
            )
        self._write(rows, plants, {"wall_s": took, "bare_s": bare, "simulated_s": simulated})

    def _registry(self) -> Registry:
        """Where entrants are, those of submissions among them."""
        files = (Path(name).resolve() for name in self.agents if _is_submission(name))
        return replace(REGISTRY, files=tuple(map(str, dict.fromkeys(files))))

    def _entrants(self, registry: Registry) -> list[Entrant]:
        """Who takes part; the zero action always does, as everything is told against it."""
        named = [name for name in self.agents if not _is_submission(name)]
        for name in named:
            check_choice("agent", name, [*GROUPS, *ENTRANTS])
        every = entrants_in(registry)
        names = {"none", *named, *(name for name in every if name not in ENTRANTS)}
        if "all" in names:
            names |= set(ENTRANTS)
        if "fixed" in names:
            names |= {name for name, entrant in ENTRANTS.items() if not entrant.slow and entrant.base is None}
        return [entrant for name, entrant in every.items() if name in names]

    def _plants(self) -> list[str]:
        check_whole("--draws", self.draws, low=0, high=10_000)
        names = dict.fromkeys([*self.plants, *map(draw_name, range(self.draws))])
        for name in names:
            plant_named(name)
        if not names:
            raise FFGymError(f"There is no plant to run on. Name some, e.g. --plants {NOMINAL}, or --draws 20.")
        return list(names)

    def _splits(self) -> list[str]:
        for split in self.splits:
            check_choice("split", split, [*SPLITS, "all"])
        if not self.splits:
            raise FFGymError(f"There are no circles to run. Name some of {', '.join(SPLITS)}, or all: --splits all.")
        return [split for split in SPLITS if split in self.splits or "all" in self.splits]

    def _tell(self, rows: Sequence[Row], plants: Sequence[str], splits: Sequence[str]) -> None:
        """Print the standings of every group of plants that was run, on the largest selections of circles that were."""
        from ffgym.leaderboard.comparison.samples import SELECTIONS, group_of
        from ffgym.leaderboard.comparison.standings import standings
        from ffgym.leaderboard.presentation.table import format_standings

        run = {name: set(own) for name, own in SELECTIONS.items() if set(own) <= set(splits)}
        largest = [name for name, own in run.items() if not any(own < other for other in run.values())]
        for group in dict.fromkeys(map(group_of, plants)):
            for selection in largest:
                print(format_standings(standings(rows, group, selection)), end="\n\n")

    def _bare(self, simulated: float) -> float:
        """Seconds that the bare engine takes for so many simulated ones on all cores, measured now."""
        robot = load_robot(ROBOT)
        cores = os.cpu_count() or 1
        rate = bare_rate(robot, np.full(_BARE * cores, robot.n_substeps * 250), cores)  # a second of each
        return simulated / robot.servo.control_dt * robot.n_substeps / rate

    def _write(self, rows: Sequence[Row], plants: Sequence[str], times: dict[str, float]) -> None:
        info = provenance("ffgym leaderboard", self, ROBOT, plant_named(plants[0]).fingerprint, None)
        every = dict.fromkeys([*plants, *(outcome.plant for row in rows for outcome in row.outcomes)])
        info["fingerprints"] = {plant: plant_named(plant).fingerprint for plant in every}
        if self.page is not None:
            from ffgym.leaderboard.presentation.page import render_page
            from ffgym.leaderboard.presentation.pictures import paths_of

            write_text(self.page, render_page(rows, tracks=paths_of(rows), provenance=info))
            print(f"page: {self.page}")
        if self.json is not None:
            write_json(self.json, info | {"rows": list(_flat(rows)), "times": times})
            print(f"numbers: {self.json}")
        if self.out is not None:
            print(f"results: {self.out}")


def _is_submission(name: str) -> bool:
    return name.endswith(".zip")


def _flat(rows: Sequence[Row]) -> Iterator[dict[str, Any]]:
    """Every circle with what it belongs to, as `ffgym demo` has them."""
    for row in rows:
        for outcome in row.outcomes:
            shared = {
                "agent": row.name,
                "plant": outcome.plant,
                "plant_draw": outcome.plant_draw,
                "seed": outcome.seed,
                "track": row.track,
                "robot_seconds": outcome.robot_seconds,
                "env_steps": outcome.env_steps,
                "inference_us": outcome.inference_us,
                "fingerprint": outcome.fingerprint,
                "artefact": outcome.artefact,
            }
            for cell in outcome.cells:
                yield shared | asdict(cell)
