"""LeRobot data sets: a folder with meta/info.json and Parquet files, in which episodes follow each other."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_bytes, read_text
from ffgym.logs.contents import NUMBERS, Contents
from ffgym.logs.formats.damage import one_error
from ffgym.logs.formats.parquet import contents_of

INFO = Path("meta", "info.json")
"""File that makes a folder a LeRobot data set."""


def read_lerobot(folder: Path) -> Contents:
    """Columns of all episodes below each other, in the order of file names; `episode_index` tells them apart.

    A feature whose entries have names is there as a whole, e.g. `observation.state` (T, K), and entry by entry, e.g.
    `observation.state.shoulder`; `fps` is the rate in Hz.

    Raises:
        FFGymError: if a file is missing or damaged, or files differ in their columns.
    """
    info = _info(folder)
    files = sorted(folder.glob("data/*/*.parquet"))
    if not files:
        raise FFGymError(f"There are no data/chunk-*/*.parquet files beside {INFO}. Copy the whole data set.")
    tables = []
    for file in files:
        with one_error(f"a Parquet file ({file.relative_to(folder)})"):
            tables.append(pq.read_table(pa.BufferReader(read_bytes(file))))
    with one_error("a LeRobot data set of files with the same columns"):
        contents = contents_of(pa.concat_tables(tables), str(folder))
    arrays = dict(contents.arrays)
    for feature, names in _named(info).items():
        if feature in arrays and arrays[feature].shape[1:] == (len(names),):
            arrays |= {f"{feature}.{name}": arrays[feature][:, i] for i, name in enumerate(names)}
    rate = np.asarray(info.get("fps"))
    if rate.dtype.kind in NUMBERS:
        arrays["fps"] = rate
    return Contents(where=str(folder), arrays=arrays, skipped=contents.skipped)


def _info(folder: Path) -> dict[str, Any]:
    try:
        info = json.loads(read_text(folder / INFO))
    except (ValueError, RecursionError) as error:
        if isinstance(error, FFGymError):
            raise
        raise FFGymError(f"{INFO} is not JSON: {error}.") from error
    if not isinstance(info, dict):
        raise FFGymError(f"{INFO} must be a JSON object, got {type(info).__name__}.")
    return info


def _named(info: dict[str, Any]) -> dict[str, list[str]]:
    """Names of the entries of each feature: a list, or lists by kind, e.g. of motors."""
    features = info.get("features")
    named: dict[str, list[str]] = {}
    for feature, entry in (features if isinstance(features, dict) else {}).items():
        names = entry.get("names") if isinstance(entry, dict) else None
        if isinstance(names, dict) and len(names) == 1:
            (names,) = names.values()
        if isinstance(names, list) and all(isinstance(name, str) for name in names):
            named[feature] = names
    return named
