"""Inputs of a diagnosis: logs from files, folders or the package, and the nominal model by its name."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import check_there, read_text, write_text
from ffgym.diagnosis.nominal import EXAMPLE_ROBOT, example_logs, fit_nominal
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.thinning import thin
from ffgym.effects import Origin
from ffgym.envs.machines import load_described_robot
from ffgym.logs import load_columns, read_logs
from ffgym.logs.quality import condition_alike
from ffgym.logs.read import correct_offsets
from ffgym.recordings import Recording, read_recording
from ffgym.recordings.io import SUFFIX, Stored, read_folder, recording_files
from ffgym.robot import RobotDescription, RobotDraft
from ffgym.robot.template import complete_text
from ffgym.simulation.plant import Machine, load_machine
from ffgym.simulation.plant.machine_file import is_machine_file, origins_of, robot_reference

ROBOT = "robot.toml"
"""Description of a robot that was made whole by stand-ins, beside the models that name it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Nominal:
    """The model that is diagnosed."""

    machine: Machine
    reference: str | Path
    """Name of the robot in a machine file: a built-in name, or the path of a description."""
    origins: tuple[Origin, ...] = ()
    """Origins of the effects that it has already."""
    prior: ParameterPrior | None = None
    """Uncertainty of its numbers, if they were fitted to the logs."""
    draft: RobotDraft | None = None
    """Its description as read, if numbers were fitted that it lacks."""

    @property
    def knows_servo(self) -> bool:
        """Tell whether its servo is documented, so that its closed loop can be simulated."""
        missing = () if self.draft is None else self.draft.missing
        return not any(path.startswith("servo.") for path in missing)

    def describe_in(self, folder: Path) -> str | Path:
        """Name for machine files in a folder of the robot; a description that lacks entries is made whole there."""
        if self.draft is None or not self.draft.missing:
            return self.reference
        path = Path(self.reference)
        toml = complete_text(read_text(path), self.draft, self.machine.robot, before=path.parent, folder=folder)
        write_text(folder / ROBOT, toml)
        return folder / ROBOT


def logs_from(paths: Sequence[Path], columns: str | None, robot: RobotDescription) -> list[Recording]:
    """Recordings in files and folders, conditioned; the example logs if none is named.

    A name that several motions have gets that of its folder or file before it. A log that is too long is thinned;
    recordings in NPZ files are then read column by column, and never are in memory as a whole.

    Raises:
        FFGymError: if one cannot be read.
    """
    if not paths:
        return example_logs()
    read = [(path, source) for path in paths for source in _read(path, columns, robot)]
    names = [source.header.segment for _, source in read]
    named = [
        source.rename(f"{path.stem}/{source.header.segment}") if names.count(source.header.segment) > 1 else source
        for path, source in read
    ]
    return condition_alike(thin(named))


def nominal_named(name: str | None) -> Nominal:
    """The machine of a machine file, or a robot without anything beside it; that of the example logs for None.

    Raises:
        FFGymError: if there is none of that name, or it cannot be read.
    """
    name = EXAMPLE_ROBOT if name is None else name
    if not is_machine_file(name):
        return Nominal(machine=Machine(robot=load_described_robot(name)), reference=name)
    return Nominal(machine=load_machine(name, partial=True), reference=robot_reference(name), origins=origins_of(name))


def identify_nominal(draft: RobotDraft, reference: str | Path, recordings: Sequence[Recording]) -> Nominal:
    """Fit the nominal model: masses, rotors and friction that predict the torque of recordings best.

    Raises:
        FFGymError: if recordings do not fit the robot, or do not tell its numbers.
    """
    machine, prior = fit_nominal(draft if draft.missing else draft.complete(), recordings)
    return Nominal(machine=machine, reference=reference, prior=prior, draft=draft)


def _read(path: Path, columns: str | None, robot: RobotDescription) -> Sequence[Recording | Stored]:
    check_there(path)
    if columns is None:
        return [_open(file) for file in (recording_files(path) if path.is_dir() else [path])]
    if path.is_dir() and (made := load_columns(columns)).is_for_recordings:
        return [correct_offsets(recording, made) for recording in read_folder(path)]
    return read_logs(path, columns, robot=robot)


def _open(path: Path) -> Recording | Stored:
    """The recording in a file; its columns are not yet read if they can be read one at a time."""
    if path.suffix.lower() != SUFFIX:
        return read_recording(path)
    try:
        stored = Stored(path)
        is_in_order = len(stored.t) > 1 and bool(np.all(np.diff(stored.t) > 0))
    except FFGymError:
        is_in_order = False
    return stored if is_in_order else read_recording(path)  # which tells what is wrong
