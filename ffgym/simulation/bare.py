"""The engine alone, which everything that is built on it is measured against."""

import time

import numpy as np
from mujoco import batch

from ffgym.core.types import IntArray
from ffgym.robot import ModelOptions, RobotDescription, compile_model


def bare_rate(robot: RobotDescription, lengths: IntArray, threads: int) -> float:
    """Physics steps per second of `mujoco.batch` alone: simulations of these lengths [physics steps], held at rest."""
    engine = batch.Batch(compile_model(robot, ModelOptions(looks=False)), nsim=len(lengths), nthread=threads)
    engine.reset()
    began = time.perf_counter()
    done = 0
    for end in np.unique(lengths):
        engine.step(np.flatnonzero(lengths >= end), nstep=int(end - done))
        done = int(end)
    return float(lengths.sum()) / (time.perf_counter() - began)
