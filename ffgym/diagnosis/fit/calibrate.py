"""The machine with calibration errors that explain a log to the noise, though not to the first order.

Columns of a calibration are slopes. A spring that is a per cent stiffer than described swings at another frequency, and
after ten swings its phase is another one; masses that are known to five per cent are off by products of such shares.
Where joints swing long, or numbers are known badly, what is left of that is no fault. The numbers that the slopes give
are put into the machine, which is replayed, and so on (Newton's method with slopes that stay).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

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

_ROUNDS = 6
"""Times that numbers are fitted and replayed with the same slopes; chosen."""

_LESS = 0.7
"""Share of what stood out that is left after that, at most, if numbers are to be the reason; chosen."""

_HEARD = 0.1
"""Energy above that of noise, as a share of it, from which on numbers are looked for; chosen: chance comes to half."""

_STAYS = 0.02
"""Relative change of what stands out below which more rounds bring nothing."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Calibrated:
    """A nominal machine with other numbers."""

    machine: Machine
    sizes: Array
    """By which they differ, in standard deviations of the doubts; 0 for those that are no numbers of the robot."""


def calibrate(setting: Setting) -> Calibrated | None:
    """The nominal machine with numbers within their calibration that explain more than slopes tell; None if none do."""
    fit = evaluated(setting, ())
    first = least = excess_of(setting, fit)
    best, plain = None, fit.residual
    of_robot = np.array([issubclass(doubt.column.effect, NativeEffect) for doubt in setting.doubts])
    for _ in range(_ROUNDS if first > _HEARD and setting.doubts else 0):
        sizes = fitted(fit.evidence, fit.calibration_only, fit.priors) * of_robot
        numbers = possible_numbers(setting, sizes)
        moved = None if numbers is None else trial_of(setting, (), numbers)
        if numbers is None or moved is None:
            break
        beyond = _beyond(setting, sizes, plain, moved.residual)
        found = replace(setting, bias={channel: rows + beyond[channel] for channel, rows in setting.bias.items()})
        fit = evaluated(found, ())
        excess = excess_of(found, fit)
        if excess >= least * (1 - _STAYS):
            break
        best, least = Calibrated(machine=numbers, sizes=sizes), excess
    return best if least < _LESS * first else None


def excess_of(setting: Setting, fit: Fit) -> float:
    """Largest energy above that of noise of any component, as a share of that."""
    return max(loudness(setting, without_calibration(setting, fit)).values()) - 1.0


def _beyond(
    setting: Setting, sizes: Array, plain: Mapping[Channel, Array], moved: Mapping[Channel, Array]
) -> dict[Channel, Array]:
    """Change by other numbers beyond what their slopes say, by what both machines leave, (R, M, C)."""
    found = {channel: plain[channel] - rows for channel, rows in moved.items()}
    for column, size in zip(setting.calibration, sizes.tolist(), strict=True):
        for (channel, c), rows in column.items():
            if channel in found:
                found[channel][:, :, c] -= size * rows
    return found
