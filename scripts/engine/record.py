"""The stored record of trajectories, with the versions that made it, and how far others are from it."""

import json
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import decode_arrays, encode_arrays, read_bytes, write_bytes
from ffgym.core.provenance import versions
from ffgym.core.types import Array
from scripts.engine.trajectories import Trajectory

RECORD = Path(__file__).with_name("record.npz")
"""The record in the repository."""

_ABOUT = "about"


@dataclass(frozen=True, kw_only=True, eq=False)
class Record:
    """Trajectories by the names of robots and environments."""

    about: Mapping[str, str]
    """Versions of programs, and the processor."""
    trajectories: Mapping[str, Trajectory]


def about_now() -> dict[str, str]:
    """Return what makes trajectories here: versions, and the processor, which may round otherwise."""
    return {**versions(), "processor": f"{platform.machine()} {platform.system()}"}


def read_record(path: Path) -> Record:
    """Read a record.

    Raises:
        FFGymError: if there is none, or it is damaged.
    """
    try:
        arrays = decode_arrays(read_bytes(path))
        about = json.loads(str(arrays.pop(_ABOUT)))
        names = sorted({name.rpartition(" ")[0] for name in arrays})
        made = {name: Trajectory(time=arrays[f"{name} time"], values=arrays[f"{name} values"]) for name in names}
    except (FFGymError, KeyError, ValueError) as error:
        raise FFGymError(f"{path} is no record of trajectories: {error} `--store` writes one.") from error
    return Record(about=about, trajectories=made)


def write_record(path: Path, trajectories: Mapping[str, Trajectory]) -> None:
    """Write a record of trajectories that were made here."""
    arrays = {
        f"{name} {part}": getattr(one, part)
        for name, one in sorted(trajectories.items())
        for part in ("time", "values")
    }
    write_bytes(path, encode_arrays({_ABOUT: np.array(json.dumps(about_now())), **arrays}))


@dataclass(frozen=True, kw_only=True)
class Difference:
    """Difference of two trajectories, as a share of how far each coordinate goes in the one before."""

    largest: float
    """[1]."""
    at: float
    """Instant of it [s]."""
    since: float
    """First instant at which a bit differs [s]."""


def difference(before: Trajectory, now: Trajectory) -> Difference | None:
    """Difference of a trajectory from one before, of the same shape; None if they are the same to the bit."""
    differs = np.any(before.values != now.values, axis=1)
    if not differs.any():
        return None
    away = np.abs(now.values - before.values) / _reach(before.values)
    row = int(np.argmax(away.max(axis=1)))
    return Difference(
        largest=float(away.max()), at=float(before.time[row]), since=float(before.time[np.argmax(differs)])
    )


def _reach(values: Array) -> Array:
    """Way of each coordinate; the longest of all for one that stays."""
    ways = np.ptp(values, axis=0)
    return np.where(ways > 1e-6 * ways.max(), ways, ways.max() or 1.0)
