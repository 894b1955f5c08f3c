r"""Gains of a servo, from motor torque that was recorded beside set-points and motor angles.

The servo's equation (`ffgym.diagnosis.identification.servo_equation`) is linear in its gains, axis by axis. Measured
angles are noisy and stepped, so that least squares find gains that are too small (errors in variables). The terms are
therefore multiplied by instruments: the same terms of the simulated robot along the same set-points, which know nothing
of the noise. A wrong model makes intervals wider, and does not move what is found.

Intervals are from a bootstrap over blocks of time, with delay and filter drawn from theirs. A gain whose interval says
nothing keeps its documented value, and the others are found with it. What is found is judged on samples that were left
out.

Source: instrumental variables in closed loop (Gilson and Van den Hof, Automatica 41, 2005; Young, Recursive Estimation
and Time-Series Analysis, 2011). Departure: the model behind the instruments is physical.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from ffgym.control import SetpointResponse
from ffgym.core.types import Array
from ffgym.diagnosis.identification.estimate import Estimate, judge_estimate
from ffgym.diagnosis.identification.servo_equation import TERMS, ServoLog, ServoRows
from ffgym.diagnosis.identification.setpoint_response import NAMES, make_response, to_parameters
from ffgym.diagnosis.resampling import RESAMPLES, Blocks, bootstrap, intervals
from ffgym.robot.parts import Servo

GAINS = ("position_gain", "velocity_gain", "integral_gain")
"""Gains in the order of their terms."""
_UNITS = {"position_gain": "N m/rad", "velocity_gain": "N m s/rad", "integral_gain": "N m/(rad s)"}
_HINTS = {
    "position_gain": "record a motion with more sines between 1 and 10 Hz",
    "velocity_gain": "record a faster motion, or torque with less noise",
    "integral_gain": "record a longer or slower motion",
}
_LEVEL = 0.95
"""Probability of intervals, as of delay and filter."""
_MODEL_ERROR = 0.03
"""Share of a gain by which intervals are longer at either end; chosen: half a sample by which drives make speeds late,
and set-points that they join otherwise, move gains by up to as much."""
_EXPLAINED = 0.5
"""Share of the variance of left-out torque below which the equation does not hold (chosen)."""
_FEWEST = 100
"""Rows of an axis below which nothing is fitted (chosen)."""
_FOLDS = 5
_STARTS = (5.0, 12.0, 25.0, 50.0)
"""Delays from which the search for delay and filter begins [ms] (chosen)."""
_UNKNOWN = np.full(TERMS, np.nan)


@dataclass(frozen=True, kw_only=True, eq=False)
class ServoFit:
    """Gains of a servo as recordings show them, motor side."""

    servo: Servo
    """Servo with the gains that were found, and documented ones where they were not."""
    estimates: tuple[tuple[Estimate, ...], ...]
    """Estimates of `GAINS` of each joint."""
    explained: Array
    """Explained share of the variance of the torque of left-out samples, shape (N,); NaN for joints at rest."""
    feedforward: Array
    """Factors of the documented rigid feed-forward, shape (N,); NaN where none was fitted."""

    def unlike_documented(self, servo: Servo) -> Servo:
        """Return the documented servo with gains that were found where their interval does not hold the documented."""
        gains = np.array(
            [
                [each.prior if each.low <= each.prior <= each.high else each.value for each in joint]
                for joint in self.estimates
            ]
        )
        position, velocity, integral = gains.T
        return replace(servo, position_gain=position, velocity_gain=velocity, integral_gain=integral)

    @property
    def refused(self) -> list[Estimate]:
        """Estimates of gains that the recordings do not tell."""
        return [each for joint in self.estimates for each in joint if not each.is_identified]


@dataclass(frozen=True, kw_only=True, eq=False)
class SearchedResponse:
    """Delay and filter with which the servo's equation leaves least torque."""

    response: SetpointResponse
    covariance: Array
    """Covariance of delay [s], lag [s] and curvature [s^2], shape (3, 3)."""
    total_spread: float
    """Standard deviation of delay and lag together [s]."""


