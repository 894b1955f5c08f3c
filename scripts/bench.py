"""Speed of the batch simulation, as a ratio to the bare engine on the same model in the same run.

python -m scripts.bench
"""

import time
from dataclasses import dataclass

import numpy as np
import tyro
from mujoco import batch

from ffgym.robot import ModelOptions, RigidArm, RobotDescription, compile_model, load_robot
from ffgym.simulation import Run, simulate
from ffgym.studies import circle_references, thesis_laws


@dataclass(frozen=True)
class Config:
    """Benchmark of the 36 circles with three feed-forward laws."""

    robot: str = "irb4600_60_205"
    """Built-in robot, or a path to a description."""
    repeats: int = 9
    """Pairs of measurements; the bare engine and the simulation take turns, so that both see the same machine."""
    threads: int = 0
    """Threads of the engine, 0 for all cores."""


@dataclass(frozen=True)
class Pair:
    """One measurement of each, in physics steps per second."""

    bare: float
    stepping: float
    """The simulation from its first step to its last: set-points, engine, states taken out."""
    whole: float
    """All of `simulate`: feed-forward laws before and recordings with TCP positions after it, too."""


def bare_rate(robot: RobotDescription, lengths: np.ndarray, threads: int) -> float:
    """Physics steps per second of `mujoco.batch` alone: as many simulations of the same lengths, held at rest."""
    engine = batch.Batch(compile_model(robot, ModelOptions(looks=False)), nsim=len(lengths), nthread=threads)
    engine.reset()
    began = time.perf_counter()
    done = 0
    for end in np.unique(lengths):
        engine.step(np.flatnonzero(lengths >= end), nstep=int(end - done))
        done = int(end)
    return float(lengths.sum()) / (time.perf_counter() - began)


def measure(robot: RobotDescription, arm: RigidArm, runs: list[Run], threads: int) -> Pair:
    """Time the bare engine, then the simulation of the same number of steps."""
    lengths = np.array([(len(run.reference.t) - 1) * robot.n_substeps for run in runs])
    bare = bare_rate(robot, lengths, threads)
    times: list[float] = []
    began = time.perf_counter()
    simulate(runs, arm=arm, n_threads=threads, progress=lambda done, total: times.append(time.perf_counter()))
    steps = float(lengths.sum())
    return Pair(bare=bare, stepping=steps / (times[-1] - times[0]), whole=steps / (time.perf_counter() - began))


def main(config: Config) -> list[Pair]:
    """Measure and print."""
    robot = load_robot(config.robot)
    arm = RigidArm(robot)
    runs = [
        Run(reference=reference, law=law) for reference in circle_references(arm).values() for law in thesis_laws(robot)
    ]
    measure(robot, arm, runs, config.threads)  # warm up: caches, and memory that later runs find in place
    pairs = [measure(robot, arm, runs, config.threads) for _ in range(config.repeats)]
    print(f"batch simulation: {len(runs)} runs, {sum(run.reference.duration for run in runs):.0f} s of robot time")
    print(f"{'bare engine':>14} {'stepping':>14} {'ratio':>6} {'whole':>14} {'ratio':>6}   (1000 physics steps/s)")
    for pair in pairs:
        print(
            f"{pair.bare / 1e3:14.0f} {pair.stepping / 1e3:14.0f} {pair.stepping / pair.bare:6.2f} "
            f"{pair.whole / 1e3:14.0f} {pair.whole / pair.bare:6.2f}"
        )
    print(f"median ratio to the bare engine: stepping {_spread(pairs, 'stepping')}, whole {_spread(pairs, 'whole')}")
    print("wanted: stepping at 0.85 or more; a wide spread means that the machine was busy with something else")
    return pairs


def _spread(pairs: list[Pair], kind: str) -> str:
    """Median and quartiles of a ratio."""
    low, median, high = np.quantile([getattr(pair, kind) / pair.bare for pair in pairs], [0.25, 0.5, 0.75])
    return f"{median:.2f} (quartiles {low:.2f} to {high:.2f})"


if __name__ == "__main__":
    main(tyro.cli(Config))
