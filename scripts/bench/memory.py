"""Memory of many sub-environments and time of the import, each in a fresh process."""

import subprocess
import sys

import numpy as np

from scripts.bench.turns import Amount

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
for _ in range(50):
    env.step(np.zeros(env.action_space.shape, dtype=np.float32))
print(peak() - before)
"""

_IMPORT = "import time; began = time.perf_counter(); import ffgym; print(time.perf_counter() - began)"


def memory_of(name: str, n: int, wanted: float | None = None) -> Amount:
    """Peak of memory that `n` sub-environments add to the import: made, reset and stepped 50 times."""
    return Amount(f"memory of {n} x {name}", _number(_MEMORY, name, str(n)), "MiB", wanted)


def import_time(repeats: int) -> Amount:
    """Median time of `import ffgym`."""
    times = [_number(_IMPORT) for _ in range(repeats)]
    return Amount("import ffgym", float(np.median(times)), "s", wanted=1.0)


def _number(code: str, *arguments: str) -> float:
    """What a program prints."""
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    return float(done.stdout)
