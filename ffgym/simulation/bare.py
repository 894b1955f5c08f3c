"""The engine alone, which everything that is built on it is measured against."""

import time

import numpy as np
from mujoco import batch

from ffgym.core.types import IntArray
from ffgym.robot import ModelOptions, RobotDescription, compile_model


def bare_rate(robot: RobotDescription, lengths: IntArray, threads: int) -> float:
    """Physics steps per second of `mujoco.batch` alone: as many simulations of the same lengths, held at rest.

    Args:
        robot: what is simulated.
        lengths: physics steps of each simulation.
        threads: of the engine, 0 for all cores.
    """
    engine = batch.Batch(compile_model(robot, ModelOptions(looks=False)), nsim=len(lengths), nthread=threads)
    engine.reset()
    began = time.perf_counter()
    done = 0
    for end in np.unique(lengths):
        engine.step(np.flatnonzero(lengths >= end), nstep=int(end - done))
        done = int(end)
    return float(lengths.sum()) / (time.perf_counter() - began)
