"""Speed and memory of simulation, environments and agents, as ratios to the bare engine on the same model in one run.

python -m scripts.bench
"""

import os
import platform
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from ffgym.core.files import check_writable, write_json
from ffgym.core.provenance import versions
from ffgym.robot import compile_model, load_robot, physics_fingerprint
from scripts.bench.agents import decision_ratios
from scripts.bench.effects import effect_ratios
from scripts.bench.environments import (
    CIRCLES,
    against_the_engine,
    against_vectors_of_single_ones,
    beginnings,
)
from scripts.bench.memory import import_time, memory_of
from scripts.bench.simulation import simulation_ratios
from scripts.bench.training import training_ratios
from scripts.bench.turns import Amount, Ratio

Part = Literal["simulation", "effects", "environments", "vectors", "agents", "training", "memory"]


@dataclass(frozen=True)
class Config:
    """Benchmark of the batch simulation and of the environments; takes about a minute and a half on two cores."""

    robot: str = "irb4600_60_205"
    """Robot of the batch simulation: built-in, or a path to a description."""
    repeats: int = 9
    """Pairs of measurements of environments; both take turns, so that both see the same machine."""
    long_repeats: int = 5
    """Pairs of measurements that take seconds: batch simulation and training."""
    threads: int = 0
    """Threads of the engine, 0 for all cores."""
    parts: tuple[Part, ...] = get_args(Part)
    """What to measure."""
    json: Path | None = None
    """File for all numbers, with versions, physics fingerprint and machine."""


def main(config: Config) -> list[Ratio | Amount]:
    """Measure and print."""
    if config.json is not None:
        check_writable(config.json)
    print(f"{'':48} {'rate':>10} {'against':>10} {'':12} {'median':>6} (quartiles)")
    began, results = time.perf_counter(), []
    for result in measurements(config):
        print(result, flush=True)
        results.append(result)
    if any(isinstance(result, Ratio) and result.is_wide for result in results):
        print("WIDE: the machine was busy with something else; measure again")
    print(f"{time.perf_counter() - began:.0f} s on {os.cpu_count()} cores")
    if config.json is not None:
        write_json(config.json, _as_dict(config, results))
    return results


def measurements(config: Config) -> Iterator[Ratio | Amount]:
    """All that is asked for, one after the other."""
    if "simulation" in config.parts:
        yield from simulation_ratios(config.robot, config.long_repeats, config.threads)
    if "effects" in config.parts:
        yield from effect_ratios(config.robot, config.repeats, config.threads)
    if "environments" in config.parts:
        yield from against_the_engine(config.repeats, config.threads)
        yield from beginnings(config.threads)
    if "vectors" in config.parts:
        yield from against_vectors_of_single_ones(config.repeats, config.threads)
    if "agents" in config.parts:
        yield from decision_ratios((1, 64), config.long_repeats)
    if "training" in config.parts:
        learned = training_ratios(config.long_repeats)
        yield from learned
        if not learned:
            print("training: left out, needs stable-baselines3; pip install 'ffgym[rl]'")
    if "memory" in config.parts:
        yield memory_of(CIRCLES, 1024, wanted=300.0)
        yield memory_of("ffgym/JointMotion-v0", 1024)
        yield import_time(5)


def _as_dict(config: Config, results: list[Ratio | Amount]) -> dict[str, Any]:
    robot = load_robot(config.robot)
    return {
        "config": {**asdict(config), "json": str(config.json)},
        "versions": versions(),
        "physics_fingerprint": {robot.name: physics_fingerprint(compile_model(robot))},
        "machine": {"cores": os.cpu_count(), "system": platform.platform(), "processor": platform.machine()},
        "results": [result.as_dict() for result in results],
    }
