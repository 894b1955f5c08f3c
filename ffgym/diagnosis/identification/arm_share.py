r"""Share of friction behind a joint's elasticity, from its deflection at constant speeds in both directions.

The motor's torque tells friction on both sides alike, but the spring carries that of the arm alone, link side:

.. math:: \delta = -\frac{1}{K} (\tau - F) - \frac{s}{K} F - d\, \dot q + o

with the motor's torque behind the gearbox :math:`\tau`, of which friction takes F, the share s of F on the arm, the
delay d of the sensor and a constant o. What changes with the direction is :math:`2 s F / K`: K and s are told apart by
the load :math:`\tau - F`, where an encoder behind the gearbox sees it change, and by how well K is known before.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.identification.deflection import SteadyDeflection, measure_deflection, sees_deflection
from ffgym.diagnosis.identification.estimate import Estimate, Status, judge_estimate
from ffgym.diagnosis.identification.friction_data import FrictionTorque
from ffgym.diagnosis.resampling import Blocks, Intervals, bootstrap, intervals
from ffgym.diagnosis.settings import settings
from ffgym.robot import RobotDescription

NAME = "friction.arm_share"
"""Entry of the description."""

NOT_MEASURED = (
    "cannot be told without a tracker (tcp.position) or an encoder behind the gearbox (link.position): the motor's "
    "torque is the same wherever friction acts. Record slow_triangles or speed_ladder with one"
)
"""Reason where no sensor sees a deflection."""

_EXACT = 1e-6
"""Relative standard deviation that holds a stiffness where its prior has it."""

_MODEL_ERROR = 0.05
"""Share beyond 0 to 1 that springs or friction of another form may make; chosen: torsional hysteresis of 100 microrad
makes 0.01."""

_INFORMATIVE = 0.5
"""Scale of a share below which the width of its interval is judged against the scale itself: half of what it can be."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmShareFit:
    """Share of friction behind the elasticity of one joint, as deflections tell it."""

    share: float
    """s, 0 to 1 if the model holds; noise takes it beyond."""
    share_interval: Intervals
    """Of the share, before it is cut to 0 to 1, shape (1,)."""
    stiffness: Array
    """Estimate and ends of the interval of K [N m/rad], link side, shape (3,)."""
    lost_motion: float
    """Change of the deflection between both directions [rad], link side, mean of all windows."""
    delay: float
    """Time by which the sensor is late [s]."""
    unloads: bool
    """True if the spring's torque changes its sign, so that a gap would show as friction on the arm does."""
    rms_error: float
    """Of the deflection [rad]."""
    data: SteadyDeflection


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmShare:
    """Share of friction behind the elasticity of one joint."""

    estimate: Estimate
    fit: ArmShareFit | None
    """None if nothing sees a deflection at constant speed."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about what would look the same."""
        fit = self.fit
        if fit is None:
            return ()
        notes = []
        speeds = np.abs(fit.data.speed)
        if speeds.max() < settings().friction.speed_ratio * speeds.min():
            notes.append(
                "s: all constant speeds are alike, so that a sensor that is late would look the same; a speed_ladder "
                "tells its delay"
            )
        if fit.unloads and self.estimate.low > 0:
            notes.append(
                "s: the spring's torque changes its sign, so that a gap would pass for friction on the arm; it does "
                "not in a pose that loads the joint by more than its friction"
            )
        return tuple(notes)


def identify_arm_share(
    torques: Sequence[FrictionTorque],
    robot: RobotDescription,
    joint: int,
    presliding: float,
    rng: np.random.Generator,
    *,
    stiffness_spread: float | None,
    n_resamples: int,
    level: float,
) -> ArmShare | None:
    """Identify the share of one joint's friction on the arm; None for a rigid joint and without recordings.

    Args:
        torques: friction along recordings, with link encoders or a tracker.
        robot: the robot as it is described.
        joint: its number, from 0.
        presliding: f_s / sigma_0 [rad], motor side.
        rng: draws resamples, and the stiffness by its prior.
        stiffness_spread: relative standard deviation of the described stiffness; None is that of its interval, or that
            of descriptions in general.
        n_resamples: resamples behind the interval.
        level: probability of the interval.
    """
    if robot.drive.is_rigid[joint] or not torques:
        return None
    # a sensor behind the spring, and constant speeds both ways
    if not any(sees_deflection(torque, joint) for torque in torques):
        return ArmShare(estimate=describe_arm_share(robot, joint, "not measured", NOT_MEASURED), fit=None)
    data = measure_deflection(torques, joint, presliding)
    limits = settings().friction
    if data.n_runs < limits.fewest_runs or len(data.run) < 2 * data.n_runs:
        reason = (
            "no constant speeds in both directions at which a link encoder sees the joint, or a tracker, with the tool "
            "away from its axis and the other joints at rest"
        )
        return ArmShare(estimate=describe_arm_share(robot, joint, "not excited", reason), fit=None)
    spread = stiffness_spread if stiffness_spread is not None else _spread_of_description(robot, joint)
    fit = fit_arm_share(data, float(robot.drive.joint_stiffness[joint]), spread, rng, n_resamples, level)
    # a share lies from 0 to 1
    low, high = float(fit.share_interval.low[0]), float(fit.share_interval.high[0])
    if low > 1 + _MODEL_ERROR or high < -_MODEL_ERROR:
        size = f"the lost motion is {fit.share:.2g} times ({low:.2g} to {high:.2g}) what all friction would make"
        reason = f"{size}: a gap, a wrong sign or another stiffness is in it"
        return ArmShare(estimate=describe_arm_share(robot, joint, "at bound", reason), fit=fit)
    value, low, high = (min(max(number, 0.0), 1.0) for number in (fit.share, low, high))
    status, reason = judge_estimate(value, low, high, scale=_INFORMATIVE, excited="")
    described = describe_arm_share(robot, joint, status, reason)
    value = value if status == "identified" else described.value
    return ArmShare(estimate=replace(described, value=value, low=low, high=high), fit=fit)


