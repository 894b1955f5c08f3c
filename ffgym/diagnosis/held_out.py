"""Distance of models from the machine on recordings that were not diagnosed: in closed loop, and replayed.

A diagnosis compares along the measured motion, where no controller hides anything. Here a model runs the references of
recordings under the documented controller, and its tracking errors, torques and tool positions are compared with those
that were measured.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError
from ffgym.core.measures import interpolate, rms
from ffgym.core.types import Array
from ffgym.diagnosis.computing import FAILED
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.log_columns import build_reference, widen_limits
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.residual import UNITS
from ffgym.diagnosis.residual_rows import compute_component_rms, compute_residuals
from ffgym.diagnosis.sampling import Sampling
from ffgym.logs.preparation import convert_to_motor_side, read_acting_torque
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.recordings.metrics import motor_error
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine
from ffgym.simulation.run import Progress

LOOP_UNITS = {"tracking error": "rad", "torque": "N m", "tool": "m"}
"""Quantities that are compared: reference minus motor angle, motor side; motor torque, motor side; tracked position."""


@dataclass(frozen=True, kw_only=True)
class LoopLevel:
    """Distance of simulation and machine in one component, RMS over all recordings."""

    quantity: str
    """One of LOOP_UNITS or a channel."""
    component: str
    """Joint, or axis of the world."""
    unit: str
    measured: float
    """RMS of what was measured, less its mean."""
    before: float
    """RMS of measured minus simulated, with the nominal model."""
    after: float
    """The same with the extended model."""


def compare_in_closed_loop(
    nominal: Machine,
    extended: Machine,
    recordings: Sequence[Recording],
    *,
    n_threads: int = 0,
    progress: Progress | None = None,
) -> tuple[LoopLevel, ...]:
    """Compare two models with the machine in full closed loop.

    Args:
        nominal: the model before.
        extended: the model after.
        recordings: of the machine, with the reference that its controller tracked, motor angles and torques; tool
            positions are compared where all have them. What a feed-forward law added is added here too.
        n_threads: of the simulation, 0 for all cores.
        progress: called now and then with the simulated seconds done and their total.

    Raises:
        FFGymError: if there are no recordings, one lacks what is needed or cannot be run again.
    """
    if not recordings:
        raise FFGymError("There is nothing to compare: name recordings that were not diagnosed.")
    # runs of the recorded motions, on both models in the climate of each recording
    robot = nominal.robot
    runs = [_run_again(nominal, recording) for recording in recordings]
    starts = [recording.header.meta.get("session_start", 0.0) for recording in recordings]
    machines = [
        [model.later(float(start)) if isinstance(start, int | float) else model for start in starts]
        for model in (nominal, extended)
    ]
    halves: tuple[Progress | None, Progress | None] = (None, None)
    if progress is not None:  # two simulations of as long motions, as an effect may need an engine of its own
        halves = (
            lambda done, total: progress(done, 2 * total),
            lambda done, total: progress(total + done, 2 * total),
        )
    before, after = (_simulate(runs, each, n_threads, half) for each, half in zip(machines, halves, strict=True))
    # RMS of measured and simulated over all recordings, by quantity and component
    has_tool = robot.tool is not None and all(recording.has("tcp.position") for recording in recordings)
    levels: list[LoopLevel] = []
    for quantity, unit in LOOP_UNITS.items():
        if quantity == "tool" and not has_tool:
            continue
        rows = [
            _compare(quantity, robot, recording, run, one, other)
            for recording, run, one, other in zip(recordings, runs, before, after, strict=True)
        ]
        own, first, second = (rms(np.concatenate([part[k] for part in rows]), 0) for k in range(3))
        names = ("x", "y", "z") if quantity == "tool" else robot.joints
        levels += [
            LoopLevel(quantity=quantity, component=name, unit=unit, measured=a, before=b, after=c)
            for name, a, b, c in zip(names, own.tolist(), first.tolist(), second.tolist(), strict=True)
        ]
    return tuple(levels)


def _simulate(
    runs: Sequence[Run], machines: Sequence[Machine], n_threads: int, progress: Progress | None
) -> Sequence[Recording | None]:
    """Simulate all runs; None for each if one cannot be simulated: such a model is infinitely far from any machine."""
    arm = RigidArm(runs[0].reference.robot)
    try:
        return simulate(runs, arm=arm, machine=machines, n_threads=n_threads, progress=progress)
    except FAILED:
        return [None] * len(runs)


def check_comparable(nominal: Machine, recordings: Sequence[Recording]) -> None:
    """Check before long work that recordings can be run again, and compared."""
    for recording in recordings:
        _run_again(nominal, recording)
        for quantity in LOOP_UNITS:
            if quantity != "tool":
                _signal(quantity, nominal.robot, recording)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RecordedLaw(FeedForwardLaw):
    """Feed-forward law that repeats what a law added in a recording."""

    name: ClassVar[str] = "recorded"
    added: Array
    """Motor side [N m], shape (T, N), at the samples of the reference."""

    def torque(self, reference: Reference) -> Array:
        """Return what was added in the recording, motor side [N m]."""
        return self.added


def _run_again(nominal: Machine, recording: Recording) -> Run:
    """Set up the run that repeats the motion of a recording, with what a law added to it."""
    reference = build_reference(widen_limits(nominal.robot, [recording]), recording)
    if not recording.has("compensation.effort"):
        law = recording.header.meta.get("feedforward_law", "none")
        if law != "none":
            raise FFGymError(
                f"Recording {recording.header.segment!r} was made with feed-forward law {law!r}, but has no "
                f"compensation.effort, so it cannot be run again."
            )
        return Run(reference=reference)
    added = _interpolate(reference.t, recording, recording.joint_array("compensation.effort"))
    added = convert_to_motor_side(nominal.robot.drive, recording.header, added)
    return Run(reference=reference, law=RecordedLaw(added=added))


def _compare(
    quantity: str,
    robot: RobotDescription,
    recording: Recording,
    run: Run,
    before: Recording | None,
    after: Recording | None,
) -> tuple[Array, Array, Array]:
    """Compute measured less its mean, and measured minus simulated for both models, through one low-pass.

    Infinite for a model that could not be simulated.
    """
    known = before or after
    t = run.reference.t if known is None else known.t
    sampling = Sampling.of(float(t[1] - t[0]), [len(t)])
    inside = sampling.valid(np.ones((len(t), 1), dtype=np.bool_))[:, 0]
    if not inside.any():
        raise FFGymError(f"Recording {recording.header.segment!r} is too short to be compared through a low-pass.")
    measured = _interpolate(t, recording, _signal(quantity, robot, recording))

    def far(model: Recording | None) -> Array:
        if model is None:
            return np.full_like(sampling(measured)[inside], np.inf)
        return sampling(measured - _signal(quantity, robot, model))[inside]

    return sampling(measured - measured.mean(axis=0))[inside], far(before), far(after)


def _signal(quantity: str, robot: RobotDescription, recording: Recording) -> Array:
    if quantity == "torque":
        return read_acting_torque(robot, recording)
    return recording.vector("tcp.position") if quantity == "tool" else motor_error(recording)


def _interpolate(t: Array, recording: Recording, values: Array) -> Array:
    """Interpolate values (T, C) of a recording linearly at other times since its beginning."""
    since, known = recording.t - recording.t[0], ~np.isnan(values).any(axis=1)
    return interpolate(t, since[known], values[known])


def is_better(levels: Sequence[LoopLevel]) -> bool:
    """Tell whether the second model leaves less than the first, each component in units of what the first leaves."""
    shares = [(level.after / level.before) ** 2 for level in levels if level.before > 0]
    return bool(shares) and float(np.mean(shares)) < 1.0


def compare_replays(
    before: Machine, after: Machine, recordings: Sequence[Recording], *, cutoff: float | None = None
) -> tuple[LoopLevel, ...]:
    """Replay two models along recordings, and compare what they leave.

    Args:
        before: the nominal model, as its file has it.
        after: the extended model, as its file has it.
        recordings: of the machine that were not diagnosed, with motor angle and torque.
        cutoff: of what is compared [Hz], that of the diagnosis; None is the usual one.

    Raises:
        FFGymError: if there are no recordings, or they do not fit the robot.
    """
    if not recordings:
        raise FFGymError("There is nothing to compare: name recordings that were not diagnosed.")
    # replay both models
    log = assemble_log(before.physical, recordings, cutoff=cutoff)
    rest = [compute_residuals(log, predict(replay(log, model))) for model in (before, after)]
    return tuple(
        LoopLevel(quantity=channel, component=name, unit=UNITS[channel], measured=measured, before=first, after=last)
        for channel, name, (measured, first, last) in compute_component_rms(log, *rest)
    )
