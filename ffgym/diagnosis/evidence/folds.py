"""What is left out in turn: whole motions, and halves of motions with a gap between them."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.types import BoolArray
from ffgym.diagnosis.evidence.stack import Blocks


@dataclass(frozen=True, kw_only=True, eq=False)
class Fold:
    """Blocks to fit to, and blocks to judge by; shape (B,) each."""

    train: BoolArray
    test: BoolArray


def motion_folds(blocks: Blocks) -> list[Fold]:
    """Each motion left out in turn: does an explanation hold for other motions? None of a single motion."""
    motions = np.unique(blocks.motion)
    if len(motions) < 2:
        return []
    return [Fold(train=blocks.motion != m, test=blocks.motion == m) for m in motions]


def half_folds(blocks: Blocks) -> list[Fold]:
    """Each half of each motion left out in turn: the only split that can judge what one motion alone excites.

    Blocks on either side of the cut are not fitted to when the other half is judged, so that nothing leaks over it.
    """
    found = []
    for m in np.unique(blocks.motion):
        for half in (0, 1):
            test = (blocks.motion == m) & (blocks.half == half)
            near = blocks.guard & (blocks.motion == m)
            if test.any():
                found.append(Fold(train=~test & ~near, test=test))
    return found