def describe_arm_share(robot: RobotDescription, joint: int, status: Status, reason: str) -> Estimate:
    """Make an estimate that keeps the share of the description, of which the data tell nothing."""
    described = float(robot.arm_share[joint])
    return Estimate(
        name=NAME,
        joint=robot.joints[joint],
        unit="1",
        side="link",
        value=described,
        low=0.0,
        high=np.inf,
        prior=described,
        status=status,
        reason=reason,
    )


def _spread_of_description(robot: RobotDescription, joint: int) -> float:
    """Relative standard deviation of the described stiffness: from its 90 % interval, or that of descriptions."""
    quantity = robot.quantities.get("drive.joint_stiffness")
    if quantity is not None and quantity.interval is not None and np.isfinite(quantity.interval[joint]).all():
        low, high = quantity.interval[joint]
        return float((high - low) / (2 * 1.645 * robot.drive.joint_stiffness[joint]))
    return settings().friction.spring_error


def fit_arm_share(
    data: SteadyDeflection, stiffness: float, spread: float, rng: np.random.Generator, n_resamples: int, level: float
) -> ArmShareFit:
    """Fit load, friction, delay and constants to deflections, with priors of stiffness and delay.

    `stiffness` [N m/rad], link side, is known within the relative standard deviation `spread`.
    """
    table = _regressors(data, stiffness)
    n = table.shape[1]
    # noise of each record, from what a free fit leaves of it
    left = data.deflection - table @ np.linalg.lstsq(table, data.deflection, rcond=None)[0]
    count = np.bincount(data.record, minlength=data.n_records)
    noise = np.sqrt(np.bincount(data.record, left**2, data.n_records) / np.maximum(count - n / data.n_records, 1))
    root = 1 / np.maximum(noise, 1e-9)[data.record]
    rows, target = root[:, None] * table, root * data.deflection
    grams, moments = rows[:, :, None] * rows[:, None, :], rows * target[:, None]
    # priors of stiffness and delay
    precision, mean = np.zeros(n), np.zeros(n)
    # of a stiffness that is known exactly, or that a tracker does not tell, the prior is all
    told = spread > 0 and not data.by_tool.any()
    precision[[0, 2]] = 1 / (spread if told else _EXACT) ** 2, 1 / settings().friction.delay ** 2

    def solve(counts: Array, prior: Array) -> Array:
        gram = np.tensordot(counts, grams, axes=1) + np.diag(precision)
        scale = 1 / np.sqrt(np.diag(gram))
        moment = counts @ moments + precision * prior
        found: Array = scale * np.linalg.solve(gram * np.outer(scale, scale), scale * moment)
        return found

    mean[0] = 1.0
    best = solve(np.ones(len(target)), mean)
    blocks = Blocks(of_row=np.arange(len(data.run)), stratum=data.run)

    def resample(counts: Array) -> Array:
        # priors are drawn anew: what they add is as uncertain as they are
        drawn = np.zeros(n)
        drawn[0] = np.exp(spread * rng.normal())
        drawn[2] = settings().friction.delay * rng.normal()
        x = solve(counts, drawn)
        return np.array([x[1] / x[0], stiffness / x[0]])

    values = np.array([best[1] / best[0], stiffness / best[0]])
    span = intervals(values, bootstrap(resample, blocks, rng, n_resamples), level, widened=settings().friction.widened)
    ends = np.stack([values, span.low, span.high], axis=1)
    return ArmShareFit(
        share=float(values[0]),
        share_interval=Intervals(low=span.low[:1], high=span.high[:1]),
        stiffness=ends[1],
        lost_motion=float(2 * best[1] / stiffness * np.abs(data.friction).mean()),
        delay=float(best[2]),
        unloads=_unloads(data, float(values[0])),
        rms_error=rms(data.deflection - table @ best),
        data=data,
    )


def _regressors(data: SteadyDeflection, stiffness: float) -> Array:
    """Regressors of the deflection, shape (R, P).

    Compliance and its product with the share, both relative to the described compliance; delay; a constant of each
    record, and for those of a tracker a slope and a bend: its frame differs from the robot's by some 0.1 mm, of which
    the arc shows the part along it, and the springs of other joints give way to loads that change.
    """
    columns = [-(data.torque - data.friction) / stiffness, -data.friction / stiffness, -data.speed]
    for record, by_tool in enumerate(data.by_tool):
        own = data.record == record
        columns.append(own.astype(np.float64))
        if by_tool:
            columns += [own * data.position, own * data.position**2]
    return np.stack(columns, axis=1)


def _unloads(data: SteadyDeflection, share: float) -> bool:
    """Tell if the spring's torque changes its sign in a record, so that a joint with a gap would cross it."""
    spring = data.torque - data.friction + min(max(share, 0.0), 1.0) * data.friction
    records = [spring[data.record == record] for record in range(data.n_records)]
    return any(own.min() < 0 < own.max() for own in records)
