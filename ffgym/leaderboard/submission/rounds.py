"""Rounds: machines and motions drawn from a seed, which is committed to by a hash first and revealed afterwards.

A commitment binds its author to a seed and tells nothing of it: the hash covers a random salt, so that seeds cannot be
tried one by one. Once seed and salt are published, anyone can check them, and repeat the round.
"""

import hashlib
import json
import os
import secrets
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.core.files import read_text
from ffgym.core.typed_json import from_json, parse_json
from ffgym.envs.machines import WORKCELL
from ffgym.leaderboard.motions import CIRCLE, KINDS, TILTED
from ffgym.leaderboard.plants import find_plant
from ffgym.leaderboard.tasks import Task
from ffgym.robot.parts import WorkArea

FORMATS = 1, 2
"""Versions of the files of rounds; see docs/leaderboard/submissions.md. The first has circles alone and does not say
so, and its hash does not cover the kinds of motions."""
DRAWN = "drawn"
"""Split of circles that are drawn; that of another kind of motion has its name behind it."""
SERIES = WORKCELL
"""Series of the machines of a verification: prefix of their names, which a number follows."""
MACHINES, MOTIONS = 10, 6
"""Machines and motions of a verification. Chosen: intervals over ten machines, in a minute on two cores."""
SEEDS = 10**6, 10**9
"""Range of the numbers of drawn machines; trainings and pages use smaller ones, and there are too many to learn all."""
RADII = 0.001, 0.005
"""Range of radii [m], those of the thesis; uniform in the logarithm."""
WIDER = 2.0
"""Half a side of a square, and last radius of a spiral, in the radius that is drawn; chosen: such motions then last as
long as a circle with its leads."""
TILTS = np.deg2rad(10.0), np.deg2rad(45.0)
"""Range of the tilt of a plane [rad], uniform, to any side; chosen: the built-in motion `tilted_circles` has 40 deg."""
SPEEDS = 0.02, 0.1
"""Range of speeds [m/s], uniform in the logarithm. Chosen: from twice the slowest of the thesis, which takes long."""
INSIDE = 0.05, 0.35
"""Range of the way from a position of the work area to its middle that a centre lies off that position, along each axis
[1]; chosen: 10 to 70 mm of the 40 cm of the area, so that no centre is one that agents learn on."""
_ROUNDS = 20261127
"""First number of the seeds of rounds, so that no other draw repeats them."""


