"""Motors, gearboxes and the elasticity behind them, and how the two sides of the gearbox are related."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray
from ffgym.robot.reading.rules import RULES, check_part


@dataclass(frozen=True, kw_only=True, eq=False)
class Drive:
    r"""Motor, gearbox and the elasticity behind it, one entry per joint.

    .. math:: \theta = G q, \quad \tau_{joint} = G^T u, \quad G = \mathrm{diag}(n) + C

    with motor angles theta, joint positions q behind the gearbox, and motor torques u. All conversions are elementwise,
    so that a result does not depend on how many rows are converted together.
    """

    gear_ratio: Array
    """Motor turns per joint turn n, shape (N,), not 0; negative where they turn opposite ways; [rad/m] for a slide."""
    rotor_inertia: Array
    """Motor and gear input inertia J_m, motor side [kg m^2], shape (N,)."""
    joint_stiffness: Array
    """Elasticity between gearbox and arm K, link side [N m/rad], shape (N,); inf is a rigid joint."""
    joint_damping: Array
    """Damping of that elasticity d, link side [N m s/rad], shape (N,)."""
    peak_torque: Array
    """Largest torque the drive gives, motor side [N m], shape (N,)."""
    torque_per_current: Array | None = None
    """Torque per motor current, motor side [N m/A], shape (N,), which logs of currents take; None is not known."""
    rated_torque: Array | None = None
    """Torque at 100 %, motor side [N m], shape (N,), which logs in percent take; None is not known."""
    torque_lag: Array | None = None
    """Time constant T_c of the torque loop, a first-order lag from command to torque [s], shape (N,); None is 0, no
    lag."""
    torque_delay: Array | None = None
    """Time from a commanded torque to its effect, beside the lag [s], shape (N,); None is 0."""
    torque_rate: Array | None = None
    """Fastest change of the torque that the drive gives, motor side [N m/s], shape (N,); None is inf, no limit."""
    resolver_period: float = 0.0
    """Period at which the drive reads its resolver [s]; the servo's speed is the difference of two readings. 0: the
    servo knows the exact angle and speed."""
    coupling: Array | None = None
    """C_ij, how far motor i turns with joint j when its own joint stands still, shape (N, N), 0 on the diagonal; None
    is no coupling."""

    def __post_init__(self) -> None:
        check_part("drive", self, np.size(self.gear_ratio))
        with np.errstate(over="ignore"):
            reflected = self.reflected_inertia
        if not np.all(np.isfinite(reflected)):
            raise FFGymError(
                f"drive.gear_ratio = {self.gear_ratio.tolist()} gives rotors of {reflected.tolist()} kg m^2 behind the "
                f"gearbox. Ratios are motor turns per joint turn, some hundred at most."
            )
        self._leave_out_ideal()
        if self.coupling is None:
            return
        if np.any(np.diag(self.coupling)):
            raise FFGymError(
                f"drive.coupling has {np.diag(self.coupling)} on its diagonal, must be 0; see drive.gear_ratio."
            )
        if not np.any(self.coupling):
            object.__setattr__(self, "coupling", None)
        elif np.linalg.cond(self.matrix) > 1 / np.finfo(np.float64).eps:
            raise FFGymError(f"drive.coupling = {self.coupling.tolist()} leaves joint motions that turn no motor.")

    def _leave_out_ideal(self) -> None:
        """Make numbers between command and torque that have no effect None, so that equals are equal."""
        for name in _TORQUE_PATH:
            if np.all(self._fill(name) == _ideal(name)):
                object.__setattr__(self, name, None)

    @property
    def loop_lag(self) -> Array:
        """Time constant of the torque loop [s], shape (N,); 0 where there is none."""
        return self._fill("torque_lag")

    @property
    def loop_rate(self) -> Array:
        """Fastest change of torque, motor side [N m/s], shape (N,); inf where there is no limit."""
        return self._fill("torque_rate")

    @property
    def delay(self) -> Array:
        """Time from command to torque, beside the lag [s], shape (N,); 0 where there is none."""
        return self._fill("torque_delay")

    @property
    def has_torque_loop(self) -> BoolArray:
        """True for drives whose torque lags its command, or whose rate is limited, shape (N,)."""
        loop: BoolArray = (self.loop_lag > 0) | np.isfinite(self.loop_rate)
        return loop

    def _fill(self, name: str) -> Array:
        values = getattr(self, name)
        return np.full(len(self.gear_ratio), _ideal(name)) if values is None else np.asarray(values)

    @property
    def reflected_inertia(self) -> Array:
        """Inertia of the rotors behind the gearbox, link side [kg m^2], shape (N,)."""
        return self.gear_ratio**2 * self.rotor_inertia

    @property
    def is_rigid(self) -> BoolArray:
        """True for joints without elasticity, shape (N,)."""
        return np.isinf(self.joint_stiffness)

    @cached_property
    def matrix(self) -> Array:
        """G, shape (N, N)."""
        diagonal: Array = np.diag(self.gear_ratio)
        return diagonal if self.coupling is None else diagonal + self.coupling

    @cached_property
    def inverse(self) -> Array:
        """Inverse of G, shape (N, N)."""
        return np.asarray(np.linalg.inv(self.matrix), dtype=np.float64)

    def motor_angle(self, q: Array) -> Array:
        """Motor angles [rad] of joint positions `q` (..., N), link side; also speeds and accelerations."""
        angle: Array = q * self.gear_ratio
        return angle if self.coupling is None else _with_others(angle, self.matrix, q)

    def joint_angle(self, motor_q: Array) -> Array:
        """Joint positions, link side, of motor angles `motor_q` [rad] (..., N); also speeds and accelerations."""
        if self.coupling is None:
            angle: Array = motor_q / self.gear_ratio
            return angle
        return _with_others(motor_q * np.diag(self.inverse), self.inverse, motor_q)

    def motor_torque(self, joint_torque: Array) -> Array:
        """Motor torques [N m] that give the torques `joint_torque` (..., N) behind the gearbox, link side."""
        if self.coupling is None:
            torque: Array = joint_torque / self.gear_ratio
            return torque
        return _with_others(joint_torque * np.diag(self.inverse), self.inverse.T, joint_torque)

    def joint_torque(self, motor_torque: Array) -> Array:
        """Torques behind the gearbox, link side, of the motor torques `motor_torque` [N m] (..., N)."""
        torque: Array = motor_torque * self.gear_ratio
        return torque if self.coupling is None else _with_others(torque, self.matrix.T, motor_torque)


_TORQUE_PATH = ("torque_lag", "torque_delay", "torque_rate")
"""Numbers between command and torque, which an ideal drive lacks."""


def _ideal(name: str) -> float:
    """Value of a number between command and torque in an ideal drive."""
    neutral = RULES[f"drive.{name}"].neutral
    assert neutral is not None
    return neutral


def loop_decay(lag: Array, dt: float) -> Array:
    """Compute the share of its distance to the command that a torque loop of this `lag` [s] leaves after `dt` [s]."""
    decay: Array = np.exp(-np.divide(dt, lag, out=np.full_like(lag, np.inf), where=lag > 0))
    return decay


def next_torque(torque: Array, command: Array, decay: Array, most: Array | None = None) -> Array:
    r"""Compute what torque loops give a step later, torques of any leading shape (..., N).

    .. math:: T_c \dot \tau = u - \tau, \quad |\dot \tau| \le R

    The step of the lag is exact for a command that is held over it; its mean rate is limited.

    Args:
        torque: torque before [N m].
        command: commanded torque u, within the limits of the drive [N m].
        decay: `loop_decay` of the lag T_c over the step, (N,) or (..., N).
        most: largest change in the step, R times its duration [N m], likewise; None is no limit.
    """
    later: Array = command + (torque - command) * decay
    return later if most is None else torque + np.minimum(np.maximum(later - torque, -most), most)


def _with_others(total: Array, matrix: Array, values: Array) -> Array:
    """Add to `total` (..., N) what the off-diagonal entries of `matrix` (N, N) make of `values` (..., N)."""
    for i, j in np.argwhere(matrix != 0):
        if i != j:
            total[..., i] += matrix[i, j] * values[..., j]
    return total
