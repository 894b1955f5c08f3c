"""Regressors of a friction model: speeds, slip elements and past outputs, as data and along a motion."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.robot.friction import slip_along


@dataclass(frozen=True, kw_only=True)
class Regressors:
    r"""Entries of the regression vector, in this order.

    .. math:: \varphi(k) = [v(k - i) \ldots \; s_w(k) \ldots \; y(k - j) \ldots]

    with motor speed v, slip elements s (`ffgym.robot.friction`) of widths w, and torque y. Thesis (6.19)
    is `speed_lags=(0, 1), output_lags=()`; (6.20) is the default.
    """

    speed_lags: tuple[int, ...] = (0,)
    """Lags i of speeds [samples], 0 or more; 0 is the present speed."""
    slip_widths: tuple[float, ...] = ()
    """Motor travel after which each slip element slips [rad], > 0."""
    output_lags: tuple[int, ...] = (1,)
    """Lags j of past outputs [samples], 1 or more."""

    def __post_init__(self) -> None:
        for name, lowest in (("speed_lags", 0), ("output_lags", 1)):
            lags = tuple(check_whole(name, lag, unit="samples", low=lowest) for lag in getattr(self, name))
            object.__setattr__(self, name, lags)
        widths = tuple(check_number("slip_widths", w, unit="rad", low=0.0, open_low=True) for w in self.slip_widths)
        object.__setattr__(self, "slip_widths", widths)
        for name in ("speed_lags", "slip_widths", "output_lags"):
            if len(set(getattr(self, name))) < len(getattr(self, name)):
                raise FFGymError(f"{name} = {getattr(self, name)} names one regressor twice.")
        if self.n_inputs == 0:
            raise FFGymError("speed_lags and slip_widths are both empty; friction needs one of them.")

    @property
    def n_inputs(self) -> int:
        """Number of regressors that follow from the speed alone."""
        return len(self.speed_lags) + len(self.slip_widths)

    @property
    def count(self) -> int:
        """Length R of the vector."""
        return self.n_inputs + len(self.output_lags)

    @property
    def n_past_speeds(self) -> int:
        """Past speeds that must be remembered; a slip element needs the last one."""
        return max(*self.speed_lags, 1 if self.slip_widths else 0, 0)

    @property
    def n_past_outputs(self) -> int:
        """Past outputs that must be remembered."""
        return max(self.output_lags, default=0)

    def inputs(self, motor_dq: Array, dt: float, speed_scale: Array) -> Array:
        """Compute regressors that follow from motor speeds (T, N) [rad/s], shape (T, N, n_inputs).

        Before the start the first speed was held; speeds are in units of `speed_scale` [rad/s], shape (N,).
        """
        v = check_shape("motor_dq", motor_dq, (None, len(speed_scale))) / speed_scale
        if not len(v):
            raise FFGymError("motor_dq has no samples; give the friction model a motion.")
        columns = [delay(v, lag, before=v[0])[..., None] for lag in self.speed_lags]
        if self.slip_widths:
            columns.append(slip_along(motor_dq, dt, np.array(self.slip_widths)))
        return np.concatenate(columns, axis=-1)

    def past_outputs(self, y: Array) -> list[Array]:
        """Delay outputs (T, N) by each lag, shape (T, N, 1) each; there was none before the start."""
        return [delay(y, lag, before=np.zeros_like(y[0]))[..., None] for lag in self.output_lags]


def lags_of(times: Sequence[float], dt: float) -> tuple[int, ...]:
    """Lags in samples of `dt` [s] for times [s], the nearest ones.

    Raises:
        FFGymError: if two times fall on one sample, or a number is out of range.
    """
    check_number("dt", dt, unit="s", low=0.0, open_low=True)
    lags = tuple(round(check_number("lag", time, unit="s", low=0.0) / dt) for time in times)
    if len(set(lags)) < len(lags):
        raise FFGymError(f"Lags {list(times)} s fall on one sample of {dt:g} s; take times that are further apart.")
    return lags


def delay(series: Array, by: int, before: Array) -> Array:
    """A series (T, N), `by` samples later, with `before` (N,) until it begins."""
    by = min(by, len(series))
    return np.concatenate([np.broadcast_to(before, (by, series.shape[1])), series[: len(series) - by]])
