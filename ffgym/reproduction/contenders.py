"""Members of the agents' catalogue, made and counted: what each needed to know and to try."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from agents.catalogue import Entry, Setting, entry_of
from agents.common.trials import Trial
from ffgym.control import FeedForwardLaw
from ffgym.recordings import Recording
from ffgym.simulation import Run


class CountedTrial:
    """Trials of a machine, counted."""

    def __init__(self, trial: Trial) -> None:
        """Count from 0."""
        self.trial = trial
        self.trials = 0
        """Calls, each of which may run several motions."""
        self.robot_seconds = 0.0
        """Time that the machine moved [s]."""

    def __call__(self, runs: Sequence[Run], number: int) -> Sequence[Recording]:
        """Run and count; see `Trial`."""
        self.trials += 1
        self.robot_seconds += sum(run.reference.duration for run in runs)
        return self.trial(runs, number)


@dataclass(frozen=True, kw_only=True, eq=False)
class Contender:
    """One member, ready to run."""

    entry: Entry
    law: FeedForwardLaw
    trials: int
    robot_seconds: float


def contender(name: str, setting: Setting) -> Contender:
    """Make a member of the catalogue; learning members run their trials here."""
    counted = CountedTrial(setting.trial)
    entry = entry_of(name)
    law = entry.make(replace(setting, trial=counted))
    return Contender(entry=entry, law=law, trials=counted.trials, robot_seconds=counted.robot_seconds)
