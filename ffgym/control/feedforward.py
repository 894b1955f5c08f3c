"""Feed-forward laws: torque added to the drive's own control, from the reference alone; torque of the rigid arm."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths.reference import Reference
from ffgym.robot import RigidArm


class FeedForwardLaw(ABC):
    """Map from a reference to added motor torque u_lff, thesis (4.4)."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Short name in tables and files; members set a class attribute or a field with a default."""

    @abstractmethod
    def torque(self, reference: Reference) -> Array:
        """Return the added torque at every sample, motor side [N m], shape (T, N)."""

    def torques_along(self, references: Sequence[Reference]) -> list[Array]:
        """Return the torque along each of several references."""
        return [self.torque(reference) for reference in references]


@final
@dataclass(frozen=True)
class NoCompensation(FeedForwardLaw):
    """No added torque: the existing controller alone."""

    name: ClassVar[str] = "none"

    def torque(self, reference: Reference) -> Array:
        """Return zero torque [N m], shape (T, N)."""
        return np.zeros_like(reference.q)


@dataclass(frozen=True, kw_only=True, eq=False)
class Window:
    """Part of the reference that a controller sees at one instant: P + 1 samples from now on, shape (..., P + 1, N)."""

    q: Array
    """Joint position, link side [rad]."""
    motor_dq: Array
    """Motor speed [rad/s]."""
    motor_ddq: Array
    """Motor acceleration [rad/s^2]."""
    dt: float
    """Time between samples [s]."""

    @classmethod
    def along(cls, reference: Reference, preview: int) -> "Window":
        """Cut windows at every sample but the last, shape (T - 1, P + 1, N); beyond the end the last sample holds."""
        last = len(reference.t) - 1
        rows = np.minimum(np.arange(last)[:, None] + np.arange(preview + 1), last)
        return cls(
            q=reference.q[rows],
            motor_dq=reference.motor_dq[rows],
            motor_ddq=reference.motor_ddq[rows],
            dt=reference.robot.servo.control_dt,
        )

    def __getitem__(self, row: int) -> "Window":
        return Window(q=self.q[row], motor_dq=self.motor_dq[row], motor_ddq=self.motor_ddq[row], dt=self.dt)


