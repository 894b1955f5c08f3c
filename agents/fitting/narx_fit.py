"""How a NARX network is fitted: Levenberg-Marquardt on the one-step prediction of the torque that trials show.

As thesis 6.2.3: prediction focus, three neurons, no linear term. What is predicted is the
torque that was missing along the realised motion (`agents.fitting.supervised`), which is friction before all.

Prediction is not simulation. At 4 ms the last torque is a fair guess of the next one, so that a network with y(k-1) can
predict well and still drift once it runs on its own outputs (the thesis finds its models worse in simulation on other
data). `Errors` shows both.

Departures from the source: torque estimated from trials instead of data from a LuGre model; motions are weighted by
their noise, as in `agents.fitting.residual_fit`; several random starts, of which the one is kept that *simulates* best
along the trials, since the best in prediction may drift; 200 evaluations at most instead of 1000 iterations; sampled at
the control step of 4 ms instead of 0.5 ms.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from agents.common.lessons import every_speed
from agents.common.trials import Trial
from agents.fitting.supervised import MotorRecord, Supervised, learn
from agents.narx import NARX, sigmoid
from ffgym.control import Reference
from ffgym.errors import check_whole
from ffgym.robot import RigidArm
from ffgym.types import Array

N_EVALUATIONS = 200
"""Of the residual at most, per start. Chosen: 1000, as in thesis 6.2.3, simulate no better and take far longer."""
N_STARTS = 5
"""Chosen: fits from different starts end in different minima."""
N_TRIALS = 2
"""Chosen, as for the residual torque model."""


@dataclass(frozen=True, kw_only=True)
class Structure:
    """Regressors and size; the default is thesis (6.20)."""

    n_speeds: int = 1
    """Speeds v(k), v(k-1), ..., 1 or more."""
    n_outputs: int = 1
    """Past outputs y(k-1), ..., 0 or more."""
    n_neurons: int = 3
    """Thesis 6.2.1."""

    def __post_init__(self) -> None:
        check_whole("n_speeds", self.n_speeds, low=1)
        check_whole("n_outputs", self.n_outputs, low=0)
        check_whole("n_neurons", self.n_neurons, low=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Errors:
    """RMS error of a network on one record while it moves, as a share of the torque's RMS, shape (N,)."""

    prediction: Array
    """With measured past torques."""
    simulation: Array
    """With its own past torques."""

    @classmethod
    def of(cls, law: NARX, record: MotorRecord) -> "Errors":
        """How well `law` gives the torque of `record`."""
        size = _rms(record.torque[record.moving])
        predicted, simulated = law.predicted(record.motor_dq, record.torque), law.simulated(record.motor_dq)
        return cls(
            prediction=_rms((predicted - record.torque)[record.moving]) / size,
            simulation=_rms((simulated - record.torque)[record.moving]) / size,
        )


def learn_narx(
    trial: Trial,
    references: Sequence[Reference],
    rng: np.random.Generator,
    structure: Structure | None = None,
    n_trials: int = N_TRIALS,
) -> Supervised[NARX]:
    """NARX network of a machine, from trials along `references`; `rng` draws the starts of the fits.

    Raises:
        FFGymError: if there is no motion, or a number is out of range.
    """
    structure = structure or Structure()
    return learn(trial, references, lambda records: fitted(records, rng, structure), n_trials)


def trained_narx(arm: RigidArm, trial: Trial) -> NARX:
    """Member of the catalogue: thesis (6.20), on the motions of every speed, seed 0.

    Raises:
        FFGymError: if the robot has neither a work area nor one joint alone.
    """
    return learn_narx(trial, every_speed(arm), np.random.default_rng(0)).law


def fitted(
    records: Sequence[MotorRecord], rng: np.random.Generator, structure: Structure, n_starts: int = N_STARTS
) -> NARX:
    """The network of `n_starts` fits that simulates best, motor by motor."""
    check_whole("n_starts", n_starts, low=1)
    starts = [_predicting_best(_random(records, rng, structure), records) for _ in range(n_starts)]
    costs = np.array([_simulation_cost(law, records) for law in starts])
    return _chosen(starts, costs.argmin(axis=0))


