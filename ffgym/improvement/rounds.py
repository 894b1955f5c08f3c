"""Rounds of record, diagnose, extend: until the model explains what is measured, or the rounds are used up."""

import json
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError, check_whole
from ffgym.core.files import read_text, write_json, write_text
from ffgym.core.provenance import versions
from ffgym.diagnosis.diagnosis_file import read_diagnosis, write_diagnosis
from ffgym.diagnosis.extended import extend_machine, save_extended
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.result import Diagnosis
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.tuning import tune
from ffgym.effects import Origin
from ffgym.recordings import Recording
from ffgym.recordings.io import read_folder
from ffgym.robot import ModelOptions
from ffgym.simulation import Rig
from ffgym.simulation.plant import Machine, load_machine, save_machine
from ffgym.simulation.plant.machine_file import origins_of
from ffgym.simulation.protocols import Protocol, load_protocols, plan_session, record_into
from ffgym.simulation.run import Progress

PAUSE = 60.0
"""Between two sessions [s]; chosen: what it takes to start the next one."""

_FITTED = ParameterPrior.of_share(settings().prior.fitted_share)
"""How well numbers are known that were fitted to the very recordings."""

Diagnose = Callable[[Machine, Sequence[Recording], ParameterPrior, int], Diagnosis]
"""What a model lacks, by recordings of the machine, how well the numbers of the model are known, and the most causes to
look for."""

Stage = Callable[[str, str], AbstractContextManager[Progress]]
"""Something that takes its time: its title and the unit of its progress."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """How a model is improved."""

    nominal: Machine
    """The model to begin with."""
    robot: str | Path
    """What machine files call its robot: a built-in name, or the path of its description."""
    origins: tuple[Origin, ...] = ()
    """Where numbers of effects come from that it has already."""
    fit: bool = False
    """Whether all numbers of the model are fitted to the first recordings before it is diagnosed, and again beside the
    causes of each round, as for a machine that is far from its description in many at once."""
    protocols: tuple[str, ...] = ("diagnosis",)
    """What is recorded in each round, as for `ffgym record`."""
    rounds: int = 4
    """At most."""
    most_causes: int = 3
    """Causes that a diagnosis looks for."""
    seed: int = 0
    """Of the sensors' noise."""
    n_threads: int = 0
    """Of the simulation, 0 for all cores."""

    def __post_init__(self) -> None:
        check_whole("rounds", self.rounds, low=1, high=20)
        check_whole("most causes", self.most_causes, low=1, high=settings().search.most_causes)
        check_whole("seed", self.seed, low=0)
        if not self.protocols:
            raise FFGymError("There is nothing to record in a round: name a protocol.")


@dataclass(frozen=True, kw_only=True, eq=False)
class Round:
    """One session, and what it said."""

    number: int
    """From 1 on."""
    protocols: tuple[str, ...]
    """What was recorded."""
    seconds: float
    """Time that the machine moved [s]."""
    logs: Path
    """Folder of the recordings."""
    before: Machine
    """The model that was diagnosed: that of the round before, or the fitted one."""
    diagnosis: Diagnosis
    machine: Machine
    """The model from now on."""
    model: Path
    """Its file."""

    @property
    def is_last(self) -> bool:
        """Whether there is nothing to add."""
        return not self.diagnosis.causes