def search_response(logs: Sequence[ServoLog]) -> SearchedResponse:
    """Search delay and filter with which the equation of all axes leaves least torque; least squares, no model.

    Args:
        logs: recordings in which some joint moves.
    """
    joints = np.flatnonzero(np.any([log.moves for log in logs], axis=0)).tolist()

    def left(values: Array) -> Array:
        response = make_response(values, 3)
        terms = [log.terms(response) for log in logs]
        found = []
        for j in joints:
            rows = ServoRows.of(logs, terms, terms, j)
            solved = np.linalg.lstsq(rows.terms, rows.torque, rcond=None)[0]
            found.append((rows.torque - rows.terms @ solved) / np.std(rows.torque))
        return np.concatenate(found)

    # coordinates of `make_response`, from the best of several delays
    starts = [np.array([total, total / 3, total**2 / 36]) for total in _STARTS]
    best = min(starts, key=lambda start: float((left(start) ** 2).sum()))
    solved = scipy.optimize.least_squares(
        left,
        best,
        bounds=([0.0, 0.1, -5000.0], [200.0, 100.0, 5000.0]),
        x_scale=(1.0, 1.0, 10.0),
        diff_step=(1e-3,) * 3,
        ftol=1e-6,
        max_nfev=40,
    )
    # scores summed over blocks of time, as residuals are not independent
    terms = [log.terms(make_response(solved.x, 3)) for log in logs]
    blocks = Blocks.joined([ServoRows.of(logs, terms, terms, j).blocks for j in joints])
    jacobian = np.asarray(solved.jac, dtype=np.float64)
    sums, inverse = blocks.sums(jacobian * solved.fun[:, None]), np.linalg.pinv(jacobian.T @ jacobian)
    covariance = inverse @ (sums.T @ sums) @ inverse
    return SearchedResponse(
        response=make_response(solved.x, 3),
        covariance=to_parameters(solved.x, covariance),
        total_spread=float(1e-3 * np.sqrt(covariance[0, 0])),
    )


def fit_servo(
    logs: Sequence[ServoLog],
    servo: Servo,
    response: SetpointResponse,
    rng: np.random.Generator,
    *,
    joints: Sequence[str],
    covariance: Array | None = None,
    instruments: Sequence[ServoLog] | None = None,
) -> ServoFit:
    """Fit the gains of each axis.

    Args:
        logs: recordings of one controller.
        servo: servo as it is documented, which is kept where nothing is found.
        response: delay and filter of the controller.
        rng: draws resamples.
        joints: names of the joints.
        covariance: that of delay [s], lag [s] and curvature [s^2], as many as are known, shape (K, K).
        instruments: the same recordings with angles that have no noise; None takes the measured ones, which is least
            squares.
    """
    cov = np.zeros((0, 0)) if covariance is None else covariance
    spread = np.sqrt(np.diag(cov))
    unsure = np.flatnonzero(spread)  # parameters that end at a bound are not
    cov = cov[np.ix_(unsure, unsure)]
    # terms for the response, and for each of its parameters a little larger
    shifted = [response, *(_shift(response, NAMES[i], float(spread[i])) for i in unsure.tolist())]
    own = [[log.terms(each) for log in logs] for each in shifted]
    free = own if instruments is None else [[log.terms(each) for log in instruments] for each in shifted]
    axes = []
    for j, joint in enumerate(joints):
        rows = [ServoRows.of(logs, *each, j) for each in zip(own, free, strict=True)] if _moves(logs, j) else []
        documented = np.array([getattr(servo, name)[j] for name in GAINS])
        axes.append(_fit_axis(rows, documented, joint, cov, rng))
    estimates = tuple(axis.estimates for axis in axes)
    position, velocity, integral = np.array([[each.value for each in joint] for joint in estimates]).T
    return ServoFit(
        servo=replace(servo, position_gain=position, velocity_gain=velocity, integral_gain=integral),
        estimates=estimates,
        explained=np.array([axis.explained for axis in axes]),
        feedforward=np.array([axis.feedforward for axis in axes]),
    )


def _moves(logs: Sequence[ServoLog], joint: int) -> bool:
    """Tell if enough rows count for a joint that moves."""
    count = sum(int(log.counts[:, joint].sum()) for log in logs if log.moves[joint])
    return count >= _FEWEST and all(log.counts[:, joint].any() for log in logs)


def _shift(response: SetpointResponse, name: str, step: float) -> SetpointResponse:
    """Return a response with one parameter larger by a step."""
    return replace(response, **{name: getattr(response, name) + step})


@dataclass(frozen=True, kw_only=True, eq=False)
class _Axis:
    estimates: tuple[Estimate, ...]
    explained: float = np.nan
    feedforward: float = np.nan


