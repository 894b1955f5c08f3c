"""The batch simulation against the bare engine: as many simulations of the same model and lengths."""

import time

import numpy as np

from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.bare import bare_rate
from ffgym.studies import circle_references, thesis_laws
from scripts.bench.turns import Ratio

SPEEDS = (0.040, 0.100)
"""Circles at these speeds [m/s]; those at 10 mm/s take three quarters of the time, and show nothing else."""


def measure(arm: RigidArm, runs: list[Run], threads: int) -> tuple[float, float, float]:
    """Physics steps per second of the bare engine, of stepping alone and of all of `simulate`, one after the other."""
    lengths = np.array([(len(run.reference.t) - 1) * arm.robot.n_substeps for run in runs])
    bare = bare_rate(arm.robot, lengths, threads)
    times: list[float] = []
    began = time.perf_counter()
    simulate(runs, arm=arm, n_threads=threads, progress=lambda done, total: times.append(time.perf_counter()))
    steps = float(lengths.sum())
    return bare, steps / (times[-1] - times[0]), steps / (time.perf_counter() - began)


def simulation_ratios(robot: str, repeats: int, threads: int) -> list[Ratio]:
    """Circles with three feed-forward laws: stepping (set-points, engine, states taken out), and all of it.

    All of it has the feed-forward laws before and the recordings with TCP positions after it, too.
    """
    arm = RigidArm(load_robot(robot))
    references = circle_references(arm, speeds=SPEEDS).values()
    runs = [Run(reference=reference, law=law) for reference in references for law in thesis_laws(arm.robot)]
    measure(arm, runs, threads)  # warm up: caches, and memory that later runs find in place
    bare, stepping, whole = zip(*(measure(arm, runs, threads) for _ in range(repeats)), strict=True)
    return [
        Ratio("simulation, stepping / bare engine", stepping, bare, "physics/s", 0.85),
        Ratio("simulation, all of it / bare engine", whole, bare, "physics/s"),
    ]
