"""JSON: text to values, and dataclasses to JSON and back, by the types of their fields, all of which must be there."""

import json
import sys
from dataclasses import fields, is_dataclass
from functools import cache
from math import isfinite
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np

from ffgym.core.errors import FFGymError

_MOST = 2**63
"""Size of whole numbers that no array holds."""


def parse_json(text: str | bytes, what: str, way_out: str = "") -> Any:
    """Parse JSON; an error calls the text `what`, and ends with a sentence on what to do."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FFGymError(f"{what} is not valid JSON: {error}. {way_out}".rstrip()) from error


def to_json(value: Any) -> Any:
    """Convert a value to JSON: dataclasses to objects, tuples to lists, numbers that are not finite to null."""
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: to_json(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, np.generic | np.ndarray):
        return to_json(value.tolist())
    if isinstance(value, dict):
        return {str(name): to_json(entry) for name, entry in value.items()}
    if isinstance(value, tuple | list):
        return [to_json(entry) for entry in value]
    if isinstance(value, float):
        return value if np.isfinite(value) else None
    if value is None or isinstance(value, str | bool | int):
        return value
    raise FFGymError(f"{value!r} has no JSON form.")


def from_json(kind: Any, value: Any, where: str) -> Any:
    """Convert JSON back to the value that `to_json` got.

    Args:
        kind: type of the value, as fields declare it.
        value: parsed JSON.
        where: name of the value, for messages.
    """
    origin, arguments = get_origin(kind), get_args(kind)
    if kind is Any:
        return value
    if is_dataclass(kind):
        return _object(kind, value, where)
    if origin is Literal:
        return _check(value in arguments, value, where, f"one of {', '.join(arguments)}")
    if origin in (Union, UnionType):
        return None if value is None else from_json(arguments[0], value, where)
    if origin is tuple:
        return _tuple(arguments, value, where)
    if origin is dict:
        entries = _check(isinstance(value, dict), value, where, "an object")
        return {name: from_json(arguments[1], entry, f"{where}.{name}") for name, entry in entries.items()}
    if kind is float:
        return float("nan") if value is None else _number(value, where)
    right = type(value) is kind and (kind is not int or abs(value) < _MOST)
    return _check(right, value, where, {str: "text", bool: "true or false", int: "a whole number of 63 bits"}[kind])


def _object(kind: Any, value: Any, where: str) -> Any:
    table = _check(isinstance(value, dict), value, where, "an object")
    types = _types(kind)
    names = list(types)
    if missing := [name for name in names if name not in table]:
        raise FFGymError(f"{where} lacks {', '.join(missing)}.")
    if unknown := [name for name in table if name not in names]:
        raise FFGymError(f"{where} has unknown entries {', '.join(unknown)}; it has {', '.join(names)}.")
    return kind(**{name: from_json(types[name], table[name], f"{where}.{name}") for name in names})


@cache
def _types(kind: Any) -> dict[str, Any]:
    """Return the types of a dataclass' fields by name."""
    types = get_type_hints(kind)
    return {f.name: types[f.name] for f in fields(kind)}


def _tuple(kinds: tuple[Any, ...], value: Any, where: str) -> tuple[Any, ...]:
    entries = _check(isinstance(value, list), value, where, "a list")
    # long lists, mostly
    if kinds == (float, ...) and all(type(entry) is float and isfinite(entry) for entry in entries):
        return tuple(entries)
    if kinds[-1] is ...:
        kinds = (kinds[0],) * len(entries)
    _check(len(entries) == len(kinds), value, where, f"a list of {len(kinds)}")
    return tuple(from_json(k, entry, f"{where}[{i}]") for i, (k, entry) in enumerate(zip(kinds, entries, strict=True)))


def _number(value: Any, where: str) -> float:
    _check(isinstance(value, int | float) and not isinstance(value, bool), value, where, "a number, or null")
    # a whole number of 400 digits is none that a float holds
    return float(_check(abs(value) <= sys.float_info.max, value, where, "a finite number, or null"))


def _check(right: bool, value: Any, where: str, wanted: str) -> Any:
    if not right:
        text = repr(value)
        raise FFGymError(f"{where} = {text if len(text) <= 80 else text[:79] + '…'} must be {wanted}.")
    return value
