"""Plan of a trial: runs with and without the correction, in pairs whose order is drawn by chance."""

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ffgym.core.errors import FFGymError, check_whole
from ffgym.deployment.trial.program import TrialProgram

MOST_RUNS = 10_000
"""Largest number of runs of a plan; more are surely a slip."""


@dataclass(frozen=True, kw_only=True)
class PlannedRun:
    """One run of the machine, in the order of the plan."""

    number: int
    """Place in the order, from 1 on."""
    log: str
    """Name that its log is to have, without suffix."""
    program: str
    """Name of its program."""
    corrected: bool
    """True if it runs with the correction."""
    pair: int
    """Number of its pair among those of its program, from 1 on; 0 for a run that warms the machine up."""

    @property
    def is_warm_up(self) -> bool:
        """True if the run is not scored."""
        return self.pair == 0

    @property
    def what(self) -> str:
        """Words for what the operator switches."""
        return "with correction" if self.corrected else "without"


@dataclass(frozen=True, kw_only=True, eq=False)
class TrialPlan:
    """Randomised on/off experiment: all of it follows from its programs, numbers and seed."""

    robot: str
    """Name of the robot, or path to its description, as its controller knows it."""
    programs: tuple[TrialProgram, ...]
    pairs: int
    """Pairs of runs of each program."""
    warm_up: int
    """Runs before the first pair, without the correction, which are not scored."""
    laps: int
    """Passes of the program in each run. Of several the first is not scored: there the machine settles."""
    seed: int
    """Seed of the order."""

    @cached_property
    def runs(self) -> tuple[PlannedRun, ...]:
        """All runs in their order."""
        return _draw_runs([program.name for program in self.programs], self.pairs, self.warm_up, self.seed)

    @property
    def seconds(self) -> float:
        """Time in motion [s], all laps of all runs."""
        times = {program.name: program.duration for program in self.programs}
        return self.laps * sum(times[run.program] for run in self.runs)

    def program(self, name: str) -> TrialProgram:
        """Find the program of that name, which is one of the plan."""
        return next(program for program in self.programs if program.name == name)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of everything that a result hangs on: names of logs, their order, and the programs' set-points."""
        total = hashlib.sha256(f"{self.robot} {self.laps} {self.seed}".encode())
        for run in self.runs:
            total.update(repr(run).encode())
        for program in self.programs:
            total.update(program.name.encode() + program.recording.joint_array("reference.position").tobytes())
        return total.hexdigest()


def plan_trial(
    robot: str, programs: Sequence[TrialProgram], *, pairs: int, seed: int, warm_up: int = 2, laps: int = 1
) -> TrialPlan:
    """Plan a trial.

    Each round has one pair of runs of every program, in an order of programs and within pairs that is drawn anew, so
    that a machine that warms up or drifts does so for both sides of every comparison.

    Args:
        robot: name of the robot, or path to its description.
        programs: one or more, with different names.
        pairs: pairs of runs of each program.
        seed: whole number from 0 on; commit to it before the first run.
        warm_up: runs before the first pair, which are not scored.
        laps: passes of the program in each run.

    Raises:
        FFGymError: if a number is out of range, two programs share a name, or one cannot be repeated.
    """
    names = [_bare(program.name).lower() for program in programs]
    if not names or len(set(names)) < len(names):
        raise FFGymError(f"Programs of a trial need different names, and there must be one at least; got {names}.")
    pairs = check_whole("pairs of runs", pairs, low=1)
    warm_up = check_whole("runs to warm up", warm_up, low=0)
    if 2 * pairs * len(names) + warm_up > MOST_RUNS:
        raise FFGymError(f"{pairs} pairs of {len(names)} programs are more than {MOST_RUNS} runs; take fewer.")
    laps = check_whole("laps", laps, low=1, high=100)
    for program in programs:
        _check_program(program, laps)
    return TrialPlan(
        robot=robot,
        programs=tuple(programs),
        pairs=pairs,
        warm_up=warm_up,
        laps=laps,
        seed=check_whole("seed", seed, low=0),
    )


def _check_program(program: TrialProgram, laps: int) -> None:
    """Check that a program moves, and can be run so many times in a row."""
    if laps > 1 and not program.is_closed:
        raise FFGymError(
            f"Program {program.name!r} does not end where it begins, so that laps cannot follow each other. Take one "
            f"lap, or add a move back to its start."
        )
    if not program.scored.any():
        raise FFGymError(f"Program {program.name!r} is all standstill, so that it has no error to score.")


def _draw_runs(names: Sequence[str], pairs: int, warm_up: int, seed: int) -> tuple[PlannedRun, ...]:
    """Draw the order of all runs."""
    rng = np.random.default_rng(seed)
    entries = [(names[k % len(names)], False, 0) for k in range(warm_up)]
    # rounds of one pair of each program; only `random` is drawn from, whose stream numpy keeps
    for pair in range(1, pairs + 1):
        order, coins = np.argsort(rng.random(len(names))), rng.random(len(names)) < 0.5
        for k in order:
            first = bool(coins[k])
            entries += [(names[k], first, pair), (names[k], not first, pair)]
    digits = len(str(len(entries)))
    return tuple(
        PlannedRun(
            number=number,
            log=f"{number:0{digits}d}_{_bare(name)}_{'warm_up' if pair == 0 else 'on' if corrected else 'off'}",
            program=name,
            corrected=corrected,
            pair=pair,
        )
        for number, (name, corrected, pair) in enumerate(entries, start=1)
    )


def _bare(name: str) -> str:
    """Name as it may stand in the name of a file."""
    return re.sub(r"[^\w.-]", "_", name)
