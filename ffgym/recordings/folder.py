"""A folder of recordings: one file for each motion, and an index that says which belong together."""

import json
import os
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text
from ffgym.recordings.io import FORMATS, read_recording
from ffgym.recordings.recording import Recording

INDEX = "protocol.json"
"""Name of the index that `ffgym record` writes beside its recordings."""


def read_folder(folder: str | os.PathLike[str]) -> list[Recording]:
    """Recordings in a folder, see `recording_files`.

    Raises:
        FFGymError: as `recording_files`, or if one cannot be read.
    """
    return [read_recording(file) for file in recording_files(folder)]


def recording_files(folder: str | os.PathLike[str]) -> list[Path]:
    """Files of recordings in a folder: those that its index lists, in that order; without an index all, by name.

    Raises:
        FFGymError: if there is no such folder or nothing in it, or a recording of the index is missing.
    """
    place = Path(folder)
    if not place.is_dir():
        raise FFGymError(f"{place}: no such folder. Check the path; it is relative to {Path.cwd()}.")
    index = read_index(place)
    if index is None:
        files = sorted(file for file in place.iterdir() if file.suffix.lower() in FORMATS)
    else:
        files = [place / name for name in listed_files(index, place)]
        missing = [file.name for file in files if not file.exists()]
        if missing:
            raise FFGymError(
                f"{place}: {len(missing)} of {len(files)} recordings are missing, first {missing[0]}. Run the same "
                f"ffgym record again, which makes those that are missing, or take them out of {INDEX}."
            )
    if not files:
        raise FFGymError(f"{place}: holds no recordings ({', '.join(FORMATS)}).")
    return files


def read_index(folder: Path) -> dict[str, Any] | None:
    """What the index of a folder says; None if it has none.

    Raises:
        FFGymError: if the index cannot be read, or is none.
    """
    path = folder / INDEX
    if not path.exists():
        return None
    text = read_text(path)
    try:
        index = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FFGymError(f"{path} is not valid JSON: {error}. Remove it to read all recordings beside it.") from error
    if not isinstance(index, dict):
        raise FFGymError(f"{path} must be a JSON object. Remove it to read all recordings beside it.")
    return index


def listed_files(index: dict[str, Any], folder: Path) -> list[str]:
    """Names of the files that an index lists, in order.

    Raises:
        FFGymError: if it lists none, or something else.
    """
    motions = index.get("motions")
    entries = motions if isinstance(motions, list) else []
    names = [entry.get("file") if isinstance(entry, dict) else None for entry in entries]
    files = [name for name in names if isinstance(name, str) and Path(name).name == name]
    if not files or len(files) < len(names):
        raise FFGymError(
            f"{folder / INDEX} must list motions, each with the name of a file beside it. Remove it to read all "
            f"recordings that are there."
        )
    return files
