"""What a NARX network sees: present and past speeds, slip elements, its own past outputs."""

from collections.abc import Sequence
from dataclasses import dataclass

from ffgym.core.errors import FFGymError, check_number, check_whole


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
        """How many follow from the speed alone."""
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
