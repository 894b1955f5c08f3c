"""Sessions: motions of several protocols on one clock, and their recordings as the machine's sensors see them."""

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import final

import numpy as np

from ffgym.control import FeedForwardLaw, NoCompensation
from ffgym.core.errors import FFGymError, check_class, check_number, check_whole
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import RECORD_DT, Rig, Run, Sensor, Thermometer, sensors_of
from ffgym.simulation.protocols.protocol import Protocol
from ffgym.simulation.run import Progress

_DIGITS = 6
"""Digits to which starts on the clock of the session [s] are rounded."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SessionMotion:
    """Motion of a session."""

    reference: Reference
    """Motion; its name is unique, also as the name of a file."""
    protocol: str
    """Name of its protocol."""
    start: float
    """Start on the clock of the session [s]."""

    @property
    def end(self) -> float:
        """End on the clock of the session [s]."""
        return self.start + self.reference.duration

    @property
    def stem(self) -> str:
        """Name of the file, without suffix."""
        return re.sub(r"[^\w.-]", "_", self.reference.name)


def plan_session(arm: RigidArm, protocols: Sequence[Protocol], *, start: float = 0.0) -> list[SessionMotion]:
    """Plan motions of protocols for a robot, one after the other.

    Args:
        arm: the robot.
        protocols: one or more; motions of one that comes twice get numbers.
        start: when the first one begins, on the clock of the session [s], which is 0 at the time of the day that the
            machine is set up for.

    Raises:
        FFGymError: if there is no protocol, or the robot cannot make one of the motions.
    """
    check_class("arm", arm, RigidArm, "RigidArm(robot) makes one of a description")
    if not protocols:
        raise FFGymError("There is nothing to record: name a protocol. ffgym record --list shows them.")
    motions: list[SessionMotion] = []
    check_number("start", start, unit="s")
    for protocol in protocols:
        check_class("protocol", protocol, Protocol, "e.g. SpeedLadder()")
        for scheduled in protocol.schedule(arm):
            begin = start if not motions else round(motions[-1].end + scheduled.pause, _DIGITS)
            motions.append(SessionMotion(reference=scheduled.reference, protocol=protocol.name, start=begin))
    return _with_own_names(motions)


def _with_own_names(motions: Sequence[SessionMotion]) -> list[SessionMotion]:
    """Rename motions so that names of their files differ, also if a file system ignores case."""
    used: set[str] = set()
    named = []
    for motion in motions:
        first, count = motion.reference, 1
        while motion.stem.lower() in used:
            count += 1
            motion = replace(motion, reference=replace(first, name=f"{first.name}.{count}"))
        used.add(motion.stem.lower())
        named.append(motion)
    return named


BATCH = 1000.0
"""Motions are simulated together up to this much time [s], less where samples are closer than RECORD_DT; chosen: a
physics step of a machine with effects costs little more for many motions than for one, and those of six axes take
1.4 GB (measured with the speed ladder of irb4600_60_205)."""

THERMOMETER = Thermometer(noise=0.1, resolution=0.1)
"""Temperature sensor of a machine that warms up; chosen: a common resistance thermometer."""


def usual_sensors(robot: RobotDescription) -> tuple[Sensor, ...]:
    """Return default sensors: resolvers, the tracker of the description, a thermometer."""
    return (*sensors_of(robot), THERMOMETER)


def record(
    motions: Sequence[SessionMotion],
    rig: Rig,
    *,
    law: FeedForwardLaw | None = None,
    seed: int = 0,
    record_dt: float = RECORD_DT,
    n_threads: int = 0,
    progress: Progress | None = None,
    only: Collection[int] | None = None,
) -> Iterator[Recording]:
    """Yield recordings of the motions of a session, in order, batch by batch.

    A recording depends neither on those around it nor on which of them are made: each motion has its own randomness.

    Args:
        motions: from `plan_session`.
        rig: where they are run. A machine that warms up does so on the clock of the session.
        law: feed-forward law; None is none.
        seed: of the sensors' noise.
        record_dt: sample time of the recordings [s].
        n_threads: threads of the simulation, 0 for all cores.
        progress: called now and then with the simulated seconds done and their total.
        only: places in `motions` of those that are made; None makes all.

    Raises:
        FFGymError: if an option does not fit, or a simulation becomes unstable.
    """
    # randomness of each motion, wanted or not, so that it does not depend on the choice
    generators = np.random.default_rng(check_whole("seed", seed, low=0)).spawn(len(motions))
    law = law or NoCompensation()
    wanted = [i for i in range(len(motions)) if only is None or i in only]
    total, before = sum(motions[i].reference.duration for i in wanted), 0.0
    longest = BATCH * min(1.0, check_number("record_dt", record_dt, unit="s", low=0.0, open_low=True) / RECORD_DT)

    def shift(before: float, done: float, _: float) -> None:
        assert progress is not None
        progress(before + done, total)

    # batches bound the memory of a long session
    for batch in _batches(motions, wanted, longest):
        recordings = rig.run(
            [Run(reference=motions[i].reference, law=law) for i in batch],
            seed=[generators[i] for i in batch],
            started=[motions[i].start for i in batch],
            record_dt=record_dt,
            n_threads=n_threads,
            progress=None if progress is None else partial(shift, before),
        )
        before += sum(motions[i].reference.duration for i in batch)
        for i, recording in zip(batch, recordings, strict=True):
            header = recording.header
            meta = header.meta | {"protocol": motions[i].protocol, "session_start": motions[i].start}
            header = replace(header, meta=meta, provenance=header.provenance | {"seed": seed})
            yield recording.derive(recording.columns, header)


def _batches(motions: Sequence[SessionMotion], wanted: Sequence[int], longest: float) -> Iterator[list[int]]:
    """Yield indices of motions that run together: as many as reach `longest` [s]."""
    batch: list[int] = []
    for i in wanted:
        batch.append(i)
        if sum(motions[k].reference.duration for k in batch) >= longest:
            yield batch
            batch = []
    if batch:
        yield batch
