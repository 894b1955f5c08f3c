"""Rounds of recording, diagnosing and extending, until the model explains the recordings or the rounds are used up."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError, check_whole
from ffgym.core.files import read_text, write_json, write_text
from ffgym.core.provenance import versions
from ffgym.core.temporaries import remove_remains
from ffgym.core.typed_json import parse_json
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
"""Pause between two sessions [s]; chosen: time to start the next one."""

_FITTED = ParameterPrior.of_share(settings().prior.fitted_share)
"""Prior of numbers that were fitted to the same recordings."""

Diagnose = Callable[[Machine, Sequence[Recording], ParameterPrior, int], Diagnosis]
"""Function that diagnoses a model by recordings of the machine, the prior of its numbers, and the largest number of
causes."""

Stage = Callable[[str, str], AbstractContextManager[Progress]]
"""Context of a piece of work that shows progress, by title and unit."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """Plan of the improvement of a model."""

    nominal: Machine
    """The model to begin with."""
    robot: str | Path
    """Robot in machine files: a built-in name, or the path of its description."""
    origins: tuple[Origin, ...] = ()
    """Origins of the numbers of effects that it has already."""
    fit: bool = False
    """True: all numbers of the model are fitted to the first recordings before the diagnosis, and again beside the
    causes of each round, as for a machine that is far from its description in many at once."""
    protocols: tuple[str, ...] = ("diagnosis",)
    """Protocols to record in each round, as for `ffgym record`."""
    rounds: int = 4
    """Largest number of rounds."""
    most_causes: int = 3
    """Largest number of causes of a diagnosis."""
    seed: int = 0
    """Seed of the sensors' noise."""
    n_threads: int = 0
    """Threads of the simulation, 0 for all cores."""

    def __post_init__(self) -> None:
        check_whole("rounds", self.rounds, low=1, high=20)
        check_whole("most causes", self.most_causes, low=1, high=settings().search.most_causes)
        check_whole("seed", self.seed, low=0)
        if not self.protocols:
            raise FFGymError("There is nothing to record in a round: name a protocol.")


@dataclass(frozen=True, kw_only=True, eq=False)
class ImprovementRound:
    """One session with its diagnosis and the extended model."""

    number: int
    """Number of the round, from 1 on."""
    protocols: tuple[str, ...]
    """Recorded protocols."""
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
    """File of that model."""

    @property
    def is_last(self) -> bool:
        """True if the diagnosis adds no cause."""
        return not self.diagnosis.causes


def improve_in_rounds(rig: Rig, plan: Plan, folder: Path, diagnose: Diagnose, stage: Stage) -> list[ImprovementRound]:
    """Improve a model in rounds on a machine; complete rounds in the folder are not made again.

    Each round records the protocols, and the motion that the diagnosis of the round before proposed to separate causes.

    Args:
        rig: the machine.
        plan: plan of the rounds.
        folder: folder for recordings, diagnoses and models, with a folder `round_1`, ... each.
        diagnose: diagnosis of a model by recordings.
        stage: context that shows progress.

    Raises:
        FFGymError: if something cannot be recorded, diagnosed or written.
    """
    rounds: list[ImprovementRound] = []
    machine, origins, proposed, clock = plan.nominal, plan.origins, list[Protocol](), 0.0
    prior = ParameterPrior()
    while len(rounds) < plan.rounds and not (rounds and rounds[-1].is_last):
        number = len(rounds) + 1
        place = folder / f"round_{number}"
        remove_remains(place)  # of a killed process; the folder around it is held by this one
        # record
        protocols = [protocol for name in plan.protocols for protocol in load_protocols(name)]
        motions = plan_session(rig.arm, [*protocols, *proposed], start=clock)
        with stage(f"recording, round {number}", "s") as progress:
            seed, origin, logs = plan.seed + number - 1, {"round": number}, place / "logs"
            record_into(logs, motions, rig, seed=seed, origin=origin, n_threads=plan.n_threads, progress=progress)
        recordings = read_folder(logs)
        if plan.fit and not rounds:
            machine, prior = _fit_numbers(place / "fitted", machine, plan, recordings, stage), _FITTED
        # diagnose
        before = machine
        with stage(f"diagnosing, round {number}", "") as progress:
            progress(0, 1)
            diagnosis = _diagnose(place, before, recordings, prior, plan.most_causes, diagnose)
            progress(1, 1)
        # extend the model, with all numbers fitted beside the causes if planned
        if plan.fit and diagnosis.causes:
            grown = extend_machine(before, diagnosis.causes)
            beside = _fit_numbers(place / "fitted_beside", grown, plan, recordings, stage)
            machine, diagnosis = replace(before, robot=beside.robot), replace(diagnosis, numbers=())
        model = place / "extended.toml"
        machine = save_extended(model, diagnosis, machine, robot=plan.robot, origins=origins, recordings=recordings)
        origins, clock = origins_of(model), motions[-1].end + PAUSE
        # motion of the next round that separates causes
        proposed = []
        if diagnosis.separating_motion is not None:
            write_text(place / "next.toml", diagnosis.separating_motion.toml)
            proposed = load_protocols(place / "next.toml")
        rounds.append(
            ImprovementRound(
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


def _fit_numbers(place: Path, machine: Machine, plan: Plan, recordings: Sequence[Recording], stage: Stage) -> Machine:
    """Fit all numbers of a machine to recordings, beside its effects; read the file if it is of these recordings."""
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


def _diagnose(
    place: Path,
    machine: Machine,
    recordings: Sequence[Recording],
    prior: ParameterPrior,
    most: int,
    diagnose: Diagnose,
) -> Diagnosis:
    """Diagnose a round; read the file in its folder if it is of these recordings, this model and as many causes."""
    key, file = place / "diagnosed.json", place / "diagnosis.json"
    about = _about(machine, recordings) | {"most_causes": most}
    if key.exists() and file.exists() and _json(key) == about:
        return read_diagnosis(file)
    diagnosis = diagnose(machine, recordings, prior, most)
    write_diagnosis(file, diagnosis)
    write_json(key, about)
    return diagnosis


def _about(machine: Machine, recordings: Sequence[Recording]) -> dict[str, Any]:
    """Return everything that a fit or a diagnosis depends on."""
    return {
        "session": recordings[0].header.provenance["session"],
        "model": machine.physics(ModelOptions(looks=False)),
        "versions": versions(),
    }


def _json(path: Path) -> Any:
    try:
        return parse_json(read_text(path), str(path))
    except FFGymError:  # damaged or empty: the diagnosis is made again
        return None
