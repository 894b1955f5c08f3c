"""What both fits say about each parameter of a joint's friction, and which of it is to be believed."""

from collections.abc import Sequence

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification.bristle_fit import BLOCK, INERTIA_ERROR, MIN_BLOCKS, NAMES, BristleFit
from ffgym.diagnosis.identification.estimate import Estimate, Status, judged
from ffgym.diagnosis.identification.resampling import intervals
from ffgym.diagnosis.identification.stribeck_fit import StribeckFit

UNITS = dict(zip(NAMES, ("N m", "N m", "N m s/rad", "rad/s", "N m/rad", "N m s/rad"), strict=True))
"""Of the parameters, motor side."""

_MATTERS = 0.1
"""Share of the Coulomb torque below which a viscous torque at the fastest speed does not matter."""


Row = tuple[float, float, float, Status, str]
"""Value, interval, status and reason of one parameter."""


def static_estimates(
    joint: str, prior: Array, stribeck: StribeckFit | None, *, given: float | None, level: float
) -> tuple[Estimate, ...]:
    """Estimates of f_c, f_s, f_v, v_s of a joint.

    Args:
        joint: its name.
        prior: values of the description, in the order of NAMES, shape (6,).
        stribeck: fit to constant speeds; None if there are too few.
        given: v_s if the caller fixed it.
        level: probability of the intervals.
    """
    rows = _static(prior, stribeck, given, level)
    coulomb, static = rows[0][0], rows[1]
    if (
        static[0] < coulomb
    ):  # the breakaway torque that stays from before does not fit the Coulomb torque that was found
        rows[1] = (coulomb, *static[1:4], f"{static[4]}; raised to the Coulomb torque")
    return _estimates(joint, NAMES[:4], prior[:4], rows)


def dynamic_estimates(
    joint: str, prior: Array, bristles: BristleFit | None, *, reverses: bool, level: float
) -> tuple[Estimate, ...]:
    """Estimates of sigma_0, sigma_1 of a joint.

    Args:
        joint: its name.
        prior: values of the description, in the order of NAMES, shape (6,).
        bristles: fit to reversals; None if the data do not serve for one.
        reverses: whether there are records in which it turns back between slides.
        level: probability of the intervals.
    """
    if bristles is None:
        reason = "f_c is not identified, on which bristles rest" if reverses else "no record in which it reverses"
        return _estimates(joint, NAMES[4:], prior[4:], [_unknown(before, reason) for before in prior[4:]])
    return _estimates(joint, NAMES[4:], prior[4:], _dynamic(prior, bristles, level))


def _estimates(joint: str, names: Sequence[str], prior: Array, rows: Sequence[Row]) -> tuple[Estimate, ...]:
    return tuple(
        Estimate(
            name=f"friction.{name}",
            joint=joint,
            unit=UNITS[name],
            side="motor",
            value=value,
            low=low,
            high=high,
            prior=float(before),
            status=status,
            reason=reason,
        )
        for name, before, (value, low, high, status, reason) in zip(names, prior, rows, strict=True)
    )


def _unknown(before: float, reason: str) -> Row:
    return float(before), 0.0, np.inf, "not excited", reason


def _static(prior: Array, stribeck: StribeckFit | None, given: float | None, level: float) -> list[Row]:
    """f_c, f_s, f_v, v_s."""
    if stribeck is None:
        return [_unknown(before, "too few constant speeds") for before in prior[:4]]
    span = intervals(stribeck.values, stribeck.resampled[:, :4], level)
    fastest = float(np.abs(stribeck.data.speed).max())
    scales = dict(zip(NAMES[:4], (0.0, 0.0, _MATTERS * stribeck.values[0] / fastest, 0.0), strict=True))
    rows: list[Row] = []
    for i, name in enumerate(NAMES[:4]):
        value, low, high = float(stribeck.values[i]), float(span.low[i]), float(span.high[i])
        status, reason = judged(value, low, high, scale=scales[name], excited=stribeck.lacking[name])
        if name == "stribeck_velocity" and given is not None:
            status, reason, low, high = "given", "kept as given", 0.0, np.inf
        rows.append(_row(value, low, high, status, reason, float(prior[i])))
    return rows


def _dynamic(prior: Array, bristles: BristleFit, level: float) -> list[Row]:
    """sigma_0 and sigma_1: where one ends at a bound, the other is not the data's either."""
    span = intervals(bristles.values, bristles.resampled, level)
    short = ""
    if bristles.n_blocks < MIN_BLOCKS:
        short = f"its records last less than {MIN_BLOCKS * BLOCK:g} s, too little for an interval"
    rows: list[Row] = []
    for i in range(2):
        value, low, high = float(bristles.values[i]), float(span.low[i]), float(span.high[i])
        status, reason = judged(value, low, high, scale=0.0, excited=short, at_bound=bool(bristles.at_bound[i]))
        if status == "identified" and bristles.at_bound.any():
            status, reason = "at bound", "the fit ends at the bound of the other bristle parameter"
        if status == "identified" and bristles.inertia_at_bound:
            status, reason = "at bound", f"the inertia of the model seems wrong by {INERTIA_ERROR:.0%} or more"
        rows.append(_row(value, low, high, status, reason, float(prior[4 + i])))
    return rows


def _row(value: float, low: float, high: float, status: Status, reason: str, before: float) -> Row:
    """An identified value with its interval, or the one before with nothing known."""
    if status in ("identified", "given"):
        return value, low, high, status, reason
    return (before, 0.0, np.inf, status, reason) if status != "wide" else (before, low, high, status, reason)