@dataclass(frozen=True, kw_only=True)
class Round:
    """Machines and motions that a seed draws."""

    seed: int
    machines: int = MACHINES
    """Number of machines."""
    motions: int = MOTIONS
    """Number of motions; every machine runs all of them."""
    series: str = SERIES
    """Prefix of the names of the machines, which a number follows."""
    salt: str = ""
    """Random text that the hash covers; empty for a round that nobody committed to."""
    kinds: tuple[str, ...] = KINDS
    """Kinds of the motions, in turn, see `ffgym.leaderboard.motions`."""

    def __post_init__(self) -> None:
        check_whole("seed of a round", self.seed, low=0, high=2**53)
        check_whole("machines of a round", self.machines, low=1, high=100)
        check_whole("motions of a round", self.motions, low=1, high=100)
        object.__setattr__(self, "kinds", tuple(self.kinds))
        if not self.kinds:
            raise FFGymError(f"kinds of a round are empty; name some of {', '.join(KINDS)}.")
        for kind in self.kinds:
            check_choice("kind of motion", kind, KINDS)
        find_plant(self.plants[0])  # which refuses a series that there is not

    @cached_property
    def plants(self) -> tuple[str, ...]:
        """Names of the machines."""
        numbers = np.random.default_rng([_ROUNDS, self.seed, 0]).integers(*SEEDS, size=self.machines)
        return tuple(f"{self.series}{number}" for number in numbers)

    @property
    def noise(self) -> int:
        """Seed of the sensors' noise, which no author chooses."""
        return self.seed % 2**31

    def draw_motions(self, area: WorkArea) -> tuple[Task, ...]:
        """Draw the motions: of all kinds in turn, about centres within a work area, near its positions in turn.

        Centre, radius and speed of a motion are the same whatever its kind is.
        """
        rng, tilts = (np.random.default_rng([_ROUNDS, self.seed, stream]) for stream in (1, 2))
        names = list(area.positions)
        middle = np.mean([area.positions[name] for name in names], axis=0)
        order = rng.permutation(len(names))
        tasks = []
        for k in range(self.motions):
            near = names[order[k % len(names)]]
            shift = np.round(rng.uniform(*INSIDE, size=3) * (middle - area.positions[near]), 4)
            radius, speed = (float(np.exp(rng.uniform(*np.log(ends)))) for ends in (RADII, SPEEDS))
            x, y, z = (area.positions[near] + shift).tolist()
            label = f"{near} {shift[0] * 1e3:+.1f} {shift[1] * 1e3:+.1f} mm"
            task = Task(label, round(speed, 4), (round(radius, 5),), DRAWN, centre=(x, y, z))
            tasks.append(_as_kind(task, self.kinds[k % len(self.kinds)], tilts.uniform(*TILTS), tilts.uniform(-1, 1)))
        return tuple(tasks)

    @property
    def format(self) -> int:
        """Version of the file: the first for circles alone, whose hash and draws are those of older rounds."""
        return FORMATS[0] if self.kinds == (CIRCLE,) else FORMATS[1]

    def _entries(self) -> dict[str, Any]:
        """Return the entries that the hash covers."""
        entries = asdict(self)
        if self.format == FORMATS[0]:
            del entries["kinds"]
        return entries

    @property
    def commitment(self) -> str:
        """SHA-256 of the round in canonical JSON: sorted keys, no blanks."""
        text = json.dumps(self._entries(), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()

    def list_published(self) -> dict[str, Any]:
        """Return the JSON that is published before a round: everything but seed and salt, and the hash of all."""
        open_parts = {key: value for key, value in self._entries().items() if key not in ("seed", "salt")}
        return {"format": self.format, "commitment": self.commitment, **open_parts}

    def list_revealed(self) -> dict[str, Any]:
        """Return the JSON that is published after a round: with seed and salt."""
        return {"format": self.format, "commitment": self.commitment, **self._entries()}


def _as_kind(task: Task, kind: str, tilt: float, side: float) -> Task:
    """Make a motion of a kind of a drawn circle; a plane is tilted by `tilt` [rad] to `side`, in half turns."""
    if kind == CIRCLE:
        return task
    split = f"{DRAWN} {kind}"
    if kind != TILTED:
        [radius] = task.radii
        return replace(task, split=split, kind=kind, radii=(round(WIDER * radius, 5),))
    x, y = np.sin(tilt) * np.cos(np.pi * side), np.sin(tilt) * np.sin(np.pi * side)
    return replace(task, split=split, kind=kind, normal=(float(x), float(y), float(np.cos(tilt))))


def draw_round(
    *, machines: int = MACHINES, motions: int = MOTIONS, series: str = SERIES, kinds: Sequence[str] = KINDS
) -> Round:
    """Draw a round with a fresh seed and salt from the randomness of the operating system."""
    return Round(
        seed=secrets.randbits(53),
        salt=secrets.token_hex(32),
        machines=machines,
        motions=motions,
        series=series,
        kinds=tuple(kinds),
    )


def read_commitment(path: str | os.PathLike[str]) -> str:
    """Read the hash in a file of a round, published or revealed; FFGymError if it holds none."""
    return str(_read(path)["commitment"])


def read_round(path: str | os.PathLike[str]) -> Round:
    """Read a revealed round.

    Raises:
        FFGymError: if the file is damaged, holds the hash alone, or its seed does not fit the hash.
    """
    tree = _read(path)
    if "seed" not in tree:
        raise FFGymError(f"{path}: holds the hash of a round alone; its seed is published after the round.")
    said, version = tree.pop("commitment"), tree.pop("format")
    try:
        check_number("seed", tree["seed"], low=0.0)
        if version == FORMATS[0]:
            if "kinds" in tree:
                raise FFGymError(f"Files of format {version} have no kinds.")
            tree["kinds"] = [CIRCLE]
        found: Round = from_json(Round, tree, "round")
        if found.format != version:
            raise FFGymError(f"Its kinds are {list(found.kinds)}, which files of format {found.format} have.")
    except FFGymError as error:
        raise FFGymError(f"{path}: is no round: {error}") from error
    if found.commitment != said:
        raise FFGymError(
            f"{path}: seed {found.seed} with its salt has the SHA-256 {found.commitment}, not the committed {said}: "
            f"it is not the round that was committed to."
        )
    return found


def _read(path: str | os.PathLike[str]) -> dict[str, Any]:
    tree = parse_json(read_text(path), str(path), "Give a file of ffgym leaderboard round.")
    if not isinstance(tree, dict) or tree.get("format") not in FORMATS or not isinstance(tree.get("commitment"), str):
        versions = " or ".join(map(str, FORMATS))
        raise FFGymError(f"{path}: is no file of a round of format {versions}. Give one of ffgym leaderboard round.")
    return tree
