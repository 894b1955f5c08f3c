"""Wiring of all logs of a robot at once: which columns are of another joint, sign, unit, side, zero or time."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import final

import numpy as np

from ffgym.logs.quality.wiring.mistake import Mistake, mistake_of
from ffgym.logs.quality.wiring.model import regressor_of
from ffgym.logs.quality.wiring.sample import Samples
from ffgym.logs.quality.wiring.score import POSITION, Scorer
from ffgym.logs.quality.wiring.search import search
from ffgym.recordings import Recording
from ffgym.recordings.rewiring import Rewiring
from ffgym.robot import RobotDescription

_ROWS = 100
"""Rows that a recording needs to take part."""

_RATIO = 0.2
"""Relative difference of gear ratios from which on logs are of another robot."""


@final
@dataclass(frozen=True, kw_only=True)
class Wiring:
    """Mistakes in the wiring of a set of logs, the most telling first, and how their columns should be read."""

    mistakes: tuple[Mistake, ...] = ()
    rewiring: Rewiring = field(default_factory=Rewiring)


def find_wiring(recordings: Sequence[Recording], robot: RobotDescription) -> Wiring:
    """Fit the wiring of recordings of one robot, by what its description explains of their signals.

    Friction, payloads, masses, springs and gears that differ from the description are no mistakes in wiring: they are
    free within what machines have. A mistake is one that is discrete, and without which far more is explained on rows
    that were left out. Without motor positions, or where recordings do not fit the robot or each other, there are none.

    Args:
        recordings: of one robot, with columns that mean the same.
        robot: its description; masses and friction may be typical.
    """
    fitting = [recording for recording in recordings if _fits(recording, robot)]
    if not fitting or len({_kind(recording) for recording in fitting}) > 1:
        return Wiring()
    samples = Samples(fitting)
    if POSITION not in samples.families:
        return Wiring()
    rewiring, found = search(Scorer(samples, regressor_of(robot)))
    ratio = fitting[0].header.gear_ratio
    return Wiring(mistakes=tuple(mistake_of(one, samples, ratio) for one in found), rewiring=rewiring)


def _fits(recording: Recording, robot: RobotDescription) -> bool:
    """Whether a recording can be judged by a description."""
    header, drive = recording.header, robot.drive
    if header.joints != robot.joints or len(recording) < _ROWS or not recording.has(POSITION):
        return False
    return bool(np.allclose(header.gear_ratio, drive.gear_ratio, rtol=_RATIO))


def _kind(recording: Recording) -> tuple[object, ...]:
    """What columns of a recording mean."""
    header = recording.header
    return header.gear_ratio, header.position_side, header.torque_semantics, header.coupling
