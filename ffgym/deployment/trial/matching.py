"""Logs and the runs of a plan: matched by name, or by order where no name is of the plan."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.deployment.trial.plan import PlannedRun, TrialPlan
from ffgym.recordings import Recording

_NUMBER = re.compile(r"\D*(\d+)(.*)", flags=re.DOTALL)
"""First number in the name of a log, and what comes after it."""


@dataclass(frozen=True, eq=False)
class TrialLog:
    """A log with its name."""

    name: str
    """Name of the file without suffix, or of the motion in a file with several."""
    recording: Recording


@dataclass(kw_only=True, eq=False)
class Matches:
    """Logs by the numbers of their runs."""

    logs: dict[int, TrialLog] = field(default_factory=dict)
    left_out: dict[int, str] = field(default_factory=dict)
    """Reasons why runs have no log, by number."""
    notes: list[str] = field(default_factory=list)
    """Sentences on logs that belong to no run, and on how logs were matched."""


def match_logs(plan: TrialPlan, logs: Sequence[TrialLog]) -> Matches:
    """Match logs with the runs of a plan.

    Raises:
        FFGymError: if no name is of the plan, and there are not as many logs as runs.
    """
    runs = {run.number: run for run in plan.runs}
    named = {index: run for index, log in enumerate(logs) if (run := _find_run(plan, log.name)) is not None}
    if not named:
        return _match_by_order(plan, logs)
    found = Matches()
    for number in runs:
        own = [logs[index] for index, run in named.items() if run.number == number]
        exact = [log for log in own if log.name.lower() == runs[number].log.lower()]
        chosen = exact or own
        if not own:
            found.left_out[number] = "its log is missing"
        elif len(chosen) > 1:
            names = ", ".join(log.name for log in chosen)
            found.left_out[number] = f"there are several logs of it ({names}); keep the one that counts"
        elif (said := _contradiction(runs[number], chosen[0].name)) is not None:
            found.left_out[number] = f"its log {chosen[0].name} is named {said!r}, the plan says {runs[number].log}"
        else:
            found.logs[number] = chosen[0]
    strangers = [log.name for index, log in enumerate(logs) if index not in named]
    if strangers:
        found.notes.append(f"Not of this plan, and not read: {', '.join(strangers)}.")
    return found


def _find_run(plan: TrialPlan, name: str) -> PlannedRun | None:
    """Find the run that a log is of by its name: the whole name, or the number that it begins with."""
    for run in plan.runs:
        if run.log.lower() == name.lower():
            return run
    found = _NUMBER.fullmatch(name)
    if found is None or not name[0].isdigit() or int(found[1]) > len(plan.runs):
        return None
    return plan.runs[int(found[1]) - 1] if int(found[1]) >= 1 else None


def _contradiction(run: PlannedRun, name: str) -> str | None:
    """Find a word in the name of a log that says the other kind of run."""
    other = "off" if run.corrected else "on"
    words = re.split(r"[^a-z0-9]+", name.lower())
    planned = re.split(r"[^a-z0-9]+", run.log.lower())
    return other if other in words and other not in planned else None


def _match_by_order(plan: TrialPlan, logs: Sequence[TrialLog]) -> Matches:
    """Match as many logs as there are runs, or scored runs, in the order of their clocks or else as they come."""
    whole, scored = list(plan.runs), [run for run in plan.runs if not run.is_warm_up]
    order = next((runs for runs in (whole, scored) if len(runs) == len(logs)), None)
    if order is None:
        raise FFGymError(
            f"No log has a name of the plan, e.g. {plan.runs[-1].log}, and {len(logs)} logs cannot be matched in order "
            f"with {len(whole)} runs, {len(scored)} of them scored. Name the logs as the plan does, or give all."
        )
    clock = sort_by_clock([log.recording for log in logs])
    found = Matches(notes=["No log has a name of the plan: they were matched in the order " + _order_words(clock)])
    for run, index in zip(order, range(len(logs)) if clock is None else clock, strict=True):
        found.logs[run.number] = logs[index]
    found.left_out |= {run.number: "its log is missing" for run in whole if run.number not in found.logs}
    return found


def _order_words(clock: Sequence[int] | None) -> str:
    return "in which they were given." if clock is None else "of their clocks."


def sort_by_clock(recordings: Sequence[Recording]) -> list[int] | None:
    """Sort recordings by the controller's clock; None if it begins anew in each, or two overlap."""
    order = np.argsort([recording.t[0] for recording in recordings], kind="stable").tolist()
    ends = [recordings[index].t[-1] for index in order[:-1]]
    begins = [recordings[index].t[0] for index in order[1:]]
    return order if all(begin > end for begin, end in zip(begins, ends, strict=True)) else None
