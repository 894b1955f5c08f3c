"""Friction of one joint: constant speeds first, reversals next, and once more with the bristles that were found."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification.bristle_fit import BLOCK, INERTIA_ERROR, MIN_BLOCKS, NAMES, BristleFit, fit_bristles
from ffgym.diagnosis.identification.friction_data import FrictionTorque
from ffgym.diagnosis.identification.resampling import LEVEL, RESAMPLES, Estimate, Status, intervals, judged
from ffgym.diagnosis.identification.sliding_data import sliding_data
from ffgym.diagnosis.identification.steady import reverses, steady_friction
from ffgym.diagnosis.identification.stribeck_fit import MIN_RUNS, StribeckFit, fit_stribeck
from ffgym.robot import RobotDescription

UNITS = dict(zip(NAMES, ("N m", "N m", "N m s/rad", "rad/s", "N m/rad", "N m s/rad"), strict=True))
"""Of the parameters, motor side."""

_MATTERS = 0.1
"""Share of the Coulomb torque below which a viscous torque at the fastest speed does not matter."""


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
    if stribeck is None:
        return tuple(
            _estimate(joint, i, prior, 0.0, 0.0, np.inf, "not excited", "too few constant speeds") for i in range(4)
        )
    span = intervals(stribeck.values, stribeck.resampled[:, :4], level)
    fastest = float(np.abs(stribeck.data.speed).max())
    found = []
    for i, name in enumerate(NAMES[:4]):
        value, low, high = float(stribeck.values[i]), float(span.low[i]), float(span.high[i])
        scale = _MATTERS * stribeck.values[0] / fastest if name == "viscous" else 0.0
        status, reason = judged(value, low, high, scale=scale, excited=stribeck.lacking[name])
        if name == "stribeck_velocity" and given is not None:
            status, reason, low, high = "given", "kept as given", 0.0, np.inf
        found.append(_estimate(joint, i, prior, value, low, high, status, reason))
    # the breakaway torque that stays from before may not fit the Coulomb torque that was found
    if found[1].value < found[0].value:
        reason = f"{found[1].reason}; raised to the Coulomb torque"
        found[1] = replace(found[1], value=found[0].value, reason=reason)
    return tuple(found)


def dynamic_estimates(
    joint: str, prior: Array, bristles: BristleFit | None, *, reverses: bool, level: float
) -> tuple[Estimate, ...]:
    """Estimates of sigma_0, sigma_1 of a joint: where one ends at a bound, the other is not the data's either.

    Args:
        joint: its name.
        prior: values of the description, in the order of NAMES, shape (6,).
        bristles: fit to reversals; None if the data do not serve for one.
        reverses: whether there are records in which it turns back between slides.
        level: probability of the intervals.
    """
    if bristles is None:
        reason = "f_c is not identified, on which bristles rest" if reverses else "no record in which it reverses"
        return tuple(_estimate(joint, i, prior, 0.0, 0.0, np.inf, "not excited", reason) for i in (4, 5))
    span = intervals(bristles.values, bristles.resampled, level)
    short = ""
    if bristles.n_blocks < MIN_BLOCKS:
        short = f"its records last less than {MIN_BLOCKS * BLOCK:g} s, too little for an interval"
    found = []
    for i in range(2):
        value, low, high = float(bristles.values[i]), float(span.low[i]), float(span.high[i])
        status, reason = judged(value, low, high, scale=0.0, excited=short, at_bound=bool(bristles.at_bound[i]))
        if status == "identified" and bristles.at_bound.any():
            status, reason = "at bound", "the fit ends at the bound of the other bristle parameter"
        if status == "identified" and bristles.inertia_at_bound:
            status, reason = "at bound", f"the inertia of the model seems wrong by {INERTIA_ERROR:.0%} or more"
        found.append(_estimate(joint, 4 + i, prior, value, low, high, status, reason))
    return tuple(found)


def _estimate(
    joint: str, i: int, prior: Array, value: float, low: float, high: float, status: Status, reason: str
) -> Estimate:
    """An identified value with its interval, or the one before, of which nothing is known unless it is wide."""
    before = float(prior[i])
    if status not in ("identified", "given"):
        value = before
    if status not in ("identified", "given", "wide"):
        low, high = 0.0, np.inf
    name = NAMES[i]
    return Estimate(
        name=f"friction.{name}",
        joint=joint,
        unit=UNITS[name],
        side="motor",
        value=value,
        low=low,
        high=high,
        prior=before,
        status=status,
        reason=reason,
    )


_FIRST = 20
"""Resamples of the first time, which are only to tell what is identified."""


@dataclass(frozen=True, kw_only=True)
class FitOptions:
    """How the friction of a joint is fitted."""

    stribeck_velocity: float | None = None
    """v_s to keep [rad/s], motor side; None estimates it."""
    n_resamples: int = RESAMPLES
    """Resamples behind the intervals."""
    level: float = LEVEL
    """Probability of the intervals."""


@dataclass(frozen=True, kw_only=True, eq=False)
class JointFriction:
    """What was found about one joint."""

    joint: str
    estimates: tuple[Estimate, ...]
    """In the order of NAMES."""
    stribeck: StribeckFit | None
    """Fit to constant speeds; None if there were too few."""
    bristles: BristleFit | None
    """Fit to reversals; None if there were none."""
    notes: tuple[str, ...] = ()
    """What the user should know."""

    @property
    def inertia_error(self) -> float:
        """Share of the model's inertial torque that was missing, 0 if that is not known."""
        return 0.0 if self.bristles is None else self.bristles.inertia_error

    @property
    def offset(self) -> float:
        """Mean torque in reversals that nothing explains [N m], 0 if that is not known."""
        return 0.0 if self.bristles is None else self.bristles.offset


