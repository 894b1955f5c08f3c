"""Iterative learning control: the torque of one motion, corrected from trial to trial by the last error.

Idea and source: norm-optimal iterative learning control (Amann, Owens, Rogers 1996, Int. J. Control 65(2)), on the
linear answer of the controlled robot to added torque (`torque_response`). Trial j adds the torque u_j and measures the
error e_j at the control samples; then

    u_{j+1} = u_j + du,   du = argmin  sum_k |e_j - G du|^2 / epsilon^2 + sum_k |du / f_c|^2

with G the answer of the nominal model at the middle posture of the motion, f_c the motors' Coulomb friction, and
epsilon (`tolerance`) the error that weighs as much as a correction by f_c. Two members: `ilc_motor` learns from motor
positions and begins with dynamic LuGre, `ilc_tcp` learns from the TCP as a laser tracker sees it and begins with
elastic feed-forward. Torque is learned for the very motions that are given, and for no others.

Run it:

    ffgym demo --agents none lugre_dynamic ilc_tcp

Logged, per trial (`LearningHistory`): RMS length of e_j over each motion and over each circle, sqrt(mean_k |e_j,k|^2);
seconds of robot time so far, the sum of the durations of all motions run.

Departures from the source: the gain is stationary; the next torque is clipped to the torque that the drive has left
beside its own control, as the last trial shows it; the torque that did best is kept, not the last one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.agents.declaration import AgentEntry, AgentSetting, declare
from ffgym.agents.elastic import elastic_law
from ffgym.agents.law_files import StateFile, digest
from ffgym.agents.lugre import dynamic_lugre
from ffgym.agents.practice import LearningHistory, Practice, circle_names, read_practices, write_practices
from ffgym.agents.task_torques import MotionTorque, TaskTorques, same_motion
from ffgym.agents.torque_response import (
    TARGETS,
    NormOptimalStep,
    Target,
    TorqueResponse,
    at_samples,
    circle_rms,
    task_error,
)
from ffgym.agents.trials import Trial, run_trial
from ffgym.control import FeedForwardLaw, LawStyle, NoCompensation
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.core.measures import rms_length
from ffgym.core.types import Array
from ffgym.logs.preparation import read_motor_torque
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.robot import RigidArm
from ffgym.simulation import Run
from ffgym.simulation.run import Progress

TRIALS = 10
"""Trials of the catalogue's members. Chosen: even from zero torque, every circle of the thesis then has a path error
below 4 micrometres, a fifth of the noise of its laser tracker."""

TOLERANCES: Mapping[Target, float] = MappingProxyType({"motor": 4e-3, "tcp": 2e-5})
"""Default epsilon by target [rad, motor side] and [m]. Chosen: `tcp` is the noise of the laser tracker (thesis 2.2.4);
with `motor` every circle of the thesis improves in every trial, while less asks for more torque than the drives have on
the smallest circle at 100 mm/s. docs/agents/iterative.md tells the effect of others."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Learned:
    """Law and history that iterative learning returns."""

    law: TaskTorques
    history: LearningHistory