def _fit_axis(
    rows: Sequence[ServoRows], documented: Array, joint: str, covariance: Array, rng: np.random.Generator
) -> _Axis:
    """Fit one axis from its rows for the response, and for each of its parameters a little larger."""
    if not rows:
        why = "the joint rests, or too few rows count; record a motion of all joints"
        return _Axis(estimates=tuple(_refuse(i, documented, joint, "not excited", why) for i in range(len(GAINS))))
    explained = _explain(rows[0])
    if explained < _EXPLAINED:
        why = (
            f"the servo's equation explains {explained:.0%} of the torque of left-out samples: it is another torque, "
            f"or at another time, or angles are noisier than the error, or the controller is made otherwise"
        )
        refused = tuple(_refuse(i, documented, joint, "not measured", why) for i in range(len(GAINS)))
        return _Axis(estimates=refused, explained=explained)
    # gains that the data do not tell are held at their documented values, one after the other
    held, refusals = _UNKNOWN.copy(), dict[int, Estimate]()
    while True:
        judged = _judge(rows, held, documented, joint, covariance, rng)
        wide = {i: each for i, each in judged.items() if not each.is_identified}
        if not wide:
            break
        width = {i: (each.high - each.low) / max(float(documented[i]), 1e-12) for i, each in wide.items()}
        worst = max(width, key=lambda i: width[i])
        refusals[worst] = replace(wide[worst], value=float(documented[worst]))
        held[worst] = documented[worst]
    factor = rows[0].solve(np.ones(rows[0].blocks.n_blocks), held)[-1]
    return _Axis(
        estimates=tuple((judged | refusals)[i] for i in range(len(GAINS))),
        explained=explained,
        feedforward=float(factor) if rows[0].terms[:, -1].any() else np.nan,
    )


def _judge(
    rows: Sequence[ServoRows],
    held: Array,
    documented: Array,
    joint: str,
    covariance: Array,
    rng: np.random.Generator,
) -> dict[int, Estimate]:
    """Estimate the gains that are not held, with intervals, and judge them."""
    first, *others = rows
    ones, free = np.ones(first.blocks.n_blocks), [i for i in range(len(GAINS)) if np.isnan(held[i])]
    value = first.solve(ones, held)
    resampled = bootstrap(lambda weights: first.solve(weights, held), first.blocks, rng)
    if others:  # what delay and filter add, which are not known exactly
        spread = np.sqrt(np.diag(covariance))
        slopes = np.stack(
            [(other.solve(ones, held) - value) / step for other, step in zip(others, spread, strict=True)]
        )
        resampled = resampled + rng.multivariate_normal(np.zeros(len(others)), covariance, RESAMPLES) @ slopes
    ends = intervals(value, resampled, _LEVEL)
    found = {}
    for i in free:
        beyond = _MODEL_ERROR * abs(value[i])
        low, high = float(ends.low[i] - beyond), float(ends.high[i] + beyond)
        scale = float(documented[i]) if GAINS[i] == "integral_gain" else 0.0  # a servo may have none
        status, reason = judge_estimate(float(value[i]), low, high, scale=scale, excited="")
        found[i] = Estimate(
            name=f"servo.{GAINS[i]}",
            joint=joint,
            unit=_UNITS[GAINS[i]],
            side="motor",
            value=float(value[i]),
            low=low,
            high=high,
            prior=float(documented[i]),
            status=status,
            reason=f"{reason}; {_HINTS[GAINS[i]]}" if reason else "",
        )
    return found


def _refuse(i: int, documented: Array, joint: str, status: str, reason: str) -> Estimate:
    """Make the estimate of a gain that nothing is known of."""
    return Estimate(
        name=f"servo.{GAINS[i]}",
        joint=joint,
        unit=_UNITS[GAINS[i]],
        side="motor",
        value=float(documented[i]),
        low=0.0,
        high=float("inf"),
        prior=float(documented[i]),
        status=status,  # type: ignore[arg-type]
        reason=reason,
    )


def _explain(rows: ServoRows) -> float:
    """Compute the explained share of the variance of torque in blocks that are left out of the fit in turn."""
    blocks: Blocks = rows.blocks
    fold = np.arange(blocks.n_blocks) % _FOLDS
    left = np.zeros_like(rows.torque)
    for k in range(_FOLDS):
        solved = rows.solve((fold != k).astype(np.float64), _UNKNOWN)
        out = fold[blocks.of_row] == k
        left[out] = rows.torque[out] - rows.terms[out] @ solved
    return float(1 - (left**2).sum() / (rows.torque**2).sum())
