"""What models leave of recordings that were not diagnosed, along their measured motion: it takes no set-points."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.closed_loop import LoopLevel
from ffgym.diagnosis.log import log_of
from ffgym.diagnosis.measured import counting_rows, measured_rows, residual_rows
from ffgym.diagnosis.replay import predicted, replay
from ffgym.diagnosis.residual import UNITS, components
from ffgym.recordings import Recording
from ffgym.simulation.plant import Machine


@dataclass(frozen=True, kw_only=True)
class HeldOut:
    """Measured minus predicted of two models, component by component."""

    levels: tuple[LoopLevel, ...]

    @property
    def is_better(self) -> bool:
        """Whether the second model leaves less than the first, each component in units of what the first leaves."""
        shares = [(level.after / level.before) ** 2 for level in self.levels if level.before > 0]
        return bool(shares) and float(np.mean(shares)) < 1.0


def held_out_levels(
    before: Machine, after: Machine, recordings: Sequence[Recording], *, cutoff: float | None = None
) -> HeldOut:
    """Replay two models along recordings, and compare what they leave.

    Args:
        before: the nominal model, as its file has it.
        after: the extended model, as its file has it.
        recordings: of the machine that were not diagnosed, with motor angle and torque.
        cutoff: of what is compared [Hz], that of the diagnosis; None is the usual one.

    Raises:
        FFGymError: if there are no recordings, or they do not fit the robot.
    """
    if not recordings:
        raise FFGymError("There is nothing to compare: name recordings that were not diagnosed.")
    log = log_of(before.physical, recordings, cutoff=cutoff)
    rest = [residual_rows(log, predicted(replay(log, model))) for model in (before, after)]
    counting, measured = counting_rows(log), measured_rows(log)
    levels = [
        LoopLevel(
            quantity=channel,
            component=name,
            unit=UNITS[channel],
            measured=_rms(_about_mean(measured[channel][..., c], rows), rows),
            before=_rms(rest[0][channel][..., c], rows),
            after=_rms(rest[1][channel][..., c], rows),
        )
        for channel in rest[0]
        for c, name in enumerate(components(channel, before.robot))
        if (rows := counting[channel, c]).any()
    ]
    return HeldOut(levels=tuple(levels))


def _about_mean(values: Array, rows: BoolArray) -> Array:
    return values - values[rows].mean()


def _rms(values: Array, rows: BoolArray) -> float:
    return float(np.sqrt(np.mean(values[rows] ** 2)))
