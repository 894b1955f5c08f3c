"""Fits judged by blocks that they were not made from."""

from collections.abc import Sequence

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.evidence.fitted import left_by_block
from ffgym.diagnosis.evidence.folds import half_folds, motion_folds
from ffgym.diagnosis.evidence.priors import Priors
from ffgym.diagnosis.fit.fit import Fit, evaluated
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.refine import fit
from ffgym.diagnosis.fit.setting import Setting
from ffgym.diagnosis.search.found import Tried


def judged_with(
    setting: Setting, hypotheses: Sequence[Hypothesis], like: Fit | None = None, *, begun: bool = False
) -> Tried:
    """Fit, with tangents of others from a fit `like` it, then judge by blocks that were left out."""
    if not hypotheses:
        return scored(setting, evaluated(setting, ()))
    return scored(setting, fit(setting, hypotheses, begun=begun, like=like))


def scored(setting: Setting, found: Fit) -> Tried:
    """A fit with what it leaves in blocks that were left out."""
    return Tried(fit=found, left=left_out(setting, found, found.priors))


def left_out(setting: Setting, found: Fit, priors: Priors) -> Array:
    """Energy that a fit leaves in blocks that were left out, both splits in mean, shape (B,)."""
    halves, motions = half_folds(setting.blocks), motion_folds(setting.blocks)
    left = [left_by_block(found.evidence, folds, found.fold_columns, priors) for folds in (halves, motions) if folds]
    mean: Array = np.mean(left, axis=0)
    return mean
