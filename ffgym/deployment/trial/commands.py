"""Commands of runs, compared: which ran with the correction and which without, as the logs themselves show it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.measures import interpolate, rms
from ffgym.core.types import Array
from ffgym.deployment.trial.passes import ProgramPass
from ffgym.deployment.trial.program import TrialProgram
from ffgym.recordings import Recording

_INSTANTS = 400
"""Instants of a program at which commands are compared."""
_CLEAR = 4.0
"""Ratio of the difference between both kinds of runs and the scatter within them from which on it is no chance."""
_LEAST = 1e-8
"""Least difference [rad, m or N m]; below are rounding and interpolation."""
_SURE = 0.5
"""Largest ratio of the distances from the other kind and from the own from which on a run belongs to the other."""

CHANNELS = ("reference.position", "correction.position", "compensation.effort")
"""Columns that may hold what a correction changes: commanded positions, what is added to them, and added torque."""


@dataclass(frozen=True, kw_only=True)
class CommandCheck:
    """Result of comparing the commands of the runs of one program."""

    channel: str
    """Columns that show the correction; empty if none does."""
    difference: float
    """RMS difference between runs with and without, behind the gearbox [rad or m], or [N m]."""
    swapped: tuple[int, ...]
    """Numbers of runs whose command is that of the other kind."""


def read_command(program: TrialProgram, log: Recording, taken: ProgramPass) -> dict[str, Array]:
    """Read what a pass was commanded beside its program, by channel, at even instants, shape (_INSTANTS, N).

    Set-points are aligned with the program by themselves, as they may lead what the pass was found by.
    """
    at = np.linspace(0.0, program.duration, _INSTANTS)
    wanted = interpolate(at, program.recording.t, program.joints)
    found: dict[str, Array] = {}
    for channel in CHANNELS:
        if not log.has(channel):
            continue
        values = log.joint_array(channel)
        if channel == "reference.position":
            values, start = log.header.joint_side(values), taken.start
            speed = np.gradient(wanted, at, axis=0)
            for _ in range(3):
                late = np.sum(speed * (interpolate(at + start, log.t, values) - wanted)) / np.sum(speed**2)
                start -= float(late)
            found[channel] = interpolate(at + start, log.t, values) - wanted
        else:
            found[channel] = interpolate(at + taken.start, log.t, values)
    return found


def compare_commands(commands: Mapping[int, Mapping[str, Array]], corrected: Mapping[int, bool]) -> CommandCheck:
    """Compare commands of the runs of one program, by the runs' numbers, with what was planned.

    The middle of each kind is the median over its runs, which a few runs of the other kind do not move.
    """
    best = CommandCheck(channel="", difference=0.0, swapped=())
    clearest = _CLEAR
    for channel in CHANNELS:
        logged = [command[channel] for command in commands.values() if channel in command]
        if not logged or set(corrected.values()) != {False, True}:
            continue
        # a log without the column is of a run in which nothing was added
        nothing = np.zeros_like(logged[0])
        kinds = {
            kind: {n: command.get(channel, nothing) for n, command in commands.items() if corrected[n] == kind}
            for kind in (False, True)
        }
        middles = {kind: np.median(np.stack(list(own.values())), axis=0) for kind, own in kinds.items()}
        difference = rms(middles[True] - middles[False])
        scatter = float(np.median([rms(own - middles[kind]) for kind in kinds for own in kinds[kind].values()]))
        clear = difference / max(scatter, _LEAST)
        if difference > _LEAST and clear > clearest:
            clearest = clear
            best = CommandCheck(channel=channel, difference=difference, swapped=_find_swapped(kinds, middles))
    return best


def _find_swapped(kinds: Mapping[bool, Mapping[int, Array]], middles: Mapping[bool, Array]) -> tuple[int, ...]:
    """Find runs that are like those of the other kind; all of them if those without are farther from the program."""
    everywhere = rms(middles[True]) < _SURE * rms(middles[False])
    swapped: Sequence[int] = [
        number
        for kind, own in kinds.items()
        for number, command in own.items()
        if (rms(command - middles[not kind]) < _SURE * rms(command - middles[kind])) != everywhere
    ]
    return tuple(sorted(swapped))
