"""Residuals that a faultless model leaves: noise in ever new order, and calibration errors drawn from their prior."""

from collections.abc import Mapping, Sequence

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.calibration import BOUND
from ffgym.diagnosis.evidence.stack import Blocks, Values
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.signatures.parts import Parts

DRAWS = 60
"""Draws of noise; the largest score of any candidate in each gives the threshold."""


def surrogates(
    draws: Mapping[Channel, Array], blocks: Blocks, calibration: Sequence[Parts], rng: np.random.Generator
) -> Values:
    """Residuals (R, M, K) by component of K faultless logs.

    Each is a replay of the nominal model over its own simulation, with the sign of every block drawn, which keeps size
    and spectrum; and with calibration errors within their bounds.

    Args:
        draws: residuals of faultless replays (R, M, C, D).
        blocks: of rows.
        calibration: columns per standard deviation.
        rng: draws signs and errors.
    """
    errors = np.clip(rng.normal(size=(len(calibration), DRAWS)), -BOUND, BOUND)
    found: dict[tuple[Channel, int], Array] = {}
    for channel, rows in draws.items():
        for c in range(rows.shape[2]):
            pick = rng.integers(rows.shape[3], size=DRAWS)
            signs = rng.choice([-1.0, 1.0], size=(len(blocks) + 1, DRAWS))
            found[channel, c] = rows[:, :, c, pick] * signs[blocks.of_row]
    for column, sizes in zip(calibration, errors, strict=True):
        for key, rows in column.items():
            if key in found:
                found[key] += rows[..., None] * sizes
    return found
