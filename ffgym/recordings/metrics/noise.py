"""Size of errors without the noise of the sensor that measured them."""

from typing import NamedTuple

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray


class QuietRms(NamedTuple):
    """Root mean square of errors, as it would be without white noise of the sensor."""

    rms: float
    """In the unit of the errors; where noise hides it, the size that noise can hide."""
    doubt: float
    """Relative standard deviation of it that noise leaves; 1/2 and more where noise hides the errors."""


def rms_without_noise(errors: Array, counts: BoolArray) -> QuietRms:
    """Compute the RMS length of errors without what white noise of the sensor adds.

    Neighbouring samples share the error, and not the noise, so that products of neighbours have its square on average.
    Errors change a little between samples; products one and two samples apart, (4 R1 - R2) / 3, are free of that to
    the fourth order: of an error at a twentieth of the sample rate 0.3 % of the square are lost.

    Args:
        errors: errors at even times, shape (T, m); rows that do not count may be NaN.
        counts: rows that count, shape (T,).

    Raises:
        FFGymError: if fewer than ten products are left.
    """
    products = [np.sum(errors[k:] * errors[: len(errors) - k], axis=1) for k in range(3)]
    usable = [counts[k:] & counts[: len(counts) - k] for k in range(3)]
    if min(int(rows.sum()) for rows in usable) < 10:
        raise FFGymError(f"{int(usable[2].sum())} samples with a neighbour two samples on are too few for an error.")
    own, first, second = (float(each[rows].mean()) for each, rows in zip(products, usable, strict=True))
    square = (4 * first - second) / 3
    noise, width = max(own - square, 0.0), errors.shape[1]
    # scatter of the square: signal times noise, which both sides share, and noise times noise
    scatter = np.sqrt((4 * max(square, 0.0) * noise + 17 / 9 * noise**2) / (width * int(usable[0].sum())))
    seen = max(square, float(scatter))
    return QuietRms(rms=float(np.sqrt(seen)), doubt=float(scatter / (2 * seen)) if seen > 0 else 0.0)
