"""Trained agents that ship with the package: files by name, plant and seed, each with its command, physics and cost.

`agents/trained/<name>/manifest.json` lists the files beside it with their sha256; a file with another hash is refused.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_bytes, read_text, write_json
from ffgym.core.provenance import versions
from ffgym.core.typed_json import from_json, parse_json

TRAINED = Path(__file__).with_name("trained")
"""Folder of the trained agents in the package."""
ANYWHERE = "any"
"""Plant of an artefact that was not trained on the plant that it runs on."""
_MANIFEST = "manifest.json"


@dataclass(frozen=True, kw_only=True)
class Artefact:
    """One trained agent."""

    file: str
    """Name below the folder of its manifest."""
    sha256: str
    seed: int
    plant: str
    """Plant that it learned on and is for: 'nominal', 'workcell:<name>', or ANYWHERE."""
    fingerprint: str
    """Fingerprint of the physics that it learned on."""
    robot_seconds: float
    """Time that this machine moved for it [s]; 0 where it learned in simulation to be used elsewhere."""
    env_steps: int
    """Control steps of simulated training."""


@dataclass(frozen=True, kw_only=True)
class ArtefactManifest:
    """All artefacts of one name."""

    name: str
    command: str
    """Command that trains them again."""
    artefacts: tuple[Artefact, ...]
    versions: Mapping[str, str]
    learning_curve: tuple[tuple[float, float], ...] = ()
    """Steps and mean reward per step, mean over seeds."""

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds of all artefacts, ascending, each once."""
        return tuple(sorted({artefact.seed for artefact in self.artefacts}))

    def find(self, plant: str, seed: int) -> Artefact | None:
        """Return the artefact for a plant and a seed, or None."""
        for artefact in self.artefacts:
            if artefact.seed == seed and artefact.plant in (plant, ANYWHERE):
                return artefact
        return None


@cache
def read_manifest(name: str, folder: Path = TRAINED) -> ArtefactManifest | None:
    """Read the manifest of an agent; return None if nothing was trained under that name.

    Raises:
        FFGymError: if it is damaged.
    """
    place = folder / name / _MANIFEST
    if not place.exists():
        return None
    try:
        tree = parse_json(read_text(place), "it")
        artefacts = from_json(tuple[Artefact, ...], tree.pop("artefacts"), "artefacts")
        curve = tuple((float(x), float(y)) for x, y in tree.pop("learning_curve"))
        return ArtefactManifest(artefacts=artefacts, learning_curve=curve, **tree)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise FFGymError(f"{place}: is no manifest of trained agents: {error}. Install ffgym again.") from error


def locate_artefact(name: str, artefact: Artefact, folder: Path = TRAINED) -> Path:
    """Return the file of an artefact once its contents have been compared with the manifest.

    Raises:
        FFGymError: if it is missing, or its hash is not that of the manifest.
    """
    place = folder / name / artefact.file
    try:
        found = sha256(read_bytes(place)).hexdigest()
    except FFGymError as error:
        raise FFGymError(f"{error} Install ffgym again, or train it.") from error
    if found != artefact.sha256:
        raise FFGymError(
            f"{place}: has sha256 {found[:16]}..., its manifest says {artefact.sha256[:16]}...: one of them was "
            f"changed. Install ffgym again, or train it."
        )
    return place


def describe_artefact(name: str, file: str, folder: Path = TRAINED, **what: Any) -> Artefact:
    """Make the entry of a manifest for a file that was just written."""
    data = (folder / name / file).read_bytes()
    return Artefact(file=file, sha256=sha256(data).hexdigest(), **what)


def write_manifest(manifest: ArtefactManifest, folder: Path = TRAINED) -> None:
    """Write a manifest beside its artefacts."""
    write_json(folder / manifest.name / _MANIFEST, asdict(manifest))


def add_artefacts(name: str, command: str, new: Sequence[Artefact], folder: Path = TRAINED) -> None:
    """Put entries into the manifest of an agent, in place of old ones of the same seed and plant, by plant and seed."""
    before = read_manifest(name, folder)
    every = {(each.plant, each.seed): each for each in (*(() if before is None else before.artefacts), *new)}
    artefacts = tuple(every[key] for key in sorted(every))
    write_manifest(ArtefactManifest(name=name, command=command, artefacts=artefacts, versions=versions()), folder)
    read_manifest.cache_clear()
