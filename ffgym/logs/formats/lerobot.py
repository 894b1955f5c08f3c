"""LeRobot data sets: a folder with meta/info.json and Parquet files, in which episodes follow each other."""

from pathlib import Path
from typing import Any

import lazy_loader
import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_bytes, read_text
from ffgym.core.typed_json import parse_json
from ffgym.logs.contents import NUMBERS, Contents
from ffgym.logs.formats.parquet import contents_of, read_table
from ffgym.logs.log_format import LogFormat, one_error
from ffgym.logs.text_layout import TextLayout

pa = lazy_loader.load("pyarrow")


class LeRobot(LogFormat):
    """Columns of all episodes below each other, in the order of file names; `episode_index` tells them apart.

    A feature whose entries have names is there as a whole, e.g. `observation.state` (T, K), and entry by entry, e.g.
    `observation.state.shoulder`; `fps` is the rate in Hz.
    """

    title = "a LeRobot data set"
    folder = "meta/info.json"
    packages = ("pyarrow",)
    extra = "ffgym[logs]"

    def read(self, path: Path, layout: TextLayout) -> Contents:
        """Read the episodes of a LeRobot data set, a folder of Parquet files."""
        info = parse_json(read_text(path / self.folder), self.folder)
        if not isinstance(info, dict):
            raise FFGymError(f"{self.folder} must be a JSON object, got {type(info).__name__}.")
        files = sorted(path.glob("data/*/*.parquet"))
        if not files:
            raise FFGymError(
                f"There are no data/chunk-*/*.parquet files beside {self.folder}. Copy the whole data set."
            )
        tables = []
        for file in files:
            with one_error(f"a Parquet file ({file.relative_to(path)})"):
                tables.append(read_table(read_bytes(file)))
        with one_error("a LeRobot data set of files with the same columns"):
            contents = contents_of(pa.concat_tables(tables), str(path))
        arrays = dict(contents.arrays)
        for feature, names in _name_columns(info).items():
            if feature in arrays and arrays[feature].shape[1:] == (len(names),):
                arrays |= {f"{feature}.{name}": arrays[feature][:, i] for i, name in enumerate(names)}
        rate = np.asarray(info.get("fps"))
        if rate.dtype.kind in NUMBERS:
            arrays["fps"] = rate
        return Contents(where=str(path), arrays=arrays, skipped=contents.skipped)


def _name_columns(info: dict[str, Any]) -> dict[str, list[str]]:
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
