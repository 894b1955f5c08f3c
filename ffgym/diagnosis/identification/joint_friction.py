"""Friction of one joint: constant speeds first, reversals next, and once more with the bristles that were found."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification.arm_share import ArmShare, identify_arm_share
from ffgym.diagnosis.identification.bristle_fit import NAMES, BristleFit, fit_bristles, reverses, sliding_data
from ffgym.diagnosis.identification.estimate import Estimate, Status, judge_estimate
from ffgym.diagnosis.identification.friction_data import FrictionTorque
from ffgym.diagnosis.identification.stribeck_fit import StribeckFit, fit_stribeck, steady_friction
from ffgym.diagnosis.resampling import intervals
from ffgym.diagnosis.settings import settings
from ffgym.robot import RobotDescription

UNITS = dict(zip(NAMES, ("N m", "N m", "N m s/rad", "rad/s", "N m/rad", "N m s/rad"), strict=True))
"""Of the parameters, motor side."""


@dataclass(frozen=True, kw_only=True, eq=False)
class JointFriction:
    """Friction that was found of one joint."""

    joint: str
    estimates: tuple[Estimate, ...]
    """In the order of NAMES."""
    stribeck: StribeckFit | None
    """Fit to constant speeds; None if there were too few."""
    bristles: BristleFit | None
    """Fit to reversals; None if there were none."""
    arm: ArmShare | None = None
    """Share of friction behind the elasticity; None for a rigid joint, which has one side, or one not asked for."""

    @property
    def inertia_error(self) -> float:
        """Share of the model's inertial torque that was missing, 0 if that is not known."""
        return 0.0 if self.bristles is None else self.bristles.inertia_error

    @property
    def link_error(self) -> float:
        """Share of the links' masses that was missing beyond that, 0 if that is not known."""
        return 0.0 if self.bristles is None else self.bristles.link_error

    @property
    def spring_error(self) -> float:
        """Share of the joint stiffness that was missing, 0 if that is not known."""
        return 0.0 if self.bristles is None else self.bristles.spring_error

    @property
    def lag(self) -> float:
        """Time by which friction follows the motion [s], 0 if that is not known."""
        return 0.0 if self.bristles is None else self.bristles.lag

    @property
    def delay(self) -> float:
        """Time by which the torque acts later than recorded [s], 0 if that is not known."""
        return 0.0 if self.bristles is None else self.bristles.delay

    @property
    def offset(self) -> float:
        """Mean torque in reversals that nothing explains [N m], 0 if that is not known."""
        return 0.0 if self.bristles is None else self.bristles.offset

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about what the LuGre model does not have, or the data do not tell."""
        notes, fit = [], self.stribeck
        if fit is not None:
            if not fit.both_directions:
                notes.append("it ran in one direction only: an error of gravity or an offset counts as friction")
            low, high = np.quantile(fit.resampled[:, 4:], [0.05, 0.95], axis=0)
            if low[0] > 0 or high[0] < 0:
                notes.append(f"both directions differ by an offset of {fit.offset:.3g} N m, which is not in the model")
            if low[1] > 0 or high[1] < 0:
                notes.append(f"viscous friction differs between directions by +-{abs(fit.asymmetry):.3g} N m s/rad")
        if self.bristles is not None and self.bristles.inertia_at_bound:
            notes.append(f"{_wrong_inertia()}: correct it, then identify again")
        if self.bristles is not None and self.bristles.held:
            notes.append(
                f"the corrections of {' and of '.join(self.bristles.held)} lie at their bounds: the model of the arm "
                "or its records are wrong in another way, which intervals of sigma_0 and sigma_1 do not count"
            )
        return (*notes, *(() if self.arm is None else self.arm.notes))


def _wrong_inertia() -> str:
    return f"the inertia of the model seems wrong by {settings().friction.inertia_error:.0%} or more"


def identify_joint(
    torques: Sequence[FrictionTorque],
    robot: RobotDescription,
    joint: int,
    rng: np.random.Generator,
    *,
    stribeck_velocity: float | None,
    stiffness_spread: float | None,
    n_resamples: int,
    level: float,
) -> JointFriction:
    """Identify the friction of one `joint` along recordings, twice; no recordings leave it as it is described.

    How far bristles bend decides which rows are steady sliding. The first time that is what the description says; the
    second time what was found, if that is further. A `stribeck_velocity` [rad/s], motor side, is kept as given;
    `stiffness_spread` is the relative standard deviation of the joint stiffness, see `identify_arm_share`.
    """
    limits = settings().friction
    name, prior = robot.joints[joint], np.array([getattr(robot.friction, parameter)[joint] for parameter in NAMES])

    def fit_once(presliding: float, n_resamples: int, start: Array | None) -> JointFriction:
        # the static curve from constant speeds
        steady = steady_friction(torques, joint, presliding)
        stribeck = None
        if steady.n_runs >= limits.fewest_runs:
            stribeck = fit_stribeck(
                steady,
                rng,
                stribeck_velocity=stribeck_velocity,
                usual_velocity=float(prior[3]),
                n_resamples=n_resamples,
            )
        static = _static_estimates(name, prior, stribeck, stribeck_velocity, level)
        # bristles from reversals, beside the static parameters as far as they were identified
        reversing = [torque for torque in torques if reverses(torque, joint, presliding)]
        bristles = None
        if stribeck is not None and reversing and static[0].is_identified:
            values = np.array([estimate.value for estimate in static])
            told = [estimate.is_identified for estimate in static]
            spread = np.where(told, stribeck.resampled[:, :4], values)
            bristles = fit_bristles(sliding_data(reversing, joint, presliding), values, spread, rng, start)
        missing = "f_c is not identified, on which bristles rest" if reversing else "no record in which it reverses"
        estimates = (*static, *_dynamic_estimates(name, prior, bristles, missing, level))
        return JointFriction(joint=name, estimates=estimates, stribeck=stribeck, bristles=bristles)

    described = float(prior[1] / prior[4])
    first = fit_once(described, limits.first_resamples, None)
    start = None if first.bristles is None else first.bristles.values
    presliding = max(described, first.estimates[1].value / first.estimates[4].value)
    found = fit_once(presliding, n_resamples, start)
    arm = identify_arm_share(
        torques,
        robot,
        joint,
        presliding,
        rng,
        stiffness_spread=stiffness_spread,
        n_resamples=n_resamples,
        level=level,
    )
    return replace(found, arm=arm)


def _static_estimates(
    joint: str, prior: Array, fit: StribeckFit | None, given: float | None, level: float
) -> list[Estimate]:
    """Estimates of f_c, f_s, f_v, v_s, beside the description's `prior` (6,); v_s may be `given` by the caller."""
    if fit is None:
        return [_estimate(joint, i, prior, "not excited", "too few constant speeds") for i in range(4)]
    span = intervals(fit.values, fit.resampled[:, :4], level, widened=settings().friction.widened)
    fastest = float(np.abs(fit.data.speed).max())
    found = []
    for i, name in enumerate(NAMES[:4]):
        value, low, high = float(fit.values[i]), max(float(span.low[i]), 0.0), float(span.high[i])
        scale = settings().friction.matters * fit.values[0] / fastest if name == "viscous" else 0.0
        status, reason = judge_estimate(value, low, high, scale=scale, excited=fit.lacking[name])
        if name == "stribeck_velocity" and given is not None:
            status, reason, low, high = "given", "kept as given", 0.0, np.inf
        found.append(_estimate(joint, i, prior, status, reason, value, low, high))
    # the breakaway torque that stays from before may not fit the Coulomb torque that was found
    if found[1].value < found[0].value:
        reason = f"{found[1].reason}; raised to the Coulomb torque"
        found[1] = replace(found[1], value=found[0].value, reason=reason)
    return found


