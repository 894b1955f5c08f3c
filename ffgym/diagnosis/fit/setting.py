"""What all fits of a diagnosis share."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.calibration import Doubt, RowOffset, is_row_offset
from ffgym.diagnosis.evidence import Blocks, Stack, Values, stack_of
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.signatures.push import Parts
from ffgym.simulation.plant import Machine

HELD = 1e-6
"""Standard deviations within which a calibration error is held; bounds must lie apart."""

_INEXACT = 0.01
"""Share of the energy that numbers within their calibration explain which they may leave; chosen: a tenth of the
amplitude, of swings whose phase those numbers turn."""


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
    floor: Mapping[Channel, Array] = field(default_factory=dict)
    """RMS of noise alone, (M, C), without what single rows are doubted by; empty where nobody asks."""
    described: Mapping[tuple[Channel, int], float] = field(default_factory=dict)
    """Energy over that of noise, by component, that the model as described leaves, where this one has other numbers."""

    def inexact(self, component: tuple[Channel, int]) -> float:
        """Energy over that of noise that other numbers may leave of what they explain: they are fitted by steps."""
        return _INEXACT * max(self.described.get(component, 1.0) - 1.0, 0.0)

    def certain(self, component: tuple[Channel, int]) -> float:
        """Share of the energy of noise of a component that is not doubt of single rows, from 0 to 1."""
        channel, c = component
        if channel not in self.floor:
            return 1.0
        weight = np.broadcast_to(self.weights[component], self.blocks.of_row.shape)
        counted = (weight > 0) & (self.blocks.of_row >= 0)
        certain = np.square(weight * self.floor[channel][:, c])[counted]
        return float(np.mean(certain)) if len(certain) else 0.0

    def calibration_limits(self, hypotheses: Sequence[Hypothesis] = ()) -> tuple[Array, Array]:
        """Lowest and highest values of the calibration's columns beside hypotheses, in standard deviations.

        A number that is a cause is no calibration error beside it: it is one number, with one prior.
        """
        if not self.doubts:
            bound = np.full(len(self.calibration), self.bound)
            return -bound, bound
        n = self.log.robot.n_joints
        is_cause = np.array([any(is_number_of(doubt, one, n) for one in hypotheses) for doubt in self.doubts])
        low, high = (np.array([getattr(doubt, end) for doubt in self.doubts]) for end in ("low", "high"))
        return np.where(is_cause, -HELD, low), np.where(is_cause, HELD, high)

    def as_described(self, hypotheses: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
        """Hypotheses of the machine as it is described: a number that is one differs by all that it differs by."""
        n, found = self.log.robot.n_joints, []
        for one in hypotheses:
            values = dict(one.values)
            for doubt in self.doubts:
                name = doubt.column.parameter
                if is_number_of(doubt, one, n) and name in values and doubt.column.part is None:
                    share = one.kind.parameters()[name].unit == "1"
                    more, at = values[name], doubt.at * doubt.sigma
                    values[name] = (1 + more) * (1 + at) - 1 if share else more + at
            found.append(replace(one, values=values))
        return tuple(found)

    @cached_property
    def stack(self) -> Stack:
        """The calibration's columns, weighted."""
        return stack_of(self.blocks, self.calibration, self.weights)

    def with_bias(self, bias: Mapping[Channel, Array]) -> Self:
        """Return the setting with another bias and the same stack, which depends on none and is large."""
        other = replace(self, bias=bias)
        other.__dict__["stack"] = self.stack
        return other


def is_number_of(doubt: Doubt, hypothesis: Hypothesis, n_joints: int) -> bool:
    """Whether a hypothesis has the number that a calibration error is of."""
    column = doubt.column
    if column.effect is RowOffset:
        return is_row_offset(hypothesis.kind, n_joints)
    is_there = (column.effect, column.joint) == (hypothesis.kind, hypothesis.joint)
    return is_there and column.parameter not in hypothesis.null


def values_of(residual: Mapping[Channel, Array]) -> Values:
    """Residuals (R, M, C) by component, (R, M, 1) each."""
    return {(channel, k): rows[..., k : k + 1] for channel, rows in residual.items() for k in range(rows.shape[2])}
