"""A first look: which effect before the gearbox would explain most of the torque, after some seconds.

It replays once and simulates nothing, so that it knows neither how much chance explains nor what else would: good for
the impatient, no verdict.
"""

from dataclasses import dataclass

import numpy as np

from ffgym.diagnosis.answer.excitation import judgeable_kinds
from ffgym.diagnosis.calibration import Calibration, doubts_of
from ffgym.diagnosis.evidence.folds import half_folds
from ffgym.diagnosis.evidence.screen import screen
from ffgym.diagnosis.evidence.stack import Blocks, Values, blocks_of
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.measured import residual_rows, valid_rows
from ffgym.diagnosis.noise import torque_noise
from ffgym.diagnosis.replay import Replay, predicted, replay
from ffgym.diagnosis.search.candidates import Candidates, candidates_of
from ffgym.diagnosis.signatures.column import columns_of
from ffgym.effects import Effect, ResolverEffect
from ffgym.simulation.plant import Machine

STANDS_OUT = 0.5
"""Share of the torque's residual above noise that an effect must explain to be spoken of: what explains less than half
is imitated by something else as often."""


@dataclass(frozen=True, kw_only=True)
class FirstLook:
    """The effect that would explain most, if one stands out."""

    effect: type[Effect] | None
    joint: str
    share: float
    """Of the residual's energy above noise, on halves of motions that were not fitted."""

    @property
    def sentence(self) -> str:
        """For people."""
        if self.effect is None:
            return (
                "First look, at torque alone: no effect before the gearbox stands out. What repeats with the turn of a "
                "motor, and the arm, are not looked at yet."
            )
        where = f" of {self.joint}" if self.joint else ""
        return (
            f"First look, at torque alone: {self.effect.title}{where} would explain {self.share:.0%} of what noise and "
            f"calibration do not; rivals, chance and the arm are not looked at yet."
        )


def first_look(log: Log, nominal: Machine, calibration: Calibration) -> FirstLook:
    """Screen the effects before the gearbox on the torque of a log."""
    run = replay(log.torque_alone, nominal)
    residual = residual_rows(run.log, predicted(run))["torque"]
    values: Values = {("torque", j): residual[..., j : j + 1] for j in range(residual.shape[2])}
    weights: Values = {("torque", j): 1 / column for j, column in enumerate(torque_noise(run).T)}
    blocks = blocks_of(valid_rows(run.log), log.sampling.row_dt)
    candidates = _candidates(run, nominal, calibration, blocks, weights)
    if not len(blocks) or not candidates.groups:
        return FirstLook(effect=None, joint="", share=0.0)
    evidence = candidates.stack.evidence(values)
    seen = screen(evidence, half_folds(blocks), candidates.calibration, candidates.groups, candidates.priors)
    best = int(np.argmax(seen.gain[:, 0]))
    above = float(seen.left[0] - evidence.rows.sum())
    share = float(seen.gain[best, 0]) / above if above > 0 else 0.0
    if share < STANDS_OUT:
        return FirstLook(effect=None, joint="", share=max(share, 0.0))
    first = candidates.first(candidates.groups[best])
    return FirstLook(effect=first.effect, joint=first.joint, share=min(share, 1.0))


def _candidates(run: Replay, nominal: Machine, calibration: Calibration, blocks: Blocks, weights: Values) -> Candidates:
    """Effects whose columns take no arm."""
    kinds, _ = judgeable_kinds(run.log, nominal, calibration)
    plain = [kind for kind in kinds if kind.side == "motor" and not issubclass(kind, ResolverEffect)]
    return candidates_of(doubts_of(run, calibration), columns_of(run, plain, {}), blocks, weights)
