"""Rehearsal of a trial on a simulated machine: all runs of a plan, with what differs from run to run on a real one."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ffgym.control import FeedForwardLaw, SetpointChannel
from ffgym.core.errors import check_number, check_whole
from ffgym.deployment.trial.matching import TrialLog
from ffgym.deployment.trial.plan import TrialPlan
from ffgym.effects.friction.coulomb import CoulombLevel
from ffgym.recordings import Recording
from ffgym.simulation import Rig, Run
from ffgym.simulation.plant import Machine
from ffgym.simulation.run import Progress

PAUSE = 10.0
"""Time between two runs [s]: the operator, or a cell controller, switches the correction and names the log."""
VARIATION = 0.02
"""Standard deviation of each joint's Coulomb friction from run to run, as a share; chosen: runs of one day repeat to a
few per cent, levels of one robot differ by 30 % over days and loads (Bittencourt 2012)."""
_BATCH = 1000.0
"""Motion that is simulated at a time [s], to bound memory."""


def rehearse(
    plan: TrialPlan,
    rig: Rig,
    law: FeedForwardLaw,
    *,
    channel: SetpointChannel | None = None,
    seed: int = 0,
    begin: float = 0.0,
    variation: float = VARIATION,
    pause: float = PAUSE,
    n_threads: int = 0,
    progress: Progress | None = None,
) -> Iterator[TrialLog]:
    """Carry out a plan on a simulated machine, and yield its logs in order.

    Friction of each joint differs from run to run, the machine warms up on the clock of the trial, and sensors are
    noisy; one clock runs through all logs.

    Args:
        plan: the plan.
        rig: the machine.
        law: what the correction does: a feed-forward law.
        channel: channel of set-points that it acts through; None adds its torque to the motors'.
        seed: of everything that is drawn.
        begin: time since that of the day that the machine is set up for [s].
        variation: standard deviation of each joint's Coulomb friction from run to run, as a share.
        pause: time between runs [s].
        n_threads: threads of the simulation, 0 for all cores.
        progress: called now and then with the simulated seconds done and their total.

    Raises:
        FFGymError: if a number is out of range, or the machine cannot make a run.
    """
    check_number("variation from run to run", variation, low=0.0, high=0.3)
    rng = np.random.default_rng(check_whole("seed", seed, low=0))
    own = rig.machine or Machine.of(rig.robot)
    # each planned run with its own time, friction and noise
    references = {program.name: program.make_reference(rig.arm, plan.laps) for program in plan.programs}
    any_one = next(iter(references.values()))
    kinds = {False: Run(reference=any_one), True: Run(reference=any_one, law=law, channel=channel)}
    starts = compute_starts(plan, begin=begin, pause=pause)
    machines = [vary_friction(own, variation, rng) for _ in plan.runs]
    streams = rng.spawn(len(plan.runs))
    size = max(1, int(_BATCH / max(reference.duration for reference in references.values())))
    for first in range(0, len(plan.runs), size):
        part = slice(first, first + size)
        recordings = rig.run(
            [replace(kinds[run.corrected], reference=references[run.program]) for run in plan.runs[part]],
            seed=streams[part],
            started=starts[part],
            machines=machines[part],
            n_threads=n_threads,
        )
        for run, start, recording in zip(plan.runs[part], starts[part], recordings, strict=True):
            yield TrialLog(run.log, _on_one_clock(recording, start - begin))
        if progress is not None:
            progress(min(first + size, len(plan.runs)) / len(plan.runs) * plan.seconds, plan.seconds)


def compute_starts(plan: TrialPlan, *, begin: float = 0.0, pause: float = PAUSE) -> list[float]:
    """Compute when each run begins [s], one after the other with pauses between."""
    pause = check_number("pause between runs", pause, unit="s", low=0.0, open_low=True)
    times = {program.name: plan.laps * (program.duration + program.recording.dt) for program in plan.programs}
    starts, now = [], check_number("begin of the trial", begin, unit="s", low=0.0)
    for run in plan.runs:
        starts.append(now)
        now += times[run.program] + pause
    return starts


def vary_friction(machine: Machine, variation: float, rng: np.random.Generator) -> Machine:
    """Return the machine with another Coulomb level of each joint, drawn about its own."""
    robot = machine.robot
    change = variation * rng.standard_normal(robot.n_joints)
    if not variation or not robot.friction.coulomb.any():
        return machine
    return replace(machine, effects=(*machine.effects, CoulombLevel(change=np.clip(change, -0.9, 0.9))))


def _on_one_clock(recording: Recording, since: float) -> Recording:
    """Move a recording to the clock of the trial, which is at `since` [s] when it begins."""
    columns = dict(recording.columns)
    for name in ("timestamp", "tcp.timestamp"):
        if name in columns:
            columns[name] = columns[name] + since
    phases = tuple(replace(p, start=p.start + since, end=p.end + since) for p in recording.header.phases)
    return recording.derive(columns, replace(recording.header, phases=phases))