class CausalLaw(FeedForwardLaw):
    """Law that runs sample by sample, from its memory and the next samples of the reference.

    A torque computed at t[k] is reached at t[k + 1], so that it belongs to sample 1 of the window. The memory is an
    array (..., M), passed in and returned, so that one law serves any number of robots. All arithmetic is elementwise
    over the leading axes: a robot's torque does not depend on the others.
    """

    preview: int = 1
    """Number P of samples of the reference that it must see ahead, 1 or more."""

    @property
    @abstractmethod
    def n_joints(self) -> int:
        """Number of motors N."""

    @abstractmethod
    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Return torque [N m] at sample 1 of the window, motor side, shape (..., N), and the new memory, (..., M)."""

    def initial_memory(self, window: Window) -> Array:
        """Return the memory when a motion begins with `window`, shape (..., M); by default it is empty, M = 0."""
        return np.zeros((*window.q.shape[:-2], 0))

    def own_error(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Return the error that the law itself asks for at sample 1 of the window, from its memory before that step.

        Drives join samples of torque by straight lines, so that motors pass a jump between samples as a ramp; this is
        the error that they then have, and that the law expects its servo to see.

        Args:
            memory: memory of the law, shape (..., M).
            window: part of the reference that the step from it on sees.

        Returns:
            Position error [rad] and speed error [rad/s] of the motors, reference - position, shape (..., N) each; zero
            for a law that leaves the motors on their reference.
        """
        return self.instant_error(memory)

    def instant_error(self, memory: Array) -> tuple[Array, Array]:
        """Return `own_error` as it would be without straight lines of torque, at the very instant of the sample.

        Policies that were trained on it read it: those that ship, see `ResidualPolicy.averaged`.
        """
        still = np.zeros((*memory.shape[:-1], self.n_joints))
        return still, still

    def own_errors(self, reference: Reference) -> tuple[Array, Array]:
        """Return `own_error` at every sample of a reference, position [rad] and speed [rad/s], shape (T, N) each."""
        self.check_joints(reference)
        angle, speed = np.zeros_like(reference.q), np.zeros_like(reference.q)
        own = type(self)
        if own.own_error is CausalLaw.own_error and own.instant_error is CausalLaw.instant_error:
            return angle, speed
        windows = Window.along(reference, self.preview)
        memory = self.initial_memory(windows[0])
        for k in range(len(angle) - 1):
            angle[k + 1], speed[k + 1] = self.own_error(memory, windows[k])
            memory = self.step(memory, windows[k])[1]
        return angle, speed

    def torque(self, reference: Reference) -> Array:
        """Return torque along a whole reference, motor side [N m], shape (T, N); zero at sample 0, which is set before.

        Raises:
            FFGymError: if the reference is for a robot with another number of joints.
        """
        self.check_joints(reference)
        windows = Window.along(reference, self.preview)
        memory = self.initial_memory(windows[0])
        torque = np.zeros_like(reference.q)
        if memory.shape[-1] == 0:  # without memory all samples are computed at once
            torque[1:] = self._step(np.zeros((len(torque) - 1, 0)), windows)[0]
            return torque
        for k in range(len(torque) - 1):
            torque[k + 1], memory = self._step(memory, windows[k])
        return torque

    def _step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Step, and check that the law returns torque and memory, and the torque of every motor."""
        found = self.step(memory, window)
        if not isinstance(found, tuple) or len(found) != 2:
            raise FFGymError(f"step of law {self.name!r} must return torque and memory, got {type(found).__name__}.")
        if np.shape(found[0]) != (wanted := (*window.q.shape[:-2], self.n_joints)):
            raise FFGymError(f"Torque of a step of law {self.name!r} has shape {np.shape(found[0])}, must be {wanted}.")
        return found

    def torques_along(self, references: Sequence[Reference]) -> list[Array]:
        """Step along several references side by side; each gets the bits that it would get alone."""
        dts = {reference.robot.servo.control_dt for reference in references}
        if type(self).torque is not CausalLaw.torque or len(dts) > 1 or len(references) < 2:
            return super().torques_along(references)  # a law that computes a whole reference at once is fast enough
        return self.step_along(references)

    def step_along(self, references: Sequence[Reference]) -> list[Array]:
        """Step sample by sample along references side by side, which have one time between samples."""
        for reference in references:
            self.check_joints(reference)
        # longest first, so that references which still run are always the first rows
        longest_first = sorted(range(len(references)), key=lambda i: -len(references[i].t))
        windows = [Window.along(references[i], self.preview) for i in longest_first]
        lengths = np.array([len(window.q) for window in windows])
        memory = self.initial_memory(_side_by_side(windows, 0))
        if memory.shape[-1] == 0:
            return [CausalLaw.torque(self, reference) for reference in references]
        torques = [np.zeros_like(reference.q) for reference in references]
        for k in range(lengths[0]):
            going = int((lengths > k).sum())
            torque, memory = self._step(memory[:going], _side_by_side(windows[:going], k))
            for row, i in enumerate(longest_first[:going]):
                torques[i][k + 1] = torque[row]
        return torques

    def check_joints(self, reference: Reference) -> None:
        """Raise if the reference is for a robot with another number of joints."""
        if reference.robot.n_joints != self.n_joints:
            raise FFGymError(
                f"Feed-forward law {self.name!r} for {self.n_joints} joints does not fit robot "
                f"{reference.robot.name!r} with {reference.robot.n_joints}."
            )


def _side_by_side(windows: Sequence[Window], k: int) -> Window:
    """Stack windows at sample `k` of several motions, shape (B, P + 1, N)."""
    return Window(
        q=np.stack([window.q[k] for window in windows]),
        motor_dq=np.stack([window.motor_dq[k] for window in windows]),
        motor_ddq=np.stack([window.motor_ddq[k] for window in windows]),
        dt=windows[0].dt,
    )


def rigid_feedforward(arm: RigidArm, reference: Reference) -> Array:
    r"""Compute the rigid feed-forward torque u_ff, motor side [N m], shape (T, N).

    .. math:: u_{ff} = G^{-T} (M(q) \ddot q + C(q, \dot q) \dot q) + J_m \ddot\theta

    Gravity and friction are left to the feedback, as in the thesis (2.13).
    """
    drive = reference.robot.drive
    links = arm.inverse_dynamics(reference.q, reference.dq, reference.ddq)
    return drive.motor_torque(links) + drive.rotor_inertia * reference.motor_ddq