def improved(rig: Rig, plan: Plan, folder: Path, diagnose: Diagnose, stage: Stage) -> list[Round]:
    """Rounds on a machine; what is complete in the folder is not made again.

    Each round records the protocols, and what the diagnosis of the round before proposed to tell causes apart.

    Args:
        rig: the machine.
        plan: how to go about it.
        folder: for recordings, diagnoses and models, a folder `round_1`, ... each.
        diagnose: what a model lacks.
        stage: shows progress.

    Raises:
        FFGymError: if something cannot be recorded, diagnosed or written.
    """
    rounds: list[Round] = []
    machine, origins, proposed, clock = plan.nominal, plan.origins, list[Protocol](), 0.0
    prior = ParameterPrior()
    while len(rounds) < plan.rounds and not (rounds and rounds[-1].is_last):
        number = len(rounds) + 1
        place = folder / f"round_{number}"
        protocols = [protocol for name in plan.protocols for protocol in load_protocols(name)]
        motions = plan_session(rig.arm, [*protocols, *proposed], start=clock)
        with stage(f"recording, round {number}", "s") as progress:
            seed, origin, logs = plan.seed + number - 1, {"round": number}, place / "logs"
            record_into(logs, motions, rig, seed=seed, origin=origin, n_threads=plan.n_threads, progress=progress)
        recordings = read_folder(logs)
        if plan.fit and not rounds:
            machine, prior = _fitted(place / "fitted", machine, plan, recordings, stage), _FITTED
        before = machine
        with stage(f"diagnosing, round {number}", "") as progress:
            progress(0, 1)
            diagnosis = _diagnosed(place, before, recordings, prior, plan.most_causes, diagnose)
            progress(1, 1)
        if plan.fit and diagnosis.causes:
            grown = extend_machine(before, diagnosis.causes)
            beside = _fitted(place / "fitted_beside", grown, plan, recordings, stage)
            machine, diagnosis = replace(before, robot=beside.robot), replace(diagnosis, numbers=())
        model = place / "extended.toml"
        machine = save_extended(model, diagnosis, machine, robot=plan.robot, origins=origins, recordings=recordings)
        origins, clock = origins_of(model), motions[-1].end + PAUSE
        proposed = []
        if diagnosis.separating_motion is not None:
            write_text(place / "next.toml", diagnosis.separating_motion.toml)
            proposed = load_protocols(place / "next.toml")
        rounds.append(
            Round(
                number=number,
                protocols=tuple(dict.fromkeys(motion.protocol for motion in motions)),
                seconds=sum(motion.reference.duration for motion in motions),
                logs=logs,
                before=before,
                diagnosis=diagnosis,
                machine=machine,
                model=model,
            )
        )
    return rounds


def _fitted(place: Path, machine: Machine, plan: Plan, recordings: Sequence[Recording], stage: Stage) -> Machine:
    """A machine with numbers that predict recordings best beside its effects: as in the file, if it is of these."""
    key, file, about = place.with_suffix(".json"), place.with_suffix(".toml"), _about(machine, recordings)
    if not (key.exists() and file.exists() and _json(key) == about):
        title, source = f"{machine.robot.title}, fitted by ffgym improve", "fitted to recordings, all numbers together"
        with stage("fitting all numbers", "") as progress:
            progress(0, 1)
            found = tune(machine, recordings)
            progress(1, 1)
        save_machine(found, file, title=title, source=source, robot=plan.robot)
        write_json(key, about)
    return load_machine(file)


def _diagnosed(
    place: Path,
    machine: Machine,
    recordings: Sequence[Recording],
    prior: ParameterPrior,
    most: int,
    diagnose: Diagnose,
) -> Diagnosis:
    """The diagnosis of a round: the one in its folder, if it is of these recordings, this model and as many causes."""
    key, file = place / "diagnosed.json", place / "diagnosis.json"
    about = _about(machine, recordings) | {"most_causes": most}
    if key.exists() and file.exists() and _json(key) == about:
        return read_diagnosis(file)
    diagnosis = diagnose(machine, recordings, prior, most)
    write_diagnosis(file, diagnosis)
    write_json(key, about)
    return diagnosis


def _about(machine: Machine, recordings: Sequence[Recording]) -> dict[str, Any]:
    """What a fit or a diagnosis depends on."""
    return {
        "session": recordings[0].header.provenance["session"],
        "model": machine.physics(ModelOptions(looks=False)),
        "versions": versions(),
    }


def _json(path: Path) -> Any:
    try:
        return json.loads(read_text(path))
    except ValueError:  # damaged or empty: the diagnosis is made again
        return None
