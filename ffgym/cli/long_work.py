"""Time that a command takes: told before it begins, and asked about where a slip of a unit makes it hours."""

import os
import sys
from functools import cache
from typing import Any

import numpy as np

from ffgym.core.effort import Stage
from ffgym.core.errors import FFGymError
from ffgym.robot import load_robot
from ffgym.simulation.bare import bare_rate

ASKED = 3600.0
"""Time from which on a command asks [s]; chosen: the longest one of the documentation takes a third of it."""
TOLD = 30.0
"""Time from which on a command says how long it takes [s]; chosen."""

_ROBOT = "irb4600_60_205"
"""Robot with whose speed in the engine times are estimated."""
_BESIDE = 1.5
"""Time of a simulation, with planning, laws and recordings, over that of the engine alone; of few runs of circles."""
_STEPS = 0.05
"""Time of the steps of an environment that a second of motion has, beside the engine [s]; of few runs."""
_PICTURE = 0.01
"""Time to draw and write one picture [s]; of few runs without a graphics card."""
_MEASURED = 1.0
"""Motion that is simulated to measure the speed of this computer [s]."""


class LongWork:
    """Watch over one command: it adds up the motions that are planned, and asks once.

    Args:
        agreed: whatever it takes is agreed to before.
        passes: number of times that each planned motion is simulated.
        threads: threads of the simulation, 0 for all cores.
        beside: time that a second of motion takes beside its simulation [s], e.g. to draw it.
    """

    def __init__(self, *, agreed: bool, passes: int = 1, threads: int = 0, beside: float = 0.0) -> None:
        self._agreed, self._passes, self._threads, self._beside = agreed, passes, threads, beside
        self._planned = 0.0  # of motions [s]

    def __call__(self, seconds: float, stage: Stage) -> None:
        """Tell or ask before motions that take some seconds on the robot."""
        if stage == "plan":
            self._planned += seconds
        motion = seconds if stage == "run" else self._passes * max(seconds, self._planned)
        if motion * (1.0 + self._beside) < TOLD:  # a computer does not simulate slower than the robot moves
            return
        took = motion * (1.0 / rate(self._threads) + self._beside)
        if took > ASKED and not self._agreed:
            self._agreed = ask(motion, took)
        elif stage == "run" and took > TOLD:
            print(f"ffgym: {write_time(motion)} of motion, about {write_time(took)}", file=sys.stderr, flush=True)


def ask(motion: float, took: float) -> bool:
    """Ask on a terminal whether to go on; returns True.

    Raises:
        FFGymError: if the answer is no, or nobody can be asked.
    """
    what = f"{write_time(motion)} of motion would take about {write_time(took)} to simulate on this computer"
    if sys.stdin is not None and sys.stdin.isatty() and sys.stderr.isatty():
        print(f"ffgym: {what}. Go on? [y/N] ", end="", file=sys.stderr, flush=True)
        if sys.stdin.readline().strip().lower() in ("y", "yes"):
            return True
        raise FFGymError("Not begun. Check units of speeds and times, or choose fewer motions.")
    raise FFGymError(
        f"{what[0].upper()}{what[1:]}. Check units of speeds and times, or choose fewer motions; --yes begins it "
        "all the same."
    )


@cache
def rate(threads: int) -> float:
    """Measure the seconds of motion that this computer simulates in a second, on so many threads."""
    robot = load_robot(_ROBOT)
    threads = threads or os.cpu_count() or 1
    steps = round(_MEASURED / robot.servo.control_dt) * robot.n_substeps
    each = bare_rate(robot, np.full(threads, steps), threads)
    return each * robot.servo.control_dt / robot.n_substeps / _BESIDE


def write_time(seconds: float) -> str:
    """Write a time with two digits in the unit that suits it."""
    for unit, size, most in (("s", 1.0, 100.0), ("min", 60.0, 100 * 60.0), ("h", 3600.0, 72 * 3600.0)):
        if seconds < most:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds / 86400:.2g} days" if seconds < 8.64e6 else f"{seconds / 86400:.0f} days"


def watch_over(options: Any) -> LongWork:
    """Make the watch over a command whose options have `yes`."""
    agents = getattr(options, "agents", ()) or getattr(options, "feedforward", ())
    passes = len(agents) if isinstance(agents, tuple) else 1
    # an episode is run step by step in one thread, and drawn
    is_film = getattr(options, "playback", 0.0) > 0
    beside = _STEPS + _PICTURE * options.fps / options.playback if is_film else 0.0
    threads = 1 if is_film else getattr(options, "threads", 0)
    return LongWork(agreed=options.yes, passes=max(passes, 1), threads=threads, beside=beside)
