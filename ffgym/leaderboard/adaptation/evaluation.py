"""Runs of adapters on machines: all that learn at once side by side, then all laws on the scored motions in batches."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice

from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError
from ffgym.core.provenance import versions
from ffgym.leaderboard.adaptation.protocol import Adapter, BudgetedTrial, score, scored_motions
from ffgym.leaderboard.adaptation.results import AdaptationRun
from ffgym.robot import RigidArm
from ffgym.simulation import Rig, Run, simulate
from ffgym.simulation.plant import Machine
from ffgym.simulation.sensors import Sensor
from ffgym.simulation.shared_rig import Trial, learn_together

TOGETHER = 40
"""Learners side by side; effects of machines cost less each in a batch. Chosen: some hundred megabytes."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Subject:
    """A machine to adapt to, under its controller."""

    name: str
    rig: Rig
    """Rig with the sensors through which adapters see the machine."""

    @property
    def machine(self) -> Machine:
        """The machine itself."""
        return self.rig.machine or Machine.of(self.rig.robot)


@dataclass(frozen=True, kw_only=True, eq=False)
class AdaptationEntry:
    """An adapter with a budget and a seed on a machine, still to be run."""

    adapter: Adapter
    laps: int
    seed: int
    subject: Subject

    @property
    def key(self) -> tuple[str, str, int, int]:
        """Identity, as of an `AdaptationRun`."""
        return self.adapter.name, self.subject.name, self.laps, self.seed


def list_entries(adapters: Sequence[Adapter], subjects: Sequence[Subject]) -> list[AdaptationEntry]:
    """List everything to run: each adapter with each of its budgets and seeds on each machine.

    Raises:
        FFGymError: if two adapters share a name.
    """
    names = [adapter.name for adapter in adapters]
    if len(set(names)) < len(names):
        raise FFGymError(f"Adapters {names} must have different names.")
    return [
        AdaptationEntry(adapter=adapter, laps=laps, seed=seed, subject=subject)
        for adapter in adapters
        for laps in adapter.laps
        for seed in adapter.seeds
        for subject in subjects
    ]


def evaluate(entries: Sequence[AdaptationEntry], n_threads: int = 0) -> Iterator[list[AdaptationRun]]:
    """Run entries in groups that share a controller and sensors, and yield the runs of each group."""
    controllers: dict[tuple[RigidArm, tuple[Sensor, ...]], list[AdaptationEntry]] = {}
    for entry in entries:
        rig = entry.subject.rig
        controllers.setdefault((rig.arm, tuple(rig.sensors)), []).append(entry)
    for group in controllers.values():
        rest = iter(group)
        while chunk := list(islice(rest, TOGETHER)):
            yield run_entries(chunk, n_threads)


def run_entries(entries: Sequence[AdaptationEntry], n_threads: int = 0) -> list[AdaptationRun]:
    """Run entries of one controller with the same sensors, side by side."""
    rig = entries[0].subject.rig
    # laws, which those that learn make side by side
    trials: dict[int, BudgetedTrial] = {}

    def learn(i: int, entry: AdaptationEntry, trial: Trial) -> FeedForwardLaw:
        law, trials[i] = entry.adapter.practise(rig.arm, trial, laps=entry.laps, seed=entry.seed)
        return law

    learners: dict[int, tuple[int, Callable[[Trial], FeedForwardLaw]]] = {
        i: (entry.seed, partial(learn, i, entry)) for i, entry in enumerate(entries)
    }
    machines = {i: entry.subject.machine for i, entry in enumerate(entries)}
    laws = learn_together(rig, learners, n_threads, machines)
    # the score, by the true way of the tool
    motions = scored_motions(rig.arm)
    recordings = simulate(
        [Run(reference=motion, law=laws[i]) for i in range(len(entries)) for motion in motions],
        arm=rig.arm,
        machine=[machines[i] for i in range(len(entries)) for _ in motions],
        n_threads=n_threads,
    )
    errors = [float(f"{score(each) * 1e6:.6g}") for each in recordings]
    size = len(motions)
    return [
        AdaptationRun(
            adapter=entry.adapter.name,
            machine=entry.subject.name,
            laps=entry.laps,
            budget_s=round(trials[i].budget, 6),
            robot_seconds=round(trials[i].robot_seconds, 6),
            seed=entry.seed,
            fingerprint=entry.subject.rig.fingerprint,
            versions=", ".join(f"{name} {version}" for name, version in versions().items()),
            artefact=entry.adapter.artefact(entry.seed),
            rms_um=tuple(errors[i * size : (i + 1) * size]),
        )
        for i, entry in enumerate(entries)
    ]
