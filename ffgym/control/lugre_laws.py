"""LuGre friction as feed-forward: torque of the friction model at the speed of the reference."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.control.feedforward import CausalLaw, Window
from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.types import Array
from ffgym.paths.reference import Reference
from ffgym.robot.friction import LuGreParameters


@final
@dataclass(frozen=True, eq=False)
class StaticLuGre(CausalLaw):
    r"""Steady-state LuGre friction with a smooth sign.

    .. math:: F_s = [f_c + (f_s - f_c) e^{-(v / v_s)^2}] \tanh(\beta v) + f_v v

    Reference:
        Thesis (4.1)-(4.2).
    """

    friction: LuGreParameters
    steepness: float = 5.0
    """beta [s/rad], thesis 4.1."""
    name: ClassVar[str] = "lugre_static"

    def __post_init__(self) -> None:
        _check_friction(self.friction)
        check_number("steepness", self.steepness, unit="s/rad", low=0.0, open_low=True)

    @property
    def n_joints(self) -> int:
        """Number of motors N."""
        return self.friction.n_joints

    def torque(self, reference: Reference) -> Array:
        """Return friction at the reference speed, motor side [N m], shape (T, N)."""
        self.check_joints(reference)
        return self.at_speed(reference.motor_dq)

    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Return friction at the speed of sample 1; it has no memory."""
        return self.at_speed(window.motor_dq[..., 1, :]), memory

    def at_speed(self, motor_dq: Array) -> Array:
        """Return friction [N m] at motor speed `motor_dq` [rad/s]; same shape."""
        level = self.friction.stribeck_level(motor_dq)
        return level * np.tanh(self.steepness * motor_dq) + self.friction.viscous * motor_dq


@dataclass(frozen=True, eq=False)
class DynamicLuGre(CausalLaw):
    """LuGre friction whose bristles are bent by the reference speed; members differ in the method of integration.

    For a known speed the bristle equation is linear in z, so that one control step is z_next = keep * z + gain.
    """

    friction: LuGreParameters
    name: ClassVar[str] = "lugre_dynamic"

    def __post_init__(self) -> None:
        _check_friction(self.friction)

    @abstractmethod
    def advance(self, dq: Array, next_dq: Array, dt: float) -> tuple[Array, Array]:
        """Return factors (keep, gain) of a step of `dt` [s]; the speed runs straight from `dq` to `next_dq` [rad/s]."""

    @property
    def n_joints(self) -> int:
        """Number of motors N."""
        return self.friction.n_joints

    def initial_memory(self, window: Window) -> Array:
        """Return the bristle deflection z [rad] at the start, shape (..., N): relaxed."""
        return np.zeros_like(window.motor_dq[..., 0, :])

    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Slide by one sample; the memory is the bristle deflection z [rad]."""
        return self.slide(memory, window.motor_dq[..., 0, :], window.motor_dq[..., 1, :], window.dt)

    def slide(self, z: Array, dq: Array, next_dq: Array, dt: float) -> tuple[Array, Array]:
        """Return torque [N m] and deflection [rad] at the end of a step from motor speed `dq` to `next_dq` [rad/s]."""
        keep, gain = self.advance(dq, next_dq, dt)
        next_z = keep * z + gain
        return self.friction.torque(next_z, next_dq), next_z

    def torque(self, reference: Reference) -> Array:
        """Return friction along the reference, motor side [N m], shape (T, N)."""
        self.check_joints(reference)
        return self.along(reference.motor_dq, reference.robot.servo.control_dt)

    def along(self, motor_dq: Array, dt: float) -> Array:
        """Return friction [N m] along motor speeds sampled every `dt` [s], both shape (T, N).

        Raises:
            FFGymError: if the integration diverges, as plain Euler does at 4 ms (thesis 4.2).
        """
        keep, gain = self.advance(motor_dq[:-1], motor_dq[1:], dt)
        z = np.empty_like(motor_dq)
        z[0] = 0.0  # relaxed
        with np.errstate(over="ignore", invalid="ignore"):
            for k in range(len(keep)):
                z[k + 1] = keep[k] * z[k] + gain[k]
        _check_bounded(z, self.friction)
        return self.friction.torque(z, motor_dq)


@final
@dataclass(frozen=True, eq=False)
class DynamicLuGreEuler(DynamicLuGre):
    """Forward Euler on linearly interpolated speed, thesis (4.6) and appendix A.1.

    Reference:
        Thesis 4.2: 40 interpolated points per 4 ms step are enough for the motions tested; one is not.
    """

    n_substeps: int = 40

    def __post_init__(self) -> None:
        super().__post_init__()
        check_whole("n_substeps", self.n_substeps, low=1)

    def advance(self, dq: Array, next_dq: Array, dt: float) -> tuple[Array, Array]:
        """Chain Euler steps over all sub-steps."""
        h = dt / self.n_substeps
        speed = _interpolate(dq, next_dq, np.arange(self.n_substeps) / self.n_substeps)
        keep = 1 - h * self.friction.bristle_stiffness * np.abs(speed) / self.friction.stribeck_level(speed)
        return chain_sub_steps(keep, h * speed)


@final
@dataclass(frozen=True, eq=False)
class DynamicLuGreExact(DynamicLuGre):
    """Exact solution for a speed that is frozen at the middle of each sub-step; stable at any step."""

    n_substeps: int = 32
    """Chosen: within 0.2 % of the breakaway torque of a stiff ODE solution on all test motions (see tests)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_whole("n_substeps", self.n_substeps, low=1)

    @property
    def shares(self) -> Array:
        """Middles of the sub-steps as shares of a step, shape (S,)."""
        return (np.arange(self.n_substeps) + 0.5) / self.n_substeps

    def advance(self, dq: Array, next_dq: Array, dt: float) -> tuple[Array, Array]:
        """Chain exact steps over all sub-steps."""
        speed = _interpolate(dq, next_dq, self.shares)
        return chain_sub_steps(*self.friction.exact_bristle_factors(speed, dt / self.n_substeps))


def _check_friction(friction: LuGreParameters) -> None:
    if not isinstance(friction, LuGreParameters):
        raise FFGymError(f"friction must be LuGreParameters, e.g. robot.friction, got {friction!r}.")


def _interpolate(start: Array, end: Array, fractions: Array) -> Array:
    """Interpolate from `start` to `end` (..., N) at `fractions` (S,), shape (S, ..., N)."""
    return start + (end - start) * fractions.reshape(-1, *[1] * start.ndim)


def chain_sub_steps(keep: Array, gain: Array) -> tuple[Array, Array]:
    """Combine factors of sub-steps (S, ..., N) to one step (..., N), in a loop: no shape changes the rounding."""
    total_keep, total_gain = np.ones_like(keep[0]), np.zeros_like(gain[0])
    with np.errstate(over="ignore", invalid="ignore"):
        for factor, offset in zip(keep, gain, strict=True):
            total_keep, total_gain = total_keep * factor, total_gain * factor + offset
    return total_keep, total_gain


def _check_bounded(z: Array, friction: LuGreParameters) -> None:
    """Check that the integration has not diverged: in the LuGre model |z| never exceeds f_s / sigma_0."""
    limit = 10 * friction.static / friction.bristle_stiffness
    bad = np.argwhere(~(np.abs(z) <= limit))
    if bad.size:
        row, j = (int(i) for i in bad[0])
        raise FFGymError(
            f"The bristle deflection of joint {j + 1} diverges at sample {row}: the step is too long for Euler's "
            f"method. Use more n_substeps (thesis: 40), or DynamicLuGreExact."
        )