@dataclass(frozen=True, kw_only=True, eq=False)
class IterativeLearning:
    """Norm-optimal iterative learning control; all motions learn side by side, each for itself."""

    arm: RigidArm
    """Nominal model of the robot."""
    target: Target
    """Position whose error is learned from: of the 'motor', or of the 'tcp'."""
    tolerance: float | None = None
    """epsilon [rad], motor side, or [m]; larger learns more slowly and follows noise less. Defaults to TOLERANCES."""
    base: FeedForwardLaw = field(default_factory=NoCompensation)
    """Law whose torque the first trial has; defaults to zero torque."""

    def __post_init__(self) -> None:
        check_choice("target", self.target, TARGETS)
        if self.tolerance is not None:
            check_number("tolerance", self.tolerance, unit="rad or m", low=0.0, open_low=True)

    @property
    def epsilon(self) -> float:
        """Error that weighs as much as a correction by Coulomb friction [rad], motor side, or [m]."""
        return TOLERANCES[self.target] if self.tolerance is None else self.tolerance

    @property
    def name(self) -> str:
        """Name of the laws it makes."""
        return f"ilc_{self.target}"

    def learn(
        self,
        references: Sequence[Reference],
        trial: Trial,
        *,
        trials: int = TRIALS,
        progress: Progress | None = None,
        state: str | Path | None = None,
    ) -> Learned:
        """Learn the torque of every reference.

        Args:
            references: motions of the robot, all different.
            trial: runs them all once.
            trials: number of trials; the first has the base torque, and every torque that is returned has been tried.
            progress: called with the number of trials done and their total.
            state: file that is written after every trial; where it exists, learning goes on from there.

        Raises:
            FFGymError: if there is nothing to learn, a recording lacks what the target needs, or the state is of other
                learning.
        """
        trials = check_whole("trials", trials, low=1)
        _check_motions(references, self.arm.robot.n_joints)
        # corrections by the model, and practices, from the state file if there is one
        steps = [self._step(reference) for reference in references]
        practices = [
            Practice.begin(self.base.torque(reference), len(circle_names(reference))) for reference in references
        ]
        file = None
        if state is not None:
            settings = self._settings(references, steps, practices)
            file = StateFile(path=Path(state), kind="practice", settings=settings)
            practices = read_practices(file) or practices
        # one trial of all motions, then a correction of each torque
        for number in range(practices[0].trials, trials):
            runs = [
                Run(reference=reference, law=self._law([reference], [practice.torque]))
                for reference, practice in zip(references, practices, strict=True)
            ]
            recordings = run_trial(trial, runs, number)
            practices = [
                self._after(practice, run.reference, recording, step)
                for practice, run, recording, step in zip(practices, runs, recordings, steps, strict=True)
            ]
            # state after each trial, so that an interrupted practice can go on
            if file is not None:
                write_practices(file, practices)
            if progress is not None:
                progress(number + 1, trials)
        # law of the best torques, and history
        best = self._law(references, [practice.best for practice in practices])
        return Learned(law=best, history=LearningHistory.of(references, practices))

    def _step(self, reference: Reference) -> NormOptimalStep:
        """Make the correction by the model at the middle of the motion's joint angles."""
        middle = (reference.q.min(axis=0) + reference.q.max(axis=0)) / 2
        response = TorqueResponse.of(self.arm, middle, self.target)
        return NormOptimalStep.of(response, self.epsilon, self.arm.robot.friction.coulomb)

    def _settings(
        self, references: Sequence[Reference], steps: Sequence[NormOptimalStep], practices: Sequence[Practice]
    ) -> dict[str, Any]:
        """Return everything but the machine that learning depends on."""
        return {
            "target": self.target,
            "tolerance": self.epsilon,
            "motions": [reference.name for reference in references],
            "samples": digest(*(reference.q for reference in references)),
            "first torque": digest(*(practice.torque for practice in practices)),
            "model": digest(*chain.from_iterable((step.gain, step.from_error) for step in steps)),
        }

    def _law(self, references: Sequence[Reference], torques: Sequence[Array]) -> TaskTorques:
        pairs = zip(references, torques, strict=True)
        return TaskTorques(
            tasks=tuple(MotionTorque(name=r.name, q=r.q, torque=torque) for r, torque in pairs), name=self.name
        )

    def _after(self, practice: Practice, reference: Reference, recording: Recording, step: NormOptimalStep) -> Practice:
        """Correct the torque of a motion by the recording of its last trial."""
        error = task_error(recording, reference, self.target)
        wanted = practice.torque + step.correction(error)
        # torque that the drive has left beside its own control; more would never come, and pile up
        peak = self.arm.robot.drive.peak_torque
        feedforward, feedback = (
            read_motor_torque(reference.robot, recording, family)
            for family in ("feedforward.effort", "feedback.effort")
        )
        control = at_samples(feedforward + feedback, recording, reference)
        following = np.clip(wanted, -peak - control, peak - control)
        motion_error = rms_length(error)
        is_best = not (motion_error >= practice.motion_error).any()
        return Practice(
            torque=following,
            best=practice.torque if is_best else practice.best,
            motion_error=np.append(practice.motion_error, motion_error),
            circle_error=np.vstack([practice.circle_error, list(circle_rms(error, reference).values())]),
        )


def _check_motions(references: Sequence[Reference], n_joints: int) -> None:
    if not references:
        raise FFGymError("There is no motion to learn: references is empty. Learning per task needs the very motions.")
    for i, one in enumerate(references):
        if one.robot.n_joints != n_joints:
            raise FFGymError(
                f"The motion {one.name!r} for {one.robot.n_joints} joints does not fit a model with {n_joints}."
            )
        if any(same_motion(one.q, other.q) for other in references[:i]):
            raise FFGymError(f"The motion {one.name!r} is among the references twice; give each once.")


def _practise(setting: AgentSetting, target: Target, base: FeedForwardLaw) -> TaskTorques:
    """Learn torques in `TRIALS` trials, from those of a law."""
    return IterativeLearning(arm=setting.arm, target=target, base=base).learn(setting.references, setting.trial).law


declare(
    AgentEntry(
        name="ilc_motor",
        title="iterative learning on motor positions",
        about="Iterative learning of each motion from its motor errors: ten trials of every circle that is scored.",
        track="per task",
        order=10,
        page="iterative.md",
        style=LawStyle(label="iterative learning, motors", colour="#3B0F70", marker="<", line=":"),
        make=lambda setting: _practise(setting, "motor", dynamic_lugre(setting.robot)),
    ),
    AgentEntry(
        name="ilc_tcp",
        title="iterative learning on the tool's position",
        about="Iterative learning of each motion from the tool's errors: ten trials of every circle that is scored.",
        track="per task",
        order=11,
        page="iterative.md",
        style=LawStyle(label="iterative learning, tool", colour="#3B0F70", marker=">"),
        make=lambda setting: _practise(setting, "tcp", elastic_law(setting.arm, setting.controller)),
        needs_arm=True,
    ),
)