def _random(records: Sequence[MotorRecord], rng: np.random.Generator, structure: Structure) -> NARX:
    """Weights before a fit: slopes of about the size of the regressors, as those are of size 1."""
    n = records[0].torque.shape[1]
    speed = np.max([np.abs(record.motor_dq).max(axis=0) for record in records], axis=0)
    torque = np.max([_rms(record.torque) for record in records], axis=0)
    shape = (n, structure.n_neurons, structure.n_speeds + structure.n_outputs)
    return NARX(
        input_weights=2.0 * rng.normal(size=shape),
        biases=rng.normal(size=shape[:2]),
        output_weights=rng.normal(size=shape[:2]),
        offset=np.zeros(n),
        speed_scale=np.where(speed > 0, speed, 1.0),  # a motor that stands still has no size
        torque_scale=np.where(torque > 0, torque, 1.0),
        n_speeds=structure.n_speeds,
    )


def _predicting_best(start: NARX, records: Sequence[MotorRecord]) -> NARX:
    """The network from `start` with the least squares of weighted prediction errors, motor by motor."""
    regressors = np.concatenate([start.regressors(r.motor_dq, r.torque)[r.moving] for r in records])
    target = np.concatenate([r.torque[r.moving] / start.torque_scale for r in records])
    weight = np.concatenate([np.tile(start.torque_scale / r.noise, (r.moving.sum(), 1)) for r in records])
    parameters = [
        least_squares(
            _residual,
            _packed(start, joint),
            jac=_jacobian,
            method="lm",
            max_nfev=N_EVALUATIONS,
            args=(regressors[:, joint], target[:, joint], weight[:, joint], start.biases.shape[1]),
        ).x
        for joint in range(start.n_joints)
    ]
    return _unpacked(start, np.array(parameters))


def _residual(parameters: Array, phi: Array, target: Array, weight: Array, h: int) -> Array:
    """Weighted prediction error of one motor (T,) for regressors (T, R)."""
    w, b, c, d = _split(parameters, h)
    return np.asarray(weight * (sigmoid(phi @ w.T + b) @ c + d - target))


def _jacobian(parameters: Array, phi: Array, target: Array, weight: Array, h: int) -> Array:
    """Its derivative by the parameters, shape (T, K)."""
    w, b, c, _ = _split(parameters, h)
    active = sigmoid(phi @ w.T + b)
    slope = active * (1 - active) * c
    by_w = (slope[:, :, None] * phi[:, None, :]).reshape(len(phi), -1)
    return weight[:, None] * np.hstack([by_w, slope, active, np.ones((len(phi), 1))])


def _split(parameters: Array, h: int) -> tuple[Array, Array, Array, Array]:
    """Parameters (K,) of one motor with `h` neurons as w (H, R), b (H,), c (H,), d."""
    return (
        parameters[: -2 * h - 1].reshape(h, -1),
        parameters[-2 * h - 1 : -h - 1],
        parameters[-h - 1 : -1],
        parameters[-1],
    )


def _packed(law: NARX, joint: int) -> Array:
    parts = (law.input_weights, law.biases, law.output_weights, law.offset)
    return np.concatenate([np.ravel(part[joint]) for part in parts])


def _unpacked(law: NARX, parameters: Array) -> NARX:
    w, b, c, d = zip(*(_split(row, law.biases.shape[1]) for row in parameters), strict=True)
    return replace(law, input_weights=np.array(w), biases=np.array(b), output_weights=np.array(c), offset=np.array(d))


def _simulation_cost(law: NARX, records: Sequence[MotorRecord]) -> Array:
    """Mean square of the simulation error in units of the noise, shape (N,)."""
    parts = [((law.simulated(r.motor_dq) - r.torque)[r.moving] / r.noise) ** 2 for r in records]
    return np.asarray(np.concatenate(parts).mean(axis=0))


def _chosen(laws: Sequence[NARX], which: Array) -> NARX:
    """The network whose weights on each motor are those of the law that `which` (N,) names."""
    joints = np.arange(len(which))
    names = ("input_weights", "biases", "output_weights", "offset")
    return replace(laws[0], **{name: np.stack([getattr(law, name) for law in laws])[which, joints] for name in names})


def _rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