def identify_joint(
    torques: Sequence[FrictionTorque],
    robot: RobotDescription,
    joint: int,
    options: FitOptions,
    rng: np.random.Generator,
) -> JointFriction:
    """Identify the friction of one joint, twice.

    How far bristles bend decides which rows are steady sliding. The first time that is what the description says; the
    second time what was found, if that is further.

    Args:
        torques: friction along recordings; none leaves everything as it is described.
        robot: its description.
        joint: which joint, 0 is the first.
        options: how it is fitted.
        rng: draws starts and resamples.
    """
    friction = robot.friction
    described = float(friction.static[joint] / friction.bristle_stiffness[joint])
    first = _fitted(torques, robot, joint, replace(options, n_resamples=_FIRST), rng, described)
    values = {estimate.name: estimate.value for estimate in first.estimates}
    found = values["friction.static"] / values["friction.bristle_stiffness"]
    start = None if first.bristles is None else first.bristles.values
    return _fitted(torques, robot, joint, options, rng, max(described, found), start)


def _fitted(
    torques: Sequence[FrictionTorque],
    robot: RobotDescription,
    joint: int,
    options: FitOptions,
    rng: np.random.Generator,
    presliding: float,
    start: Array | None = None,
) -> JointFriction:
    """Both fits, and what is to be said about each parameter."""
    name, level, given = robot.joints[joint], options.level, options.stribeck_velocity
    prior = np.array([getattr(robot.friction, parameter)[joint] for parameter in NAMES])
    steady = steady_friction(torques, joint, presliding)
    stribeck = None
    if steady.n_runs >= MIN_RUNS:
        stribeck = fit_stribeck(
            steady, rng, stribeck_velocity=given, usual_velocity=float(prior[3]), n_resamples=options.n_resamples
        )
    static = static_estimates(name, prior, stribeck, given=given, level=level)
    reversing = [torque for torque in torques if reverses(torque, joint, presliding)]
    bristles = None
    if reversing and static[0].is_identified:
        spread = _static_spread(static, stribeck, options.n_resamples)
        bristles = fit_bristles(sliding_data(reversing, joint, presliding), *spread, rng, start)
    return JointFriction(
        joint=name,
        estimates=(*static, *dynamic_estimates(name, prior, bristles, reverses=bool(reversing), level=level)),
        stribeck=stribeck,
        bristles=bristles,
        notes=tuple(_notes(stribeck, bristles)),
    )


def _static_spread(static: Sequence[Estimate], stribeck: StribeckFit | None, n_resamples: int) -> tuple[Array, Array]:
    """Static parameters to go on with, shape (4,), and resamples of those that were identified, shape (B, 4)."""
    values = np.array([estimate.value for estimate in static])
    spread = np.tile(values, (n_resamples, 1))
    for i, estimate in enumerate(static):
        if stribeck is not None and estimate.is_identified:
            spread[:, i] = stribeck.resampled[:, i]
    return values, spread


def _notes(stribeck: StribeckFit | None, bristles: BristleFit | None) -> Iterator[str]:
    """What the fits found that the LuGre model does not have, or could not tell."""
    if stribeck is not None:
        if not stribeck.both_directions:
            yield "it ran in one direction only: an error of gravity or an offset counts as friction"
        low, high = np.quantile(stribeck.resampled[:, 4:], [0.05, 0.95], axis=0)
        if low[0] > 0 or high[0] < 0:
            yield f"both directions differ by an offset of {stribeck.offset:.3g} N m, which is not in the model"
        if low[1] > 0 or high[1] < 0:
            yield f"viscous friction differs between directions by +-{abs(stribeck.asymmetry):.3g} N m s/rad"
    if bristles is not None and bristles.inertia_at_bound:
        yield f"the inertia of the model seems wrong by {INERTIA_ERROR:.0%} or more: correct it, then identify again"
