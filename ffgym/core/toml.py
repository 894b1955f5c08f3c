"""TOML: text to tables, and the one writer of the project. Numbers keep every bit."""

import json
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError


def parse_toml(text: str, what: str) -> dict[str, Any]:
    """Parse TOML; an error calls the text `what`."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # ValueError: also of a number of 5000 digits
        raise FFGymError(f"{what} is not valid TOML: {error}.") from error


def merge_tables(base: Mapping[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
    """Merge tables of `change` into those of `base`; a number with its unit and source is replaced as a whole."""
    out = dict(base)
    for key, value in change.items():
        both = isinstance(value, dict) and isinstance(out.get(key), dict) and "value" not in value
        out[key] = merge_tables(out[key], value) if both else value
    return out


def toml_value(value: Any) -> str:
    """Write a text, truth value, number, date, array or list of these as TOML; a mapping becomes an inline table."""
    if isinstance(value, str):  # JSON's text is TOML's, but for a control character that JSON leaves as it is
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{toml_key(key)} = {toml_value(entry)}' for key, entry in value.items())} }}"
    if isinstance(value, np.ndarray | np.generic):
        return toml_value(value.tolist())
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, value))}]"
    return repr(value) if isinstance(value, int | float) else str(value.isoformat())


def toml_key(key: str) -> str:
    """Write a key, in quotes if it needs them."""
    return key if key.replace("_", "").replace("-", "").isalnum() and key.isascii() else toml_value(key)


def toml_table(path: str, entries: Mapping[str, Any]) -> list[str]:
    """Write the table [path] as lines; entries that are None are left out."""
    rows = [f"{toml_key(key)} = {toml_value(value)}" for key, value in entries.items() if value is not None]
    return [f"[{path}]", *rows]


def single(values: Sequence[str]) -> str | Sequence[str]:
    """Return the only name, or all if there are several, as descriptions give units and origins."""
    return values[0] if len(values) == 1 else values
