"""Members of the agents' catalogue, made and counted: what each needed to know and to try."""

from dataclasses import dataclass, replace

from ffgym.agents.catalogue import Entry, Setting, entry_of
from ffgym.agents.common.trials import CountedTrial
from ffgym.control import FeedForwardLaw


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
