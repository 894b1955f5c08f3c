"""Study of any motions of one robot, simulated with each feed-forward law and scored."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.recordings.metrics import contour_errors, motor_error
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import RECORD_DT, Rig, Run, SimulatedRig
from ffgym.simulation.run import Progress, one_robot
from ffgym.studies.selection import record_all


@dataclass(frozen=True, kw_only=True)
class StretchError:
    """Deviation of the TCP from its path on the whole motion or one phase of it [mm]; see `metrics.ContourError`."""

    label: str
    start: float
    """Start on the clock of the recording [s]; with `end` it distinguishes phases of one name."""
    end: float
    rms_mm: float
    max_mm: float
    lag_rms_mm: float
    lag_max_mm: float


@dataclass(frozen=True, kw_only=True)
class MotionResult:
    """One motion with one law. Per joint, shape (N,); standstill does not count."""

    agent: str
    motion: str
    motor_rms_rad: list[float]
    """Motor position error, motor side."""
    motor_max_rad: list[float]
    torque_use: list[float]
    """Largest commanded torque of the drive over its peak torque; above 1 the drive cannot give it."""
    speed_use: list[float]
    """Largest joint speed of the reference over the limit."""
    path: list[StretchError]
    """Deviation on the whole motion, then on its phases; empty if no TCP was recorded."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionStudy:
    """Results of motions of one robot."""

    robot: RobotDescription
    references: dict[str, Reference] = field(repr=False)
    """References by name of the motion."""
    results: list[MotionResult]
    recordings: dict[tuple[str, str], Recording] = field(repr=False)
    """Recordings by law and name of the motion."""

    @property
    def fingerprint(self) -> str:
        """Fingerprint of the simulated physics."""
        return str(next(iter(self.recordings.values())).header.provenance["physics_fingerprint"])

    @property
    def overloads(self) -> list[str]:
        """Sentences on motions and laws whose torque exceeds the drives', one each."""
        found = []
        for result in self.results:
            uses = zip(self.robot.joints, result.torque_use, strict=True)
            if over := [f"{use:.0%} of the peak torque of {joint}" for joint, use in uses if use > 1]:
                found.append(
                    f"{result.motion} with law {result.agent!r} asks {', '.join(over)}: the drives cannot follow; slow "
                    "it down."
                )
        return found

    def results_of(self, motion: str) -> list[MotionResult]:
        """Select the results of one motion, law by law."""
        return [result for result in self.results if result.motion == motion]

    @property
    def agents(self) -> list[str]:
        """Names of the laws, in their order."""
        return list(dict.fromkeys(agent for agent, _ in self.recordings))


def motion_study(
    references: Sequence[Reference],
    *,
    laws: Sequence[FeedForwardLaw],
    rig: Rig | None = None,
    seed: int = 0,
    record_dt: float = RECORD_DT,
    n_threads: int = 0,
    progress: Progress | None = None,
) -> MotionStudy:
    """Simulate and score motions.

    Args:
        references: motions of one robot.
        laws: feed-forward laws.
        rig: rig that runs them; defaults to that robot with exact recordings.
        seed: seed of the sensors' noise.
        record_dt: sample time of the recordings [s].
        n_threads: threads of the engine, 0 for all cores.
        progress: function that is called with the simulated seconds done and their total.

    Raises:
        FFGymError: if there is nothing to simulate, or two motions or two laws share a name, or one does
            not move.
    """
    motions, robot = name_motions(references), one_robot([Run(reference=reference) for reference in references])
    if not laws:
        raise FFGymError(f"A study of {', '.join(motions)} needs one law or more, with different names.")
    rig = rig or SimulatedRig(arm=RigidArm(robot))
    options = {"seed": seed, "record_dt": record_dt, "n_threads": n_threads, "progress": progress}
    return score_motion_study(motions, record_all(rig, motions, laws, **options))


def name_motions(references: Sequence[Reference]) -> dict[str, Reference]:
    """Return motions by their names.

    Raises:
        FFGymError: if there is none, two share a name, or one does not move.
    """
    names = [reference.name for reference in references]
    if not names or len(set(names)) < len(names):
        raise FFGymError(f"Motions {names} of one study must be at least one, with different names.")
    for reference in references:
        if not np.any(reference.dq):
            raise FFGymError(f"Motion {reference.name!r} is all standstill, so that it has no error to score.")
    return dict(zip(names, references, strict=True))


def score_motion_study(motions: dict[str, Reference], recordings: dict[tuple[str, str], Recording]) -> MotionStudy:
    """Score recordings, by agent and name of the motion, of the motions of one robot."""
    robot = one_robot([Run(reference=reference) for reference in motions.values()])
    results = [_result(agent, motions[motion], recording) for (agent, motion), recording in recordings.items()]
    return MotionStudy(robot=robot, references=motions, results=results, recordings=recordings)


def _result(agent: str, reference: Reference, recording: Recording) -> MotionResult:
    robot = reference.robot
    error = motor_error(recording)[~recording.mask(kind="standstill")]
    torque = recording.joint_array("command.effort")
    # contour error and lag by stretch, where the TCP was recorded
    path = [
        StretchError(
            label=stretch.label,
            start=stretch.start,
            end=stretch.end,
            rms_mm=stretch.rms * 1e3,
            max_mm=stretch.max * 1e3,
            lag_rms_mm=stretch.lag_rms * 1e3,
            lag_max_mm=stretch.lag_max * 1e3,
        )
        for stretch in (contour_errors(recording) if recording.has("tcp.position") else [])
    ]
    return MotionResult(
        agent=agent,
        motion=reference.name,
        motor_rms_rad=rms(error, 0).tolist(),
        motor_max_rad=np.abs(error).max(axis=0).tolist(),
        torque_use=(np.abs(torque).max(axis=0) / robot.drive.peak_torque).tolist(),
        speed_use=(np.abs(reference.dq).max(axis=0) / robot.kinematics.max_speed).tolist(),
        path=path,
    )
