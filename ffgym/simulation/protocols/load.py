"""Protocols by name, from motion files, and from files that list them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, final

from ffgym.core.errors import FFGymError, check_choice, check_whole
from ffgym.core.files import read_text
from ffgym.core.toml import parse_toml
from ffgym.paths.motions import load_motion
from ffgym.paths.motions.load import READERS
from ffgym.paths.motions.part import entry
from ffgym.simulation.protocols.mixtures import Circles, DiagnosisMotions
from ffgym.simulation.protocols.one_by_one import SlowTriangles, SpeedLadder, Table61
from ffgym.simulation.protocols.protocol import Protocol, Scheduled
from ffgym.simulation.protocols.rests import DwellRestart, Holds
from ffgym.simulation.protocols.stage import ProtocolStage
from ffgym.simulation.protocols.together import Excitation, WarmUp

MOST_REPEATS = 1000
"""Largest number of repeats of a motion; more are surely a slip."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class MotionFile(Protocol):
    """A built-in motion, or one from a motion file, a table or a RAPID program."""

    name = "motion"
    purpose = "any motion of one's own"

    file: str | Path = entry("built-in name, or a file: .toml, .csv, .mod")
    procedure: str | None = entry("of a RAPID program; absent is main, or the only one", default=None)
    repeats: int = entry("how often", default=1)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.file, str | Path):
            raise FFGymError(f"motion = {self.file!r} must be the name of a motion or a file.")
        if not isinstance(self.procedure, str | None):
            raise FFGymError(f"procedure = {self.procedure!r} must be the name of a procedure.")

    def motions(self, stage: ProtocolStage) -> list[Scheduled]:
        """Schedule the motion with its repeats."""
        repeats = check_whole("repeats", self.repeats, low=1, high=MOST_REPEATS)
        reference = load_motion(stage.arm, self.file, entry=self.procedure).reference
        if reference.robot is not stage.robot:
            raise FFGymError(
                f"{self.file} brings its own tool, which the other motions do not have. Give the tool to the robot's "
                f"description, and leave it out of the program."
            )
        if repeats == 1:
            return self.schedule_all([reference])
        return self.schedule_all([replace(reference, name=f"{reference.name}.{i}") for i in range(1, repeats + 1)])


PROTOCOLS: Mapping[str, type[Protocol]] = MappingProxyType(
    {
        protocol.name: protocol
        for protocol in (
            DiagnosisMotions,
            SpeedLadder,
            Table61,
            SlowTriangles,
            DwellRestart,
            WarmUp,
            Holds,
            Excitation,
            Circles,
        )
    }
)
"""Protocols by their names on command lines and in files."""


STEPS = "step"
"""Table of a file that lists protocols; a TOML file without it is a motion file."""


def load_protocols(source: str | Path) -> list[Protocol]:
    """Load the protocols that a command line names.

    Args:
        source: a name of PROTOCOLS; a motion file (.toml, .csv, .mod); or a TOML file of steps, see docs/protocols.md.

    Raises:
        FFGymError: if there is no such protocol or file, or a step of it makes no sense.
    """
    path = Path(source)
    if path.suffix.lower() not in READERS:
        if path.suffix or path.name != str(source):
            raise FFGymError(f"{source}: a file of motions must end in {', '.join(READERS)}.")
        return [PROTOCOLS[check_choice("protocol", str(source), list(PROTOCOLS))]()]
    if path.suffix.lower() == ".toml":
        tree = parse_toml(read_text(path), str(path))
        if STEPS in tree:
            return _steps(tree, path)
    return [MotionFile(file=path)]


def _steps(tree: Mapping[str, Any], path: Path) -> list[Protocol]:
    """Load the protocols that a file lists."""
    unknown, steps = sorted(set(tree) - {STEPS}), tree[STEPS]
    if unknown:
        raise FFGymError(f"{path}: unknown entries {', '.join(unknown)}. A file of steps has [[{STEPS}]] tables only.")
    if not isinstance(steps, list) or not steps or not all(isinstance(step, dict) for step in steps):
        raise FFGymError(f"{path}: {STEPS} must be tables, each of which begins with [[{STEPS}]].")
    protocols = []
    for i, step in enumerate(steps, start=1):
        try:
            protocols.append(_step(step, path.parent))
        except FFGymError as error:
            raise FFGymError(f"{path}: step {i}: {error}") from error
    return protocols


def _step(step: Mapping[str, Any], folder: Path) -> Protocol:
    """Load the protocol of one step; files are looked for in `folder`."""
    settings = dict(step)
    protocol, motion = settings.pop("protocol", None), settings.pop("motion", None)
    if (protocol is None) == (motion is None):
        raise FFGymError("a step needs either protocol = a name, or motion = a name or a file.")
    if protocol is not None:
        return PROTOCOLS[check_choice("protocol", protocol, list(PROTOCOLS))].parse(settings)
    if "file" in settings:
        raise FFGymError(f"file = {settings['file']!r} says the same as motion = {motion!r}; leave it out.")
    parsed = MotionFile.parse({**settings, "file": motion})
    return replace(parsed, file=folder / motion) if Path(motion).suffix else parsed
