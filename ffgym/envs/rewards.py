"""Rewards: minus a cost per control step; a cost that is no logarithm is 1 at one breakaway torque (or 0.1 mm)."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar, final

import numpy as np

from ffgym.control.setpoints import ServoTorque
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.core.types import Array, BoolArray
from ffgym.robot import RobotDescription

STOP_STEPS = 250
"""An emergency stop costs as much as this many steps, 1 s, at the error at which it happened. Chosen: the error limit
is so far out that under the default reward no standard motion costs as much, so that stopping never pays."""


@dataclass(slots=True, kw_only=True, eq=False)
class RewardSignals:
    """Signals at the end of a control step, in B sub-environments; motor side. Nothing changes them afterwards."""

    error: Array
    """True position error [rad], shape (B, N)."""
    error_rate: Array
    """True speed error [rad/s], shape (B, N)."""
    feedback: ServoTorque
    """Torque of the existing controller [N m], shape (B, N)."""
    action: Array
    """Applied action, after clipping, shape (B, N)."""
    tcp: Array | None
    """TCP [m], shape (B, 3); None for a robot without tool."""
    path_error: Array | None
    """Distance of the TCP from its path [m], shape (B,)."""
    mean_square_before: Array | None
    """Sum of the squared errors of the circle before this sample over the number of all its samples, shape (B,): path
    errors [m^2], without tool mean squares of K_p e / f_s over the joints. Of a motion without circles all counts."""
    mean_square: Array | None
    """The same with this sample. None for both where no reward asks for them by `uses_mean_square`."""


@dataclass(frozen=True, kw_only=True)
class Reward(ABC):
    """Minus a cost, minus a weight on the added torque, minus the price of an emergency stop."""

    effort_weight: float = 0.0
    """Cost of an applied action of 1 on every joint, with that of a base below; it grows with the square."""
    stop_steps: int = STOP_STEPS
    """Price of an emergency stop, in steps at the cost at which it happened."""
    name: ClassVar[str]
    privileged: ClassVar[bool] = False
    """True if it uses signals that no robot measures by itself."""
    uses_mean_square: ClassVar[bool] = False
    """True if it uses the mean squares of the signals."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "effort_weight", check_number("effort_weight", self.effort_weight, low=0.0))
        object.__setattr__(self, "stop_steps", check_whole("stop_steps", self.stop_steps, low=0))

    def check(self, robot: RobotDescription) -> None:  # noqa: B027  (most rewards are defined for every robot)
        """Raise FFGymError if the reward is not defined for a robot."""

    @abstractmethod
    def cost(self, signals: RewardSignals, robot: RobotDescription) -> Array:
        """Compute the cost of a step, shape (B,), >= 0."""

    def __call__(self, signals: RewardSignals, robot: RobotDescription, stopped: BoolArray) -> Array:
        """Compute the reward of a step, shape (B,), <= 0; `stopped` (B,) marks emergency stops."""
        cost = np.asarray(self.cost(signals, robot), dtype=np.float64)
        if cost.shape != stopped.shape or not math.isfinite(np.add.reduce(cost)):
            what = f"has shape {cost.shape}" if cost.shape != stopped.shape else f"is {cost}"
            raise FFGymError(f"The cost of {type(self).__name__} {what}, must be {stopped.shape} finite numbers.")
        if self.effort_weight:
            cost = cost + self.effort_weight * mean_square(signals.action)
        if np.count_nonzero(stopped):
            cost = np.where(stopped, cost + self.stop_price(cost), cost)
        return -cost

    def stop_price(self, cost: Array) -> Array:
        """Compute the price of an emergency stop, shape (B,), from the cost of its step."""
        return self.stop_steps * cost


@final
@dataclass(frozen=True, kw_only=True)
class MotorError(Reward):
    r"""Motor position error, root mean square over the joints in units of f_s / K_p; the default.

    .. math:: c = \sqrt{\frac{1}{N} \sum_j (K_{p,j} e_j / f_{s,j})^2}
    """

    name: ClassVar[str] = "motor_error"

    def cost(self, signals: RewardSignals, robot: RobotDescription) -> Array:
        """Compute the root mean square of scaled motor errors."""
        return np.sqrt(mean_square(signals.error * _error_gain(robot, len(signals.error))))


@dataclass(frozen=True, kw_only=True)
class PathErrorReward(Reward):
    """Cost by the distance of the TCP from its path. Privileged: a robot needs a laser tracker for it."""

    scale: float
    """Unit of the distance [m], > 0."""
    privileged: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        scale = check_number("scale", self.scale, unit="m", low=0.0, open_low=True)
        object.__setattr__(self, "scale", scale)

    def check(self, robot: RobotDescription) -> None:
        """Refuse a robot without a tool."""
        if robot.tool is None:
            raise FFGymError(f"Robot {robot.name!r} has no tool, so there is no path error; use reward='motor_error'.")

    def cost(self, signals: RewardSignals, robot: RobotDescription) -> Array:
        """Return the distance in units of `scale`."""
        assert signals.path_error is not None  # `check` refuses robots without a tool
        return signals.path_error / self.scale


