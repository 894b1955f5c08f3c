"""The machine with calibration errors that explain a log to the noise, though not to the first order.

Columns of a calibration are slopes. A spring that is a per cent stiffer than described swings at another frequency, and
after ten swings its phase is another one; masses that are known to five per cent are off by products of such shares.
Where joints swing long, or numbers are known badly, what is left of that is no fault. The numbers that the slopes give
are put into the machine, which is replayed, and so on (Newton's method with slopes that stay).
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ffgym.diagnosis.evidence.fitted import fitted
from ffgym.diagnosis.fit.fit import Fit, evaluated, trial_of
from ffgym.diagnosis.fit.leftover import loudness, without_calibration
from ffgym.diagnosis.fit.numbers import possible_numbers
from ffgym.diagnosis.fit.setting import Setting
from ffgym.diagnosis.residual import Channel
from ffgym.effects import NativeEffect
from ffgym.plant import Machine
from ffgym.types import Array

_ROUNDS = 10
"""Times that numbers are fitted and replayed; chosen: phases that are off by a radian need eight."""

_SOON, _LESS = 4, 0.7
"""Rounds after which no more than this share of what stood out is left, if something is to come of it."""

_HEARD, _QUIET = 0.1, 0.25
"""Energy above that of noise, as a share of it, from which on numbers are looked for, and to which they must bring it;
chosen: chance comes to a twentieth."""

_GONE = 0.15
"""Share of what stood out that is left where numbers are the reason, too: steps of the replay do something else to
another machine, which is known once it is the nominal one."""

_STAYS = 0.02
"""Relative change of what stands out below which more rounds bring nothing."""


def calibrated(setting: Setting) -> Machine | None:
    """The nominal machine with numbers within their calibration that explain the log; None if slopes tell all of it."""
    fit = evaluated(setting, ())
    first = excess = _excess(setting, fit)
    numbers, plain = None, fit.residual
    numbers_of_robot = np.array([issubclass(doubt.column.effect, NativeEffect) for doubt in setting.doubts])
    for i in range(_ROUNDS if first > _HEARD and setting.doubts else 0):
        if excess < _HEARD or (i == _SOON and excess > _LESS * first):
            break
        sizes = fitted(fit.evidence, fit.calibration_only, fit.priors) * numbers_of_robot
        numbers = possible_numbers(setting, sizes)
        moved = None if numbers is None else trial_of(setting, (), numbers)
        if moved is None:
            return None
        beyond = _beyond(setting, sizes, plain, moved.residual)
        found = replace(setting, bias={channel: rows + beyond[channel] for channel, rows in setting.bias.items()})
        fit, before = evaluated(found, ()), excess
        excess = _excess(found, fit)
        if abs(excess - before) < _STAYS * before:
            break
    return numbers if excess < max(_QUIET, _GONE * first) else None


def _excess(setting: Setting, fit: Fit) -> float:
    """Largest energy above that of noise of any component, as a share of that."""
    return max(loudness(setting, without_calibration(setting, fit)).values()) - 1.0


def _beyond(
    setting: Setting, sizes: Array, plain: Mapping[Channel, Array], moved: Mapping[Channel, Array]
) -> dict[Channel, Array]:
    """What a machine with other numbers does otherwise than their slopes say, by what both leave, (R, M, C)."""
    found = {channel: plain[channel] - rows for channel, rows in moved.items()}
    for column, size in zip(setting.calibration, sizes.tolist(), strict=True):
        for (channel, c), rows in column.items():
            if channel in found:
                found[channel][:, :, c] -= size * rows
    return found
