"""`ffgym leaderboard`: all agents on the same circles and plants; a table, result files, a page."""

import os
import time
from collections.abc import Sequence
from dataclasses import asdict, replace

import numpy as np

from ffgym.agents.adapters import ADAPTERS
from ffgym.agents.entrants import ENTRANTS, REGISTRY
from ffgym.cli.learning_options import Leaderboard
from ffgym.cli.outputs import claim_outputs, need_extra, print_places, provenance, write_numbers
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError, check_choice, check_whole
from ffgym.core.executors import Executor
from ffgym.core.files import write_text
from ffgym.leaderboard.adaptation.results import AdaptationResults, read_results
from ffgym.leaderboard.board import Board
from ffgym.leaderboard.comparison.samples import SELECTIONS, group_of
from ffgym.leaderboard.comparison.standings import standings
from ffgym.leaderboard.entrants import Entrant, Registry, find_entrants
from ffgym.leaderboard.plants import NOMINAL, ROBOT, draw_name, find_plant
from ffgym.leaderboard.presentation.adaptation import draw_adaptation
from ffgym.leaderboard.presentation.page import render_page
from ffgym.leaderboard.presentation.pictures import compute_traces
from ffgym.leaderboard.presentation.table import format_standings
from ffgym.leaderboard.results import Row
from ffgym.leaderboard.submission.process import isolation_note
from ffgym.leaderboard.tasks import SPLITS
from ffgym.robot import load_robot
from ffgym.simulation.bare import bare_rate

GROUPS = ("fixed", "all")
"""Groups of agents: laws that need no practice; everybody, those who practise on every task included."""
_BARE = 16
"""Simulations per core side by side when the bare engine is timed."""


def run(config: Leaderboard) -> None:
    """Check, run what is missing, write, print."""
    files = [os.path.realpath(name) for name in config.agents if name.endswith(".zip")]
    registry = replace(REGISTRY, files=tuple(dict.fromkeys(files)))
    entrants, plants, splits = _entrants(config, registry), _plants(config), _splits(config)
    check_whole("--seeds", config.seeds, low=1, high=1000)
    claim_outputs({"--json": config.json, "--page": config.page}, inputs=(config.adaptation, *files))
    beside = None if config.json is None else os.path.dirname(os.path.realpath(config.json))
    if config.out is not None and beside == os.path.realpath(config.out):
        raise FFGymError(f"--json {config.json}: lies among the result files of --out; choose another folder.")
    if config.page is not None:
        need_extra("The page of the leaderboard", "jinja2", "matplotlib")
    curve = None if config.adaptation is None else read_results(config.adaptation)
    if curve is not None and config.page is None:
        raise FFGymError(f"--adaptation {config.adaptation}: is shown on the page; say where that goes: --page FILE.")
    # evaluate rows that have no current result; others are read from their files
    executor = Executor(kind=config.executor, jobs=config.jobs, address=config.address)
    if registry.files and (note := isolation_note()) is not None:
        print(note)
    board = Board(registry=registry, folder=config.out)
    with board.hold():
        began = time.perf_counter()
        with progress_bar("leaderboard", "s of motion") as progress:
            simulated = board.run(entrants, plants, splits, config.seeds, executor, progress)
        took = time.perf_counter() - began
        if config.margins:
            with progress_bar("stability margins", "agents") as progress:
                board.measure_margins(entrants, config.seeds, executor, progress)
    rows, left_out = board.current()
    _tell(rows, plants, splits)
    for words in left_out:
        print(f"not shown: {words}")
    # cost of the evaluation over that of the bare engine
    bare = _bare(simulated) if simulated else 0.0
    if simulated:
        print(
            f"{simulated:.0f} s of motion in {took:.1f} s, {took / bare:.1f} times what the bare engine takes for "
            f"it on all cores ({bare:.1f} s)"
        )
    _write(config, rows, plants, {"wall_s": took, "bare_s": bare, "simulated_s": simulated}, curve)