@final
@dataclass(frozen=True, kw_only=True)
class AbsolutePathError(PathErrorReward):
    """Distance of the TCP from its path in units of `scale`. Privileged: a robot needs a laser tracker for it."""

    scale: float = 1e-4
    """Unit of the distance [m]; 0.1 mm is the order of the uncompensated error at 10 mm/s (thesis, Table 4.1)."""
    name: ClassVar[str] = "path_error"


@final
@dataclass(frozen=True, kw_only=True)
class RelativePathError(PathErrorReward):
    r"""Logarithm of the path error: halving an error gains the same at every speed. Privileged, as `AbsolutePathError`.

    .. math:: c = \ln(1 + e / s)

    Errors at 100 mm/s are ten times those at 10 mm/s, so that a reward linear in them hardly depends on slow motions.
    """

    scale: float = 2e-5
    """s [m]; below it the cost is linear. Chosen: errors at 10 mm/s of a law with nominal parameters on robots whose
    friction is off by tens of per cent."""
    name: ClassVar[str] = "relative_path_error"

    def cost(self, signals: RewardSignals, robot: RobotDescription) -> Array:
        """Compute ln(1 + e / s)."""
        return np.log1p(super().cost(signals, robot))


STOP_PRICE = 100.0
"""Price of an emergency stop in units of the logarithm; chosen: more than any three circles cost, 13 at 0.7 mm."""


@final
@dataclass(frozen=True, kw_only=True)
class LogRMSError(Reward):
    r"""Logarithm of the RMS error of each circle, the measure of the leaderboard, spread over the steps of the circle.

    .. math:: \sum_k c_k = \tfrac{1}{2} \ln(1 + \mathrm{RMS}^2 / s^2), \quad
        c_k = \tfrac{1}{2} \ln\frac{s^2 + m_k}{s^2 + m_{k-1}}

    with the mean square m_k of the errors so far over all samples of the circle. So the return of an episode is minus
    the sum over its circles, whatever the order of good and bad parts; halving an error gains 0.7 at every speed.
    Path errors, of a robot without tool motor errors in f_s / K_p. Privileged where there is a tool.
    """

    scale: float = 1e-5
    """s [m]; below it the cost is quadratic. The noise of the workcells' laser tracker, below which no score is."""
    motor_scale: float = 0.01
    """s of a robot without tool, in f_s / K_p; chosen: a tenth of what static LuGre leaves on one axis."""
    name: ClassVar[str] = "log_rms_error"
    privileged: ClassVar[bool] = True
    uses_mean_square: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, unit in (("scale", "m"), ("motor_scale", "")):
            value = check_number(name, getattr(self, name), unit=unit, low=0.0, open_low=True)
            object.__setattr__(self, name, value)

    def cost(self, signals: RewardSignals, robot: RobotDescription) -> Array:
        """Compute the growth of the logarithm in this step."""
        assert signals.mean_square is not None  # see uses_mean_square
        assert signals.mean_square_before is not None
        square = (self.motor_scale if robot.tool is None else self.scale) ** 2
        growth: Array = 0.5 * np.log((square + signals.mean_square) / (square + signals.mean_square_before))
        return growth

    def stop_price(self, cost: Array) -> Array:
        """Return a fixed price: the cost of a step says little of the circle."""
        return np.full_like(cost, STOP_PRICE)


@final
@dataclass(frozen=True, kw_only=True)
class FeedbackEffort(Reward):
    """Effort of the feedback: u_p in units of breakaway torque, root mean square over the joints.

    u_p is the learning signal of the thesis (chapter 5): the feed-forward is right when it vanishes.
    """

    name: ClassVar[str] = "feedback_effort"

    def cost(self, signals: RewardSignals, robot: RobotDescription) -> Array:
        """Compute the root mean square of scaled u_p."""
        return np.sqrt(mean_square(signals.feedback.u_p / robot.friction.static))


REWARDS: dict[str, type[Reward]] = {
    reward.name: reward for reward in (MotorError, AbsolutePathError, RelativePathError, LogRMSError, FeedbackEffort)
}
"""Rewards by name."""


def find_reward(reward: str | Reward, robot: RobotDescription | None = None) -> Reward:
    """Return a reward from its name, or as it is."""
    if isinstance(reward, str):
        reward = REWARDS[check_choice("reward", reward, list(REWARDS))]()
    if not isinstance(reward, Reward):
        raise FFGymError(f"reward = {reward!r} must be one of {sorted(REWARDS)} or a Reward of ffgym.envs.")
    if robot is not None:
        reward.check(robot)
    return reward


def mean_square(values: Array) -> Array:
    """Compute the mean square over the joints; a row's sum does not depend on the number of rows (tested)."""
    mean: Array = np.add.reduce(np.square(values), axis=-1) / values.shape[-1]
    return mean


@lru_cache(maxsize=8)
def _error_gain(robot: RobotDescription, n: int) -> Array:
    """Return the torque of the servo per motor error in breakaway torques [1/rad], (N,), for `n` robots, (B, N)."""
    return np.tile(robot.servo.position_gain / robot.friction.static, (n, 1))
