"""Trials on the machine that is learned from: motions, runs, and lessons for each motor from recordings."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ffgym.control.setpoints import torque_at_rows
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.logs.preparation import read_joint_side, read_motor_side, read_motor_torque
from ffgym.paths import SPEEDS, Reference
from ffgym.recordings import Recording
from ffgym.recordings.metrics import motor_error
from ffgym.robot import ModelOptions, RigidArm, RobotDescription
from ffgym.simulation import RECORD_DT, Rig, Run, Sensor, SimulatedRig
from ffgym.simulation.sensors import sensors_of
from ffgym.simulation.shared_rig import Trial as Trial
from ffgym.studies import circle_references, sine_references
from ffgym.studies.one_axis import FREQUENCIES

Signal = Literal["u_p", "u_c", "e_p"]
SIGNALS: tuple[Signal, ...] = ("u_p", "u_c", "e_p")
"""Learning signals, thesis 5.2.1: feedback without its integral part, all of it, or K_p times the position error."""


def run_trial(trial: Trial, runs: Sequence[Run], number: int) -> list[Recording]:
    """Run a trial; return its recordings, one per run.

    Raises:
        FFGymError: if the machine returned another number of recordings.
    """
    recordings = list(trial(runs, number))
    if len(recordings) != len(runs):
        raise FFGymError(f"Trial {number} returned {len(recordings)} recordings of {len(runs)} runs, must be one each.")
    return recordings


@dataclass(frozen=True, kw_only=True, eq=False)
class RigTrial:
    """Trials on a rig; sensor noise differs from trial to trial and is the same in every program run."""

    rig: Rig
    seed: int = 0
    record_dt: float = RECORD_DT
    n_threads: int = 0

    def __call__(self, runs: Sequence[Run], number: int) -> list[Recording]:
        """Run motions on the rig; see `Trial`.

        Raises:
            FFGymError: if a run is for another number of joints, or cannot be simulated.
        """
        seed = int(np.random.SeedSequence([self.seed, number]).generate_state(1)[0])
        return self.rig.run(runs, seed=seed, record_dt=self.record_dt, n_threads=self.n_threads)


def add_sensors(rig: Rig) -> Rig:
    """Return the rig with the sensors of its robot, through which every learner sees a machine."""
    return replace(rig, sensors=sensors_of(rig.robot)) if isinstance(rig, SimulatedRig) else rig


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedTrial:
    """Trials on a simulated robot; as `RigTrial`."""

    arm: RigidArm
    """Model of the robot that moves; references may have been made with another one."""
    options: ModelOptions | None = None
    sensors: Sequence[Sensor] = ()
    seed: int = 0
    record_dt: float = RECORD_DT
    n_threads: int = 0

    def __call__(self, runs: Sequence[Run], number: int) -> list[Recording]:
        """Simulate the runs; see `RigTrial`."""
        rig = SimulatedRig(arm=self.arm, options=self.options, sensors=self.sensors)
        trial = RigTrial(rig=rig, seed=self.seed, record_dt=self.record_dt, n_threads=self.n_threads)
        return trial(runs, number)


class CountedTrial:
    """Trials of a machine, counted."""

    def __init__(self, trial: Trial) -> None:
        """Count from 0."""
        self.trial = trial
        self.trials = 0
        """Calls, each of which may run several motions."""
        self.robot_seconds = 0.0
        """Time that the machine moved [s]."""

    def __call__(self, runs: Sequence[Run], number: int) -> Sequence[Recording]:
        """Run and count; see `Trial`."""
        self.trials += 1
        self.robot_seconds += sum(run.reference.duration for run in runs)
        return self.trial(runs, number)


@dataclass(frozen=True, kw_only=True, eq=False)
class Lesson:
    """Lesson of one recording for each motor: T rows in time order, motor side unless said otherwise."""

    reference: Reference
    t: Array
    """Times [s], shape (T,)."""
    q: Array
    """Joint position of the reference [rad], link side, shape (T, N)."""
    motor_dq: Array
    """Motor speed of the reference [rad/s], shape (T, N)."""
    motor_ddq: Array
    """Motor acceleration of the reference [rad/s^2], shape (T, N)."""
    signal: Array
    """Missing torque, as the feedback shows it [N m], shape (T, N)."""
    added: Array
    """Torque that the law added [N m], shape (T, N)."""
    error: Array
    """Position error [rad], shape (T, N)."""
    moving: BoolArray
    """False while the reference stands still, shape (T,); friction at rest is no function of the reference."""

    @classmethod
    def of(cls, reference: Reference, recording: Recording, signal: Signal = "u_p") -> "Lesson":
        """Read a recording of a run along `reference`.

        Raises:
            FFGymError: if the signal is unknown, or the recording lacks a column or belongs to another reference.
        """
        rows_per_step = round(reference.robot.servo.control_dt / recording.dt)
        robot = reference.robot
        motor_dq = read_motor_side(robot, recording, "reference.velocity")
        motor_ddq = torque_at_rows(reference.motor_ddq, rows_per_step)  # a straight line between samples
        if motor_ddq.shape != motor_dq.shape:
            raise FFGymError(
                f"Recording {recording.header.segment!r} of {len(motor_dq)} rows every {recording.dt:g} s is not of "
                f"the motion {reference.name!r}, which lasts {reference.duration:g} s."
            )
        ended = recording.t >= reference.phases[-1].end  # the last sample lies up to a step beyond
        return cls(
            reference=reference,
            t=recording.t,
            q=read_joint_side(robot, recording, "reference.position"),
            motor_dq=motor_dq,
            motor_ddq=motor_ddq,
            signal=learning_signal(recording, robot, signal),
            added=read_motor_torque(robot, recording, "compensation.effort"),
            error=motor_error(recording),
            moving=~recording.mask(kind="standstill") & ~ended,
        )


def pick_evenly(moving: BoolArray, count: int) -> IntArray:
    """Pick at most `count` rows, spread evenly over those that move; return their indices."""
    rows = np.flatnonzero(moving)
    if len(rows) <= count:
        return rows
    return np.asarray(rows[np.linspace(0, len(rows) - 1, count).round().astype(np.int64)])


def learning_signal(recording: Recording, robot: RobotDescription, signal: Signal = "u_p") -> Array:
    """Compute the missing torque as the feedback shows it, motor side [N m], shape (T, N).

    Raises:
        FFGymError: if the signal is unknown, or the recording lacks a column.
    """
    check_choice("learning signal", signal, SIGNALS)
    if signal == "e_p":
        return robot.servo.position_gain * motor_error(recording)
    feedback = read_motor_torque(robot, recording, "feedback.effort")
    return feedback if signal == "u_c" else feedback - read_motor_torque(robot, recording, "feedback.integral")


def thesis_motions(arm: RigidArm) -> list[Reference]:
    """Make the one motion that chapter 5 learns on: circles at p1 at 10 mm/s, or the sine of 1 Hz on one axis."""
    return training_motions(arm, speeds=SPEEDS[:1], frequencies=FREQUENCIES[:1])


def every_speed(arm: RigidArm) -> list[Reference]:
    """Make the motions at every speed of the tests: p1 at 10, 40 and 100 mm/s, or sines of 1 and 3 Hz on one axis.

    They cover all speeds that a network will meet; thesis 5.5 finds networks weak above their training speed.
    """
    return training_motions(arm, speeds=SPEEDS, frequencies=FREQUENCIES)


def friction_motions(arm: RigidArm) -> list[Reference]:
    """Make motions whose feedback is mostly friction: p1 at 10 and 40 mm/s, or the sines of 1 and 3 Hz.

    At 100 mm/s the elastic joints need more torque than friction does, and a network over speed would learn that as
    friction: with it in training, the tool strays further at 100 mm/s than without (see docs/agents/bspline.md).
    """
    return training_motions(arm, speeds=SPEEDS[:2], frequencies=FREQUENCIES)


def training_motions(
    arm: RigidArm,
    positions: Sequence[str] | None = None,
    speeds: Sequence[float] = SPEEDS[:1],
    frequencies: Sequence[float] = FREQUENCIES[:1],
) -> list[Reference]:
    """Make test motions of the robot: circles on one with a work area, sines on one with a single joint.

    Args:
        arm: nominal model of the robot.
        positions: names in the work area (circles only); by default the first, p1 in thesis 5.3.2: others are held out.
        speeds: speeds of the TCP [m/s] (circles only).
        frequencies: frequencies [Hz] (sines only).

    Raises:
        FFGymError: if the robot has neither a work area nor one joint alone, or cannot follow a motion.
    """
    robot = arm.robot
    if robot.work_area is not None:
        names = list(robot.work_area.positions)[:1] if positions is None else positions
        return list(circle_references(arm, names, speeds).values())
    if robot.n_joints == 1:
        return list(sine_references(robot, frequencies).values())
    raise FFGymError(
        f"Robot {robot.name!r} has no work area and {robot.n_joints} joints, and so no test motion to learn on; "
        f"give references of your own."
    )
