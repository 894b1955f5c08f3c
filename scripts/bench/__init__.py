"""Speed and memory of simulation, environments and agents, as ratios to the bare engine on the same model in one run.

python -m scripts.bench
"""

import os
import platform
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal, get_args

from ffgym.core.errors import FFGymError
from ffgym.core.files import check_writable, write_json
from ffgym.core.provenance import versions
from ffgym.robot import compile_model, load_robot, physics_fingerprint
from scripts.bench.cases import parts
from scripts.bench.history import Entry, append, losses, read_history
from scripts.bench.turns import Amount, Ratio

Part = Literal["simulation", "effects", "environments", "vectors", "agents", "training", "memory", "commands", "tests"]


@dataclass(frozen=True)
class Config:
    """Benchmark of the batch simulation and of the environments; takes about three minutes on two cores."""

    robot: str = "irb4600_60_205"
    """Robot of the batch simulation: built-in, or a path to a description."""
    repeats: int = 9
    """Pairs of measurements of environments; both take turns, so that both see the same machine."""
    long_repeats: int = 5
    """Pairs of measurements that take seconds: batch simulation and training."""
    threads: int = 0
    """Threads of the engine, 0 for all cores."""
    parts: tuple[Part, ...] = get_args(Part)[:-1]
    """Parts to measure; `tests` runs all tests of `make test` one after the other, for most of an hour."""
    history: Path | None = None
    """File that a line is added to; ratios that lost more than 10 % beside its recent runs are told, and end in 1."""
    json: Path | None = None
    """File for all numbers, with versions, physics fingerprint and machine."""


def main(config: Config) -> list[Ratio | Amount]:
    """Measure and print.

    Raises:
        FFGymError: at the end, if a ratio has surely lost more than 10 % beside the runs of the history.
    """
    for path in (config.json, config.history):
        if path is not None:
            check_writable(path)
    history = read_history(config.history) if config.history is not None else []
    print(f"{'':48} {'rate':>10} {'against':>10} {'':12} {'median':>6} (quartiles)")
    began, results = time.perf_counter(), []
    measurements = parts(config.robot, config.repeats, config.long_repeats, config.threads)
    for measure in (measure for part, each in measurements.items() if part in config.parts for measure in each):
        for result in measure():
            print(result, flush=True)
            results.append(result)
    if any(isinstance(result, Ratio) and result.is_wide for result in results):
        print("WIDE: the machine was busy with something else; measure again")
    print(f"{time.perf_counter() - began:.0f} s on {os.cpu_count()} cores")
    if config.json is not None:
        robot = load_robot(config.robot)
        document = {
            "config": {**asdict(config), "json": str(config.json), "history": str(config.history)},
            "versions": versions(),
            "physics_fingerprint": {robot.name: physics_fingerprint(compile_model(robot))},
            "machine": {"cores": os.cpu_count(), "system": platform.platform(), "processor": platform.machine()},
            "results": [result.as_dict() for result in results],
        }
        write_json(config.json, document)
    if config.history is not None:
        entry = Entry.of(results)
        append(config.history, entry)
        lost = losses(entry, history)
        for change in lost:
            print(change)
        if not lost:
            print("no ratio lost more than 10 % beside recent runs")
        if any(change.sure for change in lost):
            raise FFGymError(
                "Ratios above have lost more than 10 %: find the commit, or say in the history's commit why."
            )
    return results
