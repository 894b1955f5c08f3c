"""Cases that are measured in fresh processes: memory, imports, the first look of a diagnosis, and the tests."""

import os
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.nominal import EXAMPLE_ROBOT, example_logs
from ffgym.robot import load_robot
from ffgym.simulation.bare import bare_rate
from scripts.bench.turns import Amount, Rate, Ratio, rate_of, take_turns

REPOSITORY = Path(__file__).parents[2]

_MEMORY = """
import resource, sys
from pathlib import Path
import gymnasium as gym
import numpy as np
import ffgym.envs

def peak():
    status = Path("/proc/self/status")
    if status.exists():  # what getrusage tells begins at the size of the process that started this one
        return int(status.read_text().partition("VmHWM:")[2].split()[0]) / 2**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)

before = peak()
env = gym.make_vec(sys.argv[1], num_envs=int(sys.argv[2]))
env.reset(seed=0)
for _ in range(int(sys.argv[3])):
    env.step(np.zeros(env.action_space.shape, dtype=np.float32))
print(peak() - before)
"""

STEPS = 50
"""Steps behind a peak of memory."""

_IMPORT = "import time; began = time.perf_counter(); import ffgym; print(time.perf_counter() - began)"


def memory_of(name: str, n: int, wanted: float | None = None) -> Amount:
    """Peak of memory that `n` sub-environments add to the import: made, reset and stepped some times."""
    return Amount(f"memory of {n} x {name}", _print(_MEMORY, name, str(n), str(STEPS)), "MiB", wanted)


IMPORT = 1.0
"""Time that `import ffgym` may take at most [s]."""


def import_time(repeats: int) -> Amount:
    """Median time of `import ffgym`."""
    return Amount("import ffgym", float(np.median([_print(_IMPORT) for _ in range(repeats)])), "s", wanted=IMPORT)


def _print(code: str, *arguments: str) -> float:
    """Number that a program prints."""
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    return float(done.stdout)


# ---- what a user waits for, against the libraries that it needs and against the bare engine

LIBRARIES = "import numpy, scipy.linalg, scipy.optimize, scipy.signal, mujoco.batch"
"""Imports that no command can do without."""


def process_rate(*arguments: str) -> Rate:
    """Function that runs Python with these arguments and returns how often it could do so in a minute."""
    command = [sys.executable, *arguments]
    return rate_of(60, lambda: subprocess.run(command, capture_output=True, check=True, cwd=REPOSITORY))


def command_ratios(repeats: int) -> Iterator[Ratio]:
    """Measure what everybody waits for: the help of the command line, and a diagnosis up to its first look."""
    libraries = process_rate("-c", LIBRARIES)
    yield take_turns(
        "ffgym --help / imports", process_rate("-m", "ffgym", "--help"), libraries, repeats, unit="runs/min"
    )
    look = rate_of(60, first_look)
    yield take_turns("first look of a diagnosis / imports", look, libraries, repeats, unit="runs/min")
    robot, logs = load_robot(EXAMPLE_ROBOT), example_logs()
    steps = np.array([len(log) * log.dt / robot.servo.control_dt * robot.n_substeps for log in logs]).astype(int)
    engine = partial(bare_rate, robot, steps, 1)
    look = rate_of(float(steps.sum()), first_look)
    yield take_turns("first look of a diagnosis / bare engine", look, engine, repeats, unit="physics/s")


def first_look() -> None:
    """Start `ffgym diagnose` on the example logs, and stop it when it has said which effect stands out."""
    command = [sys.executable, "-m", "ffgym", "diagnose"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        seen = any(line.startswith("Preview") for line in process.stderr)
        process.kill()
    if not seen:
        raise FFGymError("ffgym diagnose ended without its line that starts with 'Preview', which is waited for.")


def collection_ratio(repeats: int) -> Iterator[Ratio]:
    """Measure how long pytest takes to find the tests: it imports all of them."""
    collect = process_rate("-m", "pytest", "--collect-only", "-p", "no:cacheprovider")
    title = "pytest --collect-only / imports"
    yield take_turns(title, collect, process_rate("-c", LIBRARIES), repeats, unit="runs/min")


SUITE = 10**9
"""Physics steps of one axis; the bare engine takes about as long for them as the tests take."""


def suite() -> Iterator[Ratio | Amount]:
    """Measure the processor time of the tests of `make test`, once, against the bare engine before and after them."""
    engine = partial(bare_rate, load_robot("one_axis"), np.full(64, 10_000), 1)
    before, began = engine(), os.times()
    done = subprocess.run([sys.executable, "-m", "pytest", "-p", "no:cacheprovider"], cwd=REPOSITORY)
    if done.returncode:
        raise FFGymError(f"pytest ended with {done.returncode}; mend the tests, then measure them.")
    ended = os.times()
    spent = ended.children_user + ended.children_system - began.children_user - began.children_system
    yield Ratio("all tests / bare engine", (SUITE / spent,), ((before + engine()) / 2,), "physics/s")
    yield Amount("all tests", spent, "s of a core")