def _entrants(config: Leaderboard, registry: Registry) -> list[Entrant]:
    """List the entrants; the zero action always takes part, as everything is told against it."""
    named = [name for name in config.agents if not name.endswith(".zip")]
    for name in named:
        check_choice("agent", name, [*GROUPS, *ENTRANTS])
    every = find_entrants(registry)
    names = {"none", *named, *(name for name in every if name not in ENTRANTS)}
    if "all" in names:
        names |= set(ENTRANTS)
    if "fixed" in names:
        names |= {name for name, entrant in ENTRANTS.items() if not entrant.slow and entrant.base is None}
    return [entrant for name, entrant in every.items() if name in names]


def _plants(config: Leaderboard) -> list[str]:
    check_whole("--draws", config.draws, low=0, high=10_000)
    names = dict.fromkeys([*config.plants, *map(draw_name, range(config.draws))])
    for name in names:
        find_plant(name)
    if not names:
        raise FFGymError(f"There is no plant to run on. Name some, e.g. --plants {NOMINAL}, or --draws 20.")
    return list(names)


def _splits(config: Leaderboard) -> list[str]:
    for split in config.splits:
        check_choice("split", split, [*SPLITS, "all"])
    if not config.splits:
        raise FFGymError(f"There are no circles to run. Name some of {', '.join(SPLITS)}, or all: --splits all.")
    return [split for split in SPLITS if split in config.splits or "all" in config.splits]


def _tell(rows: Sequence[Row], plants: Sequence[str], splits: Sequence[str]) -> None:
    """Print the standings of every group of plants that was run, on the largest selections of circles that were."""
    run = {name: set(own) for name, own in SELECTIONS.items() if set(own) <= set(splits)}
    largest = [name for name, own in run.items() if not any(own < other for other in run.values())]
    for group in dict.fromkeys(map(group_of, plants)):
        for selection in largest:
            print(format_standings(standings(rows, group, selection)), end="\n\n")


def _bare(simulated: float) -> float:
    """Seconds that the bare engine takes for so many simulated ones on all cores, measured now."""
    robot = load_robot(ROBOT)
    cores = os.cpu_count() or 1
    rate = bare_rate(robot, np.full(_BARE * cores, robot.n_substeps * 250), cores)  # a second of each
    return simulated / robot.servo.control_dt * robot.n_substeps / rate


def _write(
    config: Leaderboard,
    rows: Sequence[Row],
    plants: Sequence[str],
    times: dict[str, float],
    curve: AdaptationResults | None,
) -> None:
    """Write the page, and every circle with what it belongs to, as `ffgym demo` has them."""
    info = provenance("ffgym leaderboard", config, ROBOT, find_plant(plants[0]).fingerprint, None)
    every = dict.fromkeys([*plants, *(outcome.plant for row in rows for outcome in row.outcomes)])
    info["fingerprints"] = {plant: find_plant(plant).fingerprint for plant in every}
    if config.page is not None:
        titles = {adapter.name: adapter.title for adapter in ADAPTERS}
        picture = None if curve is None else draw_adaptation(curve, titles)
        page = render_page(rows, tracks=compute_traces(rows), provenance=info, adaptation=picture)
        write_text(config.page, page)
    circles = []
    for row in rows:
        for outcome in row.outcomes:
            shared = {
                "agent": row.name,
                "plant": outcome.plant,
                "plant_draw": outcome.plant_draw,
                "seed": outcome.seed,
                "track": row.track,
                "feedback": row.feedback,
                "channel": row.channel,
                "robot_seconds": outcome.robot_seconds,
                "env_steps": outcome.env_steps,
                "inference_us": outcome.inference_us,
                "fingerprint": outcome.fingerprint,
                "artefact": outcome.artefact,
            }
            circles += [shared | asdict(cell) for cell in outcome.cells]
    write_numbers(config, info | {"rows": circles, "times": times})
    print_places(page=config.page, numbers=config.json, results=config.out)
