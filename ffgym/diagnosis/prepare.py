"""All that a diagnosis computes before it searches: replay, noise floor, and the columns of calibration and effects."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.diagnosis.calibration import BOUND, Calibration, doubts_of
from ffgym.diagnosis.evidence.stack import Values, blocks_of
from ffgym.diagnosis.fit.refine import Setting
from ffgym.diagnosis.log import Log, log_of
from ffgym.diagnosis.measured import residual_rows, valid_rows
from ffgym.diagnosis.noise import Faultless, faultless_recordings, faultless_residuals
from ffgym.diagnosis.replay.replay import Replay, predicted, replay
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.search.candidates import Candidates, candidates_of
from ffgym.diagnosis.search.surrogates import surrogates
from ffgym.diagnosis.signatures.column import columns_of
from ffgym.diagnosis.signatures.variant import Cycles
from ffgym.effects import Effect
from ffgym.plant import Machine
from ffgym.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Prepared:
    """What a search begins with."""

    setting: Setting
    run: Replay
    """Of the nominal machine over its own motion: where motors move as measured, a wrong spring swings at a frequency
    of its own, and what an effect changes would be seen through that swing."""
    faultless: Faultless
    floor: Mapping[Channel, Array]
    """RMS of noise alone, (M, C)."""


def prepared(log: Log, nominal: Machine, calibration: Calibration, rng: np.random.Generator) -> Prepared:
    """Replay the nominal model, and find out what noise alone would leave."""
    like = replay(log, nominal)
    exact = faultless_recordings(log, like)
    clean = log_of(log.robot, exact, like=log)
    run = replay(clean, nominal)
    bias = residual_rows(clean, predicted(run))
    faultless = faultless_residuals(log, exact, bias, nominal, rng)
    floor = faultless.floor(log)
    weights = {(channel, c): 1 / rms[:, c] for channel, rms in floor.items() for c in range(rms.shape[1])}
    doubts = doubts_of(run, calibration)
    setting = Setting(
        log=log,
        nominal=nominal,
        blocks=blocks_of(valid_rows(log), log.sampling.row_dt),
        weights=weights,
        calibration=[{key: rows * d.sigma for key, rows in d.column.parts.items()} for d in doubts],
        doubts=tuple(doubts),
        like=like,
        bias=bias,
        bound=BOUND,
    )
    return Prepared(setting=setting, run=run, faultless=faultless, floor=floor)


def candidates_for(ready: Prepared, kinds: Sequence[type[Effect]], cycles: Cycles) -> Candidates:
    """Columns of effects beside those of the calibration."""
    return candidates_of(ready.setting.doubts, columns_of(ready.run, kinds, cycles))


def noise_for(ready: Prepared, rng: np.random.Generator) -> Values:
    """Residuals of faultless logs."""
    return surrogates(ready.faultless.draws, ready.setting.blocks, ready.setting.calibration, rng)