def _dynamic_estimates(joint: str, prior: Array, fit: BristleFit | None, missing: str, level: float) -> list[Estimate]:
    """Estimates of sigma_0, sigma_1: where one ends at a bound, the other is not the data's either.

    `missing` says why there is no fit, if there is none.
    """
    if fit is None:
        return [_estimate(joint, i, prior, "not excited", missing) for i in (4, 5)]
    span = intervals(fit.values, fit.resampled, level, widened=settings().friction.widened)
    limits, short = settings().friction, ""
    if fit.n_blocks < limits.fewest_blocks:
        short = f"its records last less than {limits.fewest_blocks * limits.block:g} s, too little for an interval"
    found = []
    for i in range(2):
        value, low, high = float(fit.values[i]), max(float(span.low[i]), 0.0), float(span.high[i])
        status, reason = judge_estimate(value, low, high, scale=0.0, excited=short, at_bound=bool(fit.at_bound[i]))
        if status == "identified" and fit.at_bound.any():
            status, reason = "at bound", "the fit ends at the bound of the other bristle parameter"
        if status == "identified" and fit.inertia_at_bound:
            status, reason = "at bound", _wrong_inertia()
        found.append(_estimate(joint, 4 + i, prior, status, reason, value, low, high))
    return found


def _estimate(
    joint: str,
    i: int,
    prior: Array,
    status: Status,
    reason: str,
    value: float = 0.0,
    low: float = 0.0,
    high: float = np.inf,
) -> Estimate:
    """An identified value with its interval, or the one before, of which nothing is known unless it is wide."""
    name, before = NAMES[i], float(prior[i])
    has_interval = status in ("identified", "given", "wide")
    return Estimate(
        name=f"friction.{name}",
        joint=joint,
        unit=UNITS[name],
        side="motor",
        value=value if status in ("identified", "given") else before,
        low=low if has_interval else 0.0,
        high=high if has_interval else np.inf,
        prior=before,
        status=status,
        reason=reason,
    )
