"""Residual torque model: the missing torque as a function of a motor's motion, learned from two trials.

Idea and source: regression on the difference between the prediction of a model and the machine is common for
inverse dynamics (Nguyen-Tuong & Peters 2011, Cognitive Processing 12, "Model learning for robot control"); here the
model is the drive's own feed-forward, and the difference is friction before all. Per motor

    u_lff = b . [s_1 ... s_W, v, a] + g(x),      x = [s_1 ... s_W, asinh(v / v_0) / asinh(v_max / v_0)]

with slip elements s (`ffgym.robot.friction`: memory of the last reversal), motor speed v and
acceleration a. The linear part is the mean of a Gaussian process, g its deviation from it: a sum of bells around some
of the samples seen,

    g(x) = sum_i alpha_i exp(-|x - x_i|^2 / (2 l^2))

It is zero far from all samples, where the linear part alone answers: the process shrinks to its
mean where its variance is back at that of the prior.

Motions differ in how much of their torque no feature of one motor explains: at 100 mm/s the links swing on their
gearboxes with more torque than all friction. Each motion counts with that spread as its noise (`MotorRecord.noise`),
or the fastest would drown the friction that the slowest shows.

Run it:

    ffgym demo --agents none lugre_dynamic residual_gp

Logged: see `ffgym.agents.supervised.Supervised`.

Departures from common Gaussian-process regression: an exact process on a subset of the samples (`N_POINTS` per motor,
even in time) instead of a sparse one on all; one length scale for all features, since more fit no better on held-out
motions and take ten times longer; the mean is fitted before and not marginalised. Kernel parameters maximise the
marginal likelihood (scikit-learn); prediction needs NumPy alone.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from types import ModuleType
from typing import ClassVar, final

import numpy as np

from ffgym.agents.declaration import AgentEntry, declare
from ffgym.agents.law_files import StoredLaw
from ffgym.agents.supervised import MotorRecord, Supervised, learn, least_squares, linear_features
from ffgym.agents.trials import Trial, every_speed, pick_evenly
from ffgym.control import CausalLaw, LawStyle, Window
from ffgym.core.errors import FFGymError, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.robot.friction import WIDTHS, advance_slip

KNEE = 0.01
"""v_0 / v_max: speeds are stretched below it and compressed above, since friction changes most near standstill. Chosen:
0.1 rad/s where a motor reaches 10, which is where the Stribeck effect of geared motors lies."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ResidualTorque(CausalLaw, StoredLaw):
    """Linear part plus Gaussian process per motor; predicts with NumPy alone."""

    coefficients: Array
    """b [N m per unit of its feature], motor side, shape (N, W + 2)."""
    top_speed: Array
    """v_max [rad/s], motor side, shape (N,), > 0."""
    points: Array
    """Samples x_i, shape (N, P, W + 1)."""
    alpha: Array
    """Heights of their bells [N m], shape (N, P)."""
    length: Array
    """Width l of the bells, in units of x, shape (N,), > 0."""
    widths: Array = field(default_factory=WIDTHS.copy)
    """Motor travel after which the slip elements slip [rad], shape (W,), > 0."""
    name: str = "residual_gp"
    kind: ClassVar[str] = "residual_gp"

    def __post_init__(self) -> None:
        n, p = check_shape("alpha", self.alpha, (None, None)).shape
        w = check_shape("widths", self.widths, (None,)).size
        shapes = {
            "coefficients": (n, w + 2),
            "top_speed": (n,),
            "points": (n, p, w + 1),
            "alpha": (n, p),
            "length": (n,),
            "widths": (w,),
        }
        for name, shape in shapes.items():
            object.__setattr__(self, name, check_shape(name, getattr(self, name), shape))
        for name in ("top_speed", "length", "widths"):
            if np.any(getattr(self, name) <= 0):
                raise FFGymError(f"{name} = {getattr(self, name)} of law {self.name!r} must be > 0.")

    @property
    def n_joints(self) -> int:
        """Number of motors N."""
        return len(self.coefficients)

    def initial_memory(self, window: Window) -> Array:
        """Return relaxed slip elements, shape (..., N W)."""
        return np.zeros((*window.q.shape[:-2], self.n_joints * len(self.widths)))

    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Advance the slip elements, which are the memory, and return the torque of the next sample."""
        slip = memory.reshape(*memory.shape[:-1], self.n_joints, len(self.widths))
        now, then = window.motor_dq[..., 0, :], window.motor_dq[..., 1, :]
        slip = advance_slip(slip, now, then, window.dt, self.widths)
        return self.at(slip, then, window.motor_ddq[..., 1, :]), slip.reshape(memory.shape)

    def at(self, slip: Array, motor_dq: Array, motor_ddq: Array) -> Array:
        """Compute torque [N m] at slip elements (..., N, W), motor speed [rad/s], acceleration [rad/s^2] (..., N)."""
        mean = (self.coefficients * linear_features(slip, motor_dq, motor_ddq)).sum(axis=-1)
        x = bell_features(slip, motor_dq, self.top_speed)
        square = np.zeros((*motor_dq.shape, self.alpha.shape[1]))
        for d in range(x.shape[-1]):  # one feature at a time, or the array of differences gets large
            square += (x[..., d, None] - self.points[..., d]) ** 2
        bells = np.exp(-0.5 * square / self.length[:, None] ** 2)
        return np.asarray(mean + (self.alpha * bells).sum(axis=-1))


def bell_features(slip: Array, motor_dq: Array, top_speed: Array) -> Array:
    """Compute the inputs x (..., N, W + 1) of the process, each number within [-1, 1] up to the top speed."""
    stretched = np.arcsinh(motor_dq / (KNEE * top_speed)) / np.arcsinh(1 / KNEE)
    return np.concatenate([slip, stretched[..., None]], axis=-1)


N_TRIALS = 2
"""Trials to learn from. Chosen: a third changes the motor error by less than 5 % (docs/agents/residual_torque.md)."""
N_POINTS = 300
"""Samples of a motor that the process keeps. Chosen: 0.1 ms per control step on six motors."""
LENGTHS = (0.3, 30.0)
"""Length scales searched, in features of size 1: below, the process follows single samples; above, it is a line."""
AMPLITUDES = (1e-4, 10.0)
"""Sizes of the process searched [N m]: from nothing to more than all friction."""


def learn_residual_torque(
    trial: Trial, references: Sequence[Reference], n_trials: int = N_TRIALS, n_points: int = N_POINTS
) -> Supervised[ResidualTorque]:
    """Learn the residual torque model of a machine from trials along `references`.

    Raises:
        FFGymError: if scikit-learn is missing, there is no motion, or a number is out of range.
    """
    _require_sklearn()
    check_whole("n_points", n_points, low=len(references))
    return learn(trial, references, lambda records: fit_residual_torque(records, n_points), n_trials)


def fit_residual_torque(records: Sequence[MotorRecord], n_points: int = N_POINTS) -> ResidualTorque:
    """Fit the model of the motors in `records`, with about `n_points` samples of each kept."""
    n_joints = records[0].torque.shape[1]
    top_speed = np.max([np.abs(record.motor_dq).max(axis=0) for record in records], axis=0)
    top_speed = np.where(top_speed > 0, top_speed, 1.0)  # any, for a motor that stood still
    # linear part of each motor, then the samples that the processes keep
    coefficients, rest = zip(*(_line(records, joint) for joint in range(n_joints)), strict=True)
    kept = [pick_evenly(record.moving, n_points // len(records)) for record in records]
    points = np.concatenate(
        [bell_features(r.slip[k], r.motor_dq[k], top_speed) for r, k in zip(records, kept, strict=True)]
    ).swapaxes(0, 1)
    noise = np.concatenate([np.tile(r.noise, (len(k), 1)) for r, k in zip(records, kept, strict=True)])
    # Gaussian process of each motor on the torque that the linear part leaves
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
    """Fit the linear part of one motor; return coefficients and the torque left at all samples of each record."""
    features = [linear_features(r.slip, r.motor_dq, r.motor_ddq)[:, joint] for r in records]
    pairs = list(zip(features, records, strict=True))
    matrix = np.concatenate([x[r.moving] / r.noise[joint] for x, r in pairs])
    target = np.concatenate([r.torque[r.moving, joint] / r.noise[joint] for r in records])
    coefficients = least_squares(matrix, target)
    return coefficients, [r.torque[:, joint] - (x * coefficients).sum(axis=-1) for x, r in pairs]


def _process(points: Array, left: Array, noise: Array) -> tuple[Array, float]:
    """Fit the process with the greatest marginal likelihood; return heights of the bells [N m] and their width.

    Args:
        points: inputs of the samples, shape (P, D).
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


declare(
    AgentEntry(
        name="residual_gp",
        title="residual torque model",
        about="A line and a Gaussian process per motor, fitted to the torque that was missing.",
        track="causal",
        order=9,
        page="residual_torque.md",
        style=LawStyle(label="residual torque model", colour="#8C6BB1", marker="P", line="-."),
        make=lambda setting: learn_residual_torque(setting.trial, every_speed(setting.arm)).law,
        package="scikit-learn",
        learns=True,
    )
)
