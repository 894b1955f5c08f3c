"""How a residual torque model is fitted: a weighted line, then a Gaussian process on what the line leaves.

Motions differ in how much of their torque no feature of one motor explains: at 100 mm/s the links swing on their
gearboxes with more torque than all friction. Each motion counts with that spread as its noise (`MotorRecord.noise`),
or the fastest would drown what the slowest says of friction.

Departures from common Gaussian-process regression: an exact process on a subset of the samples (`N_POINTS` per motor,
even in time) instead of a sparse one on all; one length scale for all features, since more fit no better on held-out
motions and take ten times longer; the mean is fitted before and not marginalised. Kernel parameters maximise the
marginal likelihood (scikit-learn); prediction needs NumPy alone.
"""

import warnings
from collections.abc import Sequence
from types import ModuleType

import numpy as np

from ffgym.agents.common.lessons import every_speed
from ffgym.agents.common.trials import Trial
from ffgym.agents.fitting.supervised import MotorRecord, Supervised, learn, least_squares, linear_features
from ffgym.agents.residual_torque import ResidualTorque, bell_features
from ffgym.core.errors import FFGymError, check_whole
from ffgym.core.types import Array, IntArray
from ffgym.paths import Reference
from ffgym.robot import RigidArm

N_TRIALS = 2
"""Chosen: a third changes the motor error by less than 5 % (docs/agents/residual_torque.md)."""
N_POINTS = 300
"""Samples of a motor that the process keeps. Chosen: 0.1 ms per control step on six motors."""
LENGTHS = (0.3, 30.0)
"""Length scales searched, in features of size 1: below, the process follows single samples; above, it is a line."""
AMPLITUDES = (1e-4, 10.0)
"""Sizes of the process searched [N m]: from nothing to more than all friction."""


def learn_residual_torque(
    trial: Trial, references: Sequence[Reference], n_trials: int = N_TRIALS, n_points: int = N_POINTS
) -> Supervised[ResidualTorque]:
    """Residual torque model of a machine, from trials along `references`.

    Raises:
        FFGymError: if scikit-learn is missing, there is no motion, or a number is out of range.
    """
    _require_sklearn()
    check_whole("n_points", n_points, low=len(references))
    return learn(trial, references, lambda records: fitted(records, n_points), n_trials)


def trained_residual_torque(arm: RigidArm, trial: Trial) -> ResidualTorque:
    """Member of the catalogue: on the motions of every speed.

    Raises:
        FFGymError: if scikit-learn is missing, or the robot has neither a work area nor one joint alone.
    """
    return learn_residual_torque(trial, every_speed(arm)).law


def fitted(records: Sequence[MotorRecord], n_points: int = N_POINTS) -> ResidualTorque:
    """The model of the motors in `records`, with about `n_points` samples of each kept."""
    n_joints = records[0].torque.shape[1]
    top_speed = np.max([np.abs(record.motor_dq).max(axis=0) for record in records], axis=0)
    top_speed = np.where(top_speed > 0, top_speed, 1.0)  # of a motor that stood still nothing is asked
    coefficients, rest = zip(*(_line(records, joint) for joint in range(n_joints)), strict=True)
    kept = [_evenly(record, n_points // len(records)) for record in records]
    points = np.concatenate(
        [bell_features(r.slip[k], r.motor_dq[k], top_speed) for r, k in zip(records, kept, strict=True)]
    ).swapaxes(0, 1)
    noise = np.concatenate([np.tile(r.noise, (len(k), 1)) for r, k in zip(records, kept, strict=True)])
    process = []
    for joint in range(n_joints):
        left = np.concatenate([part[k] for part, k in zip(rest[joint], kept, strict=True)])
        process.append(_process(points[joint], left, noise[:, joint]))
    alpha, length = zip(*process, strict=True)
    return ResidualTorque(
        coefficients=np.array(coefficients),
        top_speed=top_speed,
        points=points,
        alpha=np.array(alpha),
        length=np.array(length),
    )


def _line(records: Sequence[MotorRecord], joint: int) -> tuple[Array, list[Array]]:
    """Coefficients of the linear part of one motor, and the torque it leaves at all samples of each record."""
    features = [linear_features(r.slip, r.motor_dq, r.motor_ddq)[:, joint] for r in records]
    pairs = list(zip(features, records, strict=True))
    matrix = np.concatenate([x[r.moving] / r.noise[joint] for x, r in pairs])
    target = np.concatenate([r.torque[r.moving, joint] / r.noise[joint] for r in records])
    coefficients = least_squares(matrix, target)
    return coefficients, [r.torque[:, joint] - (x * coefficients).sum(axis=-1) for x, r in pairs]


def _evenly(record: MotorRecord, count: int) -> IntArray:
    """Indices of `count` samples, or all there are, spread evenly over the time in which the record moves."""
    moving = np.flatnonzero(record.moving)
    return moving[np.unique(np.linspace(0, len(moving) - 1, count).round().astype(np.int64))]


def _process(points: Array, left: Array, noise: Array) -> tuple[Array, float]:
    """Heights of the bells [N m] and their width: the process with the greatest marginal likelihood.

    Args:
        points: where samples are, shape (P, D).
        left: torque there that the linear part leaves [N m], shape (P,).
        noise: standard deviation of each [N m], shape (P,).
    """
    sklearn = _require_sklearn()
    kernels = sklearn.gaussian_process.kernels
    low, high = AMPLITUDES
    size = float(np.clip(np.min(noise), low, high))
    kernel = kernels.ConstantKernel(size**2, (low**2, high**2)) * kernels.RBF(1.0, LENGTHS)
    regressor = sklearn.gaussian_process.GaussianProcessRegressor(kernel, alpha=noise**2)
    with warnings.catch_warnings():  # an optimum at a bound is an answer: no process is needed, or a smooth one
        warnings.simplefilter("ignore", sklearn.exceptions.ConvergenceWarning)
        regressor.fit(points, left)
    found = regressor.kernel_
    return np.asarray(found.k1.constant_value * regressor.alpha_), float(found.k2.length_scale)


def _require_sklearn() -> ModuleType:
    try:
        import sklearn.exceptions
        import sklearn.gaussian_process
    except ImportError as error:
        raise FFGymError("Fitting a residual torque model needs scikit-learn; pip install 'ffgym[gp]'.") from error
    return sklearn
