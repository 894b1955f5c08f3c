"""Protocol of adaptation: motions to practise, motions that are scored, and robot time within a budget.

An adapter gets the nominal arm of the controller, a trial that runs motions on the machine and returns what its sensors
see, and a budget in seconds of motion. It returns a feed-forward law. The law is scored on motions that it could not
practise, by the RMS path error of the true tool over that without compensation.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.leaderboard.motions import follow_square
from ffgym.leaderboard.tasks import TRAIN_POSITION
from ffgym.paths import RADII, SPEEDS, Reference
from ffgym.recordings import Recording
from ffgym.recordings.metrics import contour_errors, path_errors
from ffgym.robot import RigidArm
from ffgym.simulation import Run
from ffgym.simulation.shared_rig import Trial
from ffgym.studies import circle_references

LAP = (0.003, 0.040)
"""Radius [m] and speed [m/s] of the circle at p1 whose laps count budgets; the middle ones of the thesis."""
SCORED = (
    ("p2", 0.005, 0.100),
    ("p2", 0.004, 0.070),
    ("p3", 0.003, 0.040),
    ("p4", 0.002, 0.020),
    ("p3", 0.001, 0.010),
)
"""Position, radius [m] and speed [m/s] of circles that are scored; chosen: other positions than that of practice, all
speeds and radii from those of the thesis to those between them."""
SQUARE = ("p4", 0.004, 0.040)
"""Position, half a side [m] and speed [m/s] of a square that is scored too; it begins at a corner, and the others are
rounded by half of half a side."""
_SAME = 1e-6
"""Positions of two motions that differ by less everywhere [rad] are those of one motion."""


@lru_cache(maxsize=8)
def lap(arm: RigidArm) -> Reference:
    """Make one lap of the circle that every budget allows."""
    return practice_motion(arm, *LAP)


@lru_cache(maxsize=64)
def practice_motion(arm: RigidArm, radius: float, speed: float) -> Reference:
    """Make one lap of a circle of a radius [m] at a speed [m/s] at the position of practice."""
    return _circle(arm, TRAIN_POSITION, radius, speed)


def practice_set(arm: RigidArm) -> list[Reference]:
    """Make the laps of all radii and speeds of the thesis at the position of practice, for larger budgets."""
    return [practice_motion(arm, radius, speed) for speed in SPEEDS for radius in RADII]


@lru_cache(maxsize=8)
def scored_motions(arm: RigidArm) -> tuple[Reference, ...]:
    """Make the motions that are scored."""
    circles = [_circle(arm, *each) for each in SCORED]
    square = follow_square(arm, *SQUARE, "square 8 mm, 40 mm/s", zone=0.5, from_corner=True)
    return *circles, square


def _circle(arm: RigidArm, position: str, radius: float, speed: float) -> Reference:
    return next(iter(circle_references(arm, [position], [speed], [radius]).values()))


def score(recording: Recording) -> float:
    """Compute the RMS path error [m]: of the circle in its plane, as on the leaderboard; of the whole other motion."""
    if recording.phases_of("circle"):
        return path_errors(recording)[0].rms
    return contour_errors(recording)[0].rms


@dataclass(kw_only=True, eq=False)
class BudgetedTrial:
    """Trials on a machine within a budget of motion; every second of every run counts, rests included."""

    trial: Trial
    budget: float
    """Seconds that the machine may move [s]."""
    scored: Sequence[Reference]
    """Motions that may not be practised."""
    robot_seconds: float = field(default=0.0, init=False)
    """Seconds that it has moved [s]."""

    @property
    def left(self) -> float:
        """Seconds that are left [s]."""
        return self.budget - self.robot_seconds

    def __call__(self, runs: Sequence[Run], number: int) -> Sequence[Recording]:
        """Run motions; see `Trial`.

        Raises:
            FFGymError: if they last longer than what is left of the budget, or one of them is scored.
        """
        for run in runs:
            for other in self.scored:
                if _same(run.reference.q, other.q):
                    raise FFGymError(
                        f"The motion {run.reference.name!r} is scored, so it cannot be practised. Practise motions at "
                        f"{TRAIN_POSITION}: lap and practice_set in ffgym.leaderboard.adaptation.protocol."
                    )
        asked = sum(run.reference.duration for run in runs)
        if asked > self.left + 1e-9:
            raise FFGymError(
                f"The runs of trial {number} last {asked:.3f} s, and {self.left:.3f} s of the budget of "
                f"{self.budget:g} s are left. Run fewer or shorter motions."
            )
        self.robot_seconds += asked
        return self.trial(runs, number)


def _same(one: Array, other: Array) -> bool:
    return one.shape == other.shape and bool(np.abs(one - other).max() < _SAME)


@dataclass(frozen=True, kw_only=True, eq=False)
class AdaptationSetting:
    """Arm, trials and seed that an adapter is given for one machine."""

    arm: RigidArm
    """Nominal arm of the controller: all that may be known of the machine beforehand."""
    trial: BudgetedTrial
    """Trials on the machine, within the budget."""
    seed: int = 0
    """Seed of the adapter's own randomness; noise of sensors has the seed of the trial."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Adapter:
    """A family on the curve of adaptation."""

    name: str
    title: str
    about: str
    """One sentence: method, and data that it uses."""
    adapt: Callable[[AdaptationSetting], FeedForwardLaw] = field(repr=False)
    """Function that makes the law for a machine."""
    laps: tuple[int, ...] = (0,)
    """Budgets that it is run with, in laps of `LAP`; 0 is a law that moves nothing."""
    seeds: tuple[int, ...] = (0,)
    """Seeds to run; one, unless a seed changes the adapter beyond the noise of sensors."""
    artefact: Callable[[int], str | None] = field(default=lambda seed: None, repr=False)
    """sha256 of the file that it is read from, by seed; None if there is none."""

    def practise(
        self, arm: RigidArm, trial: Trial, *, laps: int, seed: int = 0
    ) -> tuple[FeedForwardLaw, BudgetedTrial]:
        """Make the law for a machine within a budget in laps; return it, and the trials, which counted robot time."""
        budgeted = BudgetedTrial(trial=trial, budget=laps * lap(arm).duration, scored=scored_motions(arm))
        return self.adapt(AdaptationSetting(arm=arm, trial=budgeted, seed=seed)), budgeted
