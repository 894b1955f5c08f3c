"""One-axis test of the thesis (4.3.1): a sine on one motor, with each feed-forward law."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms
from ffgym.paths import Reference, joint_reference, joint_sine
from ffgym.recordings import Recording
from ffgym.recordings.metrics import motor_error
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import SimulatedRig
from ffgym.studies.circles import thesis_laws
from ffgym.studies.selection import pick, record_all

AMPLITUDE = 1.0
"""A [rad], motor side, thesis (4.7)."""
FREQUENCIES = (1.0, 3.0)
"""f [Hz], thesis 4.3.1."""
DURATION = 10.0
"""[s], thesis 4.3.1."""
SETTLED = 1.0
"""Time from which errors count [s]: the bristles start relaxed at full speed, unlike those of any real motion."""


@dataclass(frozen=True, kw_only=True)
class SineResult:
    """Error of one law at one frequency."""

    agent: str
    frequency_hz: float
    motor_rms_rad: float
    motor_max_rad: float
    reduction: float
    """Reduction of the RMS as a share of the uncompensated one; 1 is all."""


@dataclass(frozen=True, kw_only=True, eq=False)
class OneAxisStudy:
    """Results of the one-axis test."""

    robot: RobotDescription
    results: list[SineResult]
    recordings: dict[tuple[str, float], Recording]
    """Recordings by law and frequency [Hz]."""

    def only(self, laws: Sequence[str] | None = None, frequencies: Sequence[float] | None = None) -> "OneAxisStudy":
        """Return the part of the study with these laws and frequencies [Hz]; None takes all."""
        keys = pick(self.recordings, law=laws, frequency=frequencies)
        return replace(
            self,
            results=[result for result in self.results if (result.agent, result.frequency_hz) in keys],
            recordings={key: self.recordings[key] for key in keys},
        )


def sine_references(robot: RobotDescription, frequencies: Sequence[float] = FREQUENCIES) -> dict[float, Reference]:
    """Make references of the sine test by frequency [Hz]; the motor swings by AMPLITUDE for any gear."""
    return {f: sine_reference(robot, f, AMPLITUDE, DURATION) for f in frequencies}


def sine_reference(robot: RobotDescription, frequency: float, amplitude: float, duration: float) -> Reference:
    """Make a sine of `frequency` [Hz], motor `amplitude` [rad] and `duration` [s] for a robot with one joint."""
    if robot.n_joints != 1:
        raise FFGymError(
            f"Robot {robot.name!r} has {robot.n_joints} joints; the sine test is for one, e.g. 'one_axis'. "
            f"ffgym/JointMotion-v0 moves all joints."
        )
    swing, dt = amplitude / np.abs(robot.drive.gear_ratio), robot.servo.control_dt
    return joint_reference(robot, joint_sine(swing, frequency, duration, dt=dt, name=f"sine {frequency:g} Hz"))


def one_axis_study(
    robot: RobotDescription, *, laws: Sequence[FeedForwardLaw] | None = None, frequencies: Sequence[float] = FREQUENCIES
) -> OneAxisStudy:
    """Simulate and score the sine test on a robot with one joint.

    Args:
        robot: the one-axis robot; it is its own plant.
        laws: feed-forward laws, the first as the baseline of the others; None takes those of chapter 4.
        frequencies: frequencies [Hz].

    Raises:
        FFGymError: if the robot has more than one joint, there is nothing to simulate, or two laws share a name.
    """
    laws = thesis_laws(robot) if laws is None else laws
    references = sine_references(robot, frequencies)
    recordings = record_all(SimulatedRig(arm=RigidArm(robot)), references, laws)
    errors = {key: motor_error(recording)[recording.t >= SETTLED, 0] for key, recording in recordings.items()}
    sizes = {key: rms(error) for key, error in errors.items()}
    results = [
        SineResult(
            agent=agent,
            frequency_hz=f,
            motor_rms_rad=sizes[agent, f],
            motor_max_rad=float(np.abs(errors[agent, f]).max()),
            reduction=1 - sizes[agent, f] / sizes[laws[0].name, f],
        )
        for agent, f in recordings
    ]
    return OneAxisStudy(robot=robot, results=results, recordings=recordings)
