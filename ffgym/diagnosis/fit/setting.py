"""What all fits of a diagnosis share."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from ffgym.diagnosis.calibration import Doubt
from ffgym.diagnosis.evidence.stack import Blocks, Stack, Values, stack_of
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.signatures.parts import Parts
from ffgym.plant import Machine
from ffgym.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Setting:
    """A log, and all that does not depend on what is fitted to it."""

    log: Log
    nominal: Machine
    blocks: Blocks
    weights: Values
    calibration: Sequence[Parts]
    """Columns per standard deviation."""
    doubts: tuple[Doubt, ...]
    """What those columns are."""
    like: Replay | None
    """Nominal replay of the log, whose parts serve other replays."""
    bias: Mapping[Channel, Array]
    """What replay and simulation of one model differ by, (R, M, C): steps of time; taken off every residual."""
    bound: float
    """Standard deviations beyond which a calibration error is none."""

    @cached_property
    def stack(self) -> Stack:
        """The calibration's columns, weighted."""
        return stack_of(self.blocks, self.calibration, self.weights)


def values_of(residual: Mapping[Channel, Array]) -> Values:
    """Residuals (R, M, C) by component, (R, M, 1) each."""
    return {(channel, k): rows[..., k : k + 1] for channel, rows in residual.items() for k in range(rows.shape[2])}
