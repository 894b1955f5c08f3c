"""Temperature of a machine that runs: what friction and springs that depend on it are asked at."""

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from ffgym.core.errors import check_number, check_shape
from ffgym.core.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Climate:
    r"""Temperature of each joint since the machine was switched on.

    .. math:: T(t) = T_{ambient} + \Delta T (1 - e^{-(t_{on} + t) / \tau})

    The motions do not enter: a robot that works all day warms up by what it does on average.
    """

    ambient: float = 20.0
    """Temperature of the room, and of a machine just switched on [degC]."""
    rise: Array = field(default_factory=lambda: np.zeros(1))
    """Rise of each joint in the end [K], shape (N,); (1,) is the same for all."""
    time_constant: float = 1200.0
    """[s]; 5 to 20 min on industrial robots."""
    running_since: float = 0.0
    """Time for which the machine has run before the motion begins [s]."""

    def __post_init__(self) -> None:
        check_number("climate.ambient", self.ambient, unit="degC", low=-40.0, high=80.0)
        check_number("climate.time_constant", self.time_constant, unit="s", low=0.0, open_low=True)
        check_number("climate.running_since", self.running_since, unit="s", low=0.0)
        single = np.isscalar(self.rise)
        rise = [check_number("climate.rise", self.rise, unit="K")] if single else self.rise
        rise = check_shape("climate.rise", rise, (None,))
        for value in rise:
            check_number("climate.rise", value, unit="K", low=0.0, high=100.0)
        object.__setattr__(self, "rise", rise)

    def at(self, running_since: float) -> Self:
        """The same day, later or earlier [s]."""
        return replace(self, running_since=running_since)

    @property
    def key(self) -> tuple[float, ...]:
        """All its numbers, to tell whether two are the same."""
        return (self.ambient, self.time_constant, self.running_since, *self.rise.tolist())

    def temperature(self, time: Array, n_joints: int) -> Array:
        """Temperature [degC], shape (T, N), at times [s] (T,) since the motion began."""
        rise = np.broadcast_to(self.rise, (n_joints,))
        return warm_up(self.ambient, rise, self.time_constant, self.running_since + time[:, None])


def warm_up(ambient: Array | float, rise: Array, time_constant: Array | float, running: Array) -> Array:
    """Temperature [degC] of machines that have been `running` for so long [s]; arguments as in `Climate`."""
    return ambient + rise * -np.expm1(-running / time_constant)
