"""Torques for given motions, sample by sample: the result of per-task learning."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self, final

import numpy as np

from ffgym.agents.law_files import StoredLaw
from ffgym.control import CausalLaw, Window
from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.paths import Reference

SAME = 1e-6
"""Two references are the same motion if their positions differ by less everywhere [rad], link side: a micrometre at a
reach of 1 m, a thousandth of the smallest circle of the tests; an observation keeps far more digits."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionTorque:
    """One motion and its torque."""

    name: str
    q: Array
    """Reference, link side [rad], shape (T, N)."""
    torque: Array
    """Added torque, motor side [N m], shape (T, N); zero at sample 0."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", check_shape(f"q of task {self.name!r}", self.q, (None, None)))
        object.__setattr__(self, "torque", check_shape(f"torque of task {self.name!r}", self.torque, self.q.shape))


def same_motion(one: Array, other: Array) -> bool:
    """Compare two references (T, N) [rad]: True if they are the same motion."""
    return one.shape == other.shape and bool(np.abs(one - other).max() < SAME)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TaskTorques(CausalLaw, StoredLaw):
    """A torque for each of the motions it has, and none for any other.

    A reference is recognised by its samples, not by its name. Sample by sample, the law runs one task: motions of a
    work area begin alike, at rest, so that the samples ahead do not show which one it will be; `task` chooses.
    """

    tasks: tuple[MotionTorque, ...]
    name: str = "task_torques"
    kind: ClassVar[str] = "task_torques"

    def __post_init__(self) -> None:
        widths = {task.q.shape[1] for task in self.tasks}
        if len(widths) != 1:
            raise FFGymError(f"A law of torques per task needs tasks of one robot, got {_names(self.tasks)}.")

    @property
    def n_joints(self) -> int:
        """Number of motors N."""
        return self.tasks[0].q.shape[1]

    def torque(self, reference: Reference) -> Array:
        """Return the torque of the motion that the reference is.

        Raises:
            FFGymError: if the reference is none of the motions.
        """
        return self._find(reference).torque.copy()

    def task(self, reference: Reference) -> Self:
        """Return the law for one of its motions alone, which runs sample by sample.

        Raises:
            FFGymError: if the reference is none of the motions.
        """
        return type(self)(tasks=(self._find(reference),), name=self.name)

    def initial_memory(self, window: Window) -> Array:
        """Return the number of the present sample, 0, shape (..., 1)."""
        self._only()
        return np.zeros((*window.q.shape[:-2], 1))

    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Return the torque of the next sample; the memory counts samples. After the motion its last torque stays.

        Raises:
            FFGymError: if the law has several tasks, or the reference is not where the task is.
        """
        task = self._only()
        last = len(task.q) - 1
        now = memory[..., 0].astype(np.intp)
        samples = np.minimum(now[..., None] + [0, 1], last)
        off_task = np.abs(window.q[..., :2, :] - task.q[samples]).max(axis=(-1, -2)) >= SAME
        if off_task.any():
            row = int(np.flatnonzero(off_task)[0])
            raise FFGymError(
                f"{self.name} runs the motion {task.name!r}, and at its sample {now.reshape(-1)[row]} the reference of "
                f"robot {row} of the batch is elsewhere: another motion, or one that did not begin when episode_start "
                f"said."
            )
        return task.torque[samples[..., 1]], memory + 1.0

    def parts(self) -> tuple[dict[str, Any], dict[str, Array]]:
        """Return the names of law and motions, and the arrays of each motion."""
        arrays = {f"{part}_{i}": getattr(task, part) for i, task in enumerate(self.tasks) for part in ("q", "torque")}
        return {"name": self.name, "tasks": [task.name for task in self.tasks]}, arrays

    @classmethod
    def from_parts(cls, settings: Mapping[str, Any], arrays: Mapping[str, Array]) -> Self:
        """Rebuild the law from `parts`."""
        tasks = (
            MotionTorque(name=str(name), q=arrays[f"q_{i}"], torque=arrays[f"torque_{i}"])
            for i, name in enumerate(settings["tasks"])
        )
        return cls(tasks=tuple(tasks), name=str(settings["name"]))

    def _find(self, reference: Reference) -> MotionTorque:
        for task in self.tasks:
            if same_motion(task.q, reference.q):
                return task
        raise FFGymError(
            f"{self.name} has no torque for the motion {reference.name!r}: it learned {_names(self.tasks)}. Let it "
            f"learn this motion too, or take a law for any motion."
        )

    def _only(self) -> MotionTorque:
        if len(self.tasks) > 1:
            raise FFGymError(
                f"{self.name} holds torques of {len(self.tasks)} motions, which begin alike: choose one for a run "
                f"sample by sample, law.task(reference)."
            )
        return self.tasks[0]


def _names(tasks: Sequence[MotionTorque]) -> str:
    return ", ".join(repr(task.name) for task in tasks) or "none"
