"""`diagnosis.json`: a diagnosis as a file, for programs; docs/diagnosis_json.md lists its entries.

It has the fields of `Diagnosis`, but instead of `levels` the three objects `noise_floor`, `before` and `after`: by
channel and component, value and unit.
"""

import os
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_json
from ffgym.core.typed_json import from_json, parse_json, to_json
from ffgym.diagnosis.residual import UNITS
from ffgym.diagnosis.result import Diagnosis

FORMAT = "ffgym-diagnosis"
"""Value of the entry `format`."""

VERSION = 1
"""Value of the entry `version`; it changes when an entry changes its meaning or goes away."""

LEVELS: Mapping[str, str] = MappingProxyType(
    {
        "measured": "RMS of what was measured, about its mean",
        "noise_floor": "RMS of the residual that noise alone would leave",
        "before": "RMS of the residual against the nominal model as it is",
        "after": "RMS against the extended model as it is written, each motion by one that was fitted without it",
    }
)
"""Entries that stand for `Diagnosis.levels`, and what they hold."""


def diagnosis_document(diagnosis: Diagnosis) -> dict[str, Any]:
    """The diagnosis as JSON has it."""
    document = {"format": FORMAT, "version": VERSION} | to_json(diagnosis)
    del document["levels"]
    for entry in LEVELS:
        channels: dict[str, dict[str, Any]] = {}
        for level in diagnosis.levels:
            values = channels.setdefault(level.channel, {})
            values[level.component] = {"value": to_json(getattr(level, entry)), "unit": level.unit}
        document[entry] = channels
    return document


def write_diagnosis(path: str | os.PathLike[str], diagnosis: Diagnosis) -> None:
    """Write the file, whole or not at all; the same diagnosis gives the same bytes.

    Raises:
        FFGymError: if it cannot be written.
    """
    write_json(path, diagnosis_document(diagnosis))


def read_diagnosis(path: str | os.PathLike[str]) -> Diagnosis:
    """Read the file.

    Raises:
        FFGymError: if it cannot be read, is no diagnosis, of another version, or damaged.
    """
    document = parse_json(read_text(path), str(path), "Copy it again, or run the diagnosis again.")
    try:
        return parse_diagnosis(document)
    except FFGymError as error:
        raise FFGymError(f"{path}: {error}") from error


def parse_diagnosis(document: Any) -> Diagnosis:
    """The diagnosis that `diagnosis_document` made a document of.

    Raises:
        FFGymError: if it is no diagnosis, of another version, or an entry is missing, unknown or of another type.
    """
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise FFGymError(f"This is no diagnosis: an object whose entry format says {FORMAT!r}.")
    if document.get("version") != VERSION:
        raise FFGymError(
            f"The diagnosis has version {document.get('version')!r}, this ffgym reads {VERSION}. Use the ffgym that "
            f"wrote it, or run the diagnosis again."
        )
    table = {name: entry for name, entry in document.items() if name not in ("format", "version")}
    given = [table.pop(entry) for entry in LEVELS if entry in table]
    if len(given) < len(LEVELS) or "levels" in table:
        raise FFGymError(f"The diagnosis must have {', '.join(LEVELS)}, and no levels beside them.")
    diagnosis: Diagnosis = from_json(Diagnosis, table | {"levels": _levels(*given)}, "diagnosis")
    return diagnosis


def _levels(*objects: Any) -> list[dict[str, Any]]:
    """Levels as JSON, of the objects that stand for them."""
    kind, found = dict[str, dict[str, dict[str, Any]]], []
    tables = [from_json(kind, table, name) for name, table in zip(LEVELS, objects, strict=True)]
    # all tables must list the same components, as a row of levels takes one entry of each
    places = [[(channel, component) for channel in table for component in table[channel]] for table in tables]
    if any(own != places[0] for own in places):
        raise FFGymError(f"{', '.join(LEVELS)} must have the same channels and components, in the same order.")
    # a row of levels per component, in one unit
    for channel, component in places[0]:
        if channel not in UNITS:
            raise FFGymError(f"{next(iter(LEVELS))} has unknown channel {channel!r}; there are {', '.join(UNITS)}.")
        entries = {name: table[channel][component] for name, table in zip(LEVELS, tables, strict=True)}
        unit = entries["measured"].get("unit")
        for name, entry in entries.items():
            if set(entry) != {"value", "unit"} or entry["unit"] != unit:
                raise FFGymError(f"{name}.{channel}.{component} must have value and unit, the same unit everywhere.")
        place = {"channel": channel, "component": component, "unit": unit}
        found.append({name: entry["value"] for name, entry in entries.items()} | place)
    return found
