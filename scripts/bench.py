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
    repeats: int = 5
    """Pairs of measurements; the bare engine and the simulation take turns, so that both see the same machine."""
    threads: int = 0
    """Threads of the engine, 0 for all cores."""


@dataclass(frozen=True)
class Pair:
    """One measurement of each, in physics steps per second."""

    bare: float
    simulation: float
    whole: float
    """Recordings with TCP positions included."""


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
    finished: list[float] = []

    def note(done: float, total: float) -> None:
        if done >= total:
            finished.append(time.perf_counter())

    began = time.perf_counter()
    simulate(runs, arm=arm, n_threads=threads, progress=note)
    steps = float(lengths.sum())
    return Pair(bare=bare, simulation=steps / (finished[0] - began), whole=steps / (time.perf_counter() - began))


def main(config: Config) -> list[Pair]:
    """Measure and print."""
    robot = load_robot(config.robot)
    arm = RigidArm(robot)
    runs = [
        Run(reference=reference, law=law) for reference in circle_references(arm).values() for law in thesis_laws(robot)
    ]
    simulate(runs[:3], arm=arm, n_threads=config.threads)  # warm up
    pairs = [measure(robot, arm, runs, config.threads) for _ in range(config.repeats)]
    print(f"batch simulation: {len(runs)} runs, {sum(run.reference.duration for run in runs):.0f} s of robot time")
    print(f"{'bare engine':>16} {'simulation':>16} {'ratio':>7} {'+ recordings':>16} {'ratio':>7}   (1000 steps/s)")
    for pair in pairs:
        print(
            f"{pair.bare / 1e3:16.0f} {pair.simulation / 1e3:16.0f} {pair.simulation / pair.bare:7.2f} "
            f"{pair.whole / 1e3:16.0f} {pair.whole / pair.bare:7.2f}"
        )
    median = np.median([pair.simulation / pair.bare for pair in pairs])
    print(f"median ratio simulation / bare engine: {median:.2f} (wanted: >= 0.85)")
    return pairs


if __name__ == "__main__":
    main(tyro.cli(Config))
