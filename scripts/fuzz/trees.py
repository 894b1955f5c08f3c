"""Mutation of parsed JSON or TOML: entries go, come twice, change their kind, size, length, name or place."""

from collections.abc import Callable
from typing import Any

import numpy as np

from scripts.fuzz.values import FACTORS, odd_value

Place = tuple[Any, Any]
"""A list or an object, and an index or a key in it."""
_LONG = 20_000
"""Entries of a long list."""


def mutate_tree(tree: Any, rng: np.random.Generator) -> Any:
    """Change one entry of a tree in place; return the tree, or another value in its stead."""
    places = _places(tree)
    if not places or rng.random() < 0.01:
        return odd_value(rng)
    # entries high up are few and matter most, so that half of the draws are among the first
    few = places[: max(1, len(places) // 20)]
    parent, key = few[rng.integers(len(few))] if rng.random() < 0.4 else places[rng.integers(len(places))]
    change = _CHANGES[rng.integers(len(_CHANGES))]
    change(parent, key, places, rng)
    return tree


def _places(tree: Any) -> list[Place]:
    """Collect all entries, breadth first."""
    found: list[Place] = []
    level = [tree]
    while level:
        below = []
        for value in level:
            entries = list(value.items()) if isinstance(value, dict) else []
            entries += list(enumerate(value)) if isinstance(value, list) else []
            found += [(value, key) for key, _ in entries]
            below += [entry for _, entry in entries if isinstance(entry, dict | list)]
        level = below
    return found


def _delete(parent: Any, key: Any, places: list[Place], rng: np.random.Generator) -> None:
    del parent[key]


def _replace(parent: Any, key: Any, places: list[Place], rng: np.random.Generator) -> None:
    parent[key] = odd_value(rng)


def _swap(parent: Any, key: Any, places: list[Place], rng: np.random.Generator) -> None:
    """Put another entry of the tree there, a copy of which stays where it is."""
    other, its_key = places[rng.integers(len(places))]
    value = other[its_key]
    parent[key] = list(value) if isinstance(value, list) else dict(value) if isinstance(value, dict) else value


def _repeat(parent: Any, key: Any, places: list[Place], rng: np.random.Generator) -> None:
    """Enter the entry once more: into the list, or into the object by another name."""
    if isinstance(parent, list):
        parent.insert(key, parent[key])
    else:
        parent[f"{key}_2"] = parent[key]


def _rename(parent: Any, key: Any, places: list[Place], rng: np.random.Generator) -> None:
    if isinstance(parent, dict):
        parent[str(odd_value(rng))] = parent.pop(key)
    else:
        parent.reverse()


def _wrap(parent: Any, key: Any, places: list[Place], rng: np.random.Generator) -> None:
    value = parent[key]
    parent[key] = [value] if rng.random() < 0.5 else {"value": value}


def _unwrap(parent: Any, key: Any, places: list[Place], rng: np.random.Generator) -> None:
    value = parent[key]
    entries = list(value.values()) if isinstance(value, dict) else value
    parent[key] = entries[0] if isinstance(entries, list) and entries else str(value)


def _resize(parent: Any, key: Any, places: list[Place], rng: np.random.Generator) -> None:
    """Give a list another length, a text another content, a number another unit."""
    value = parent[key]
    if isinstance(value, list):
        lengths = (0, 1, len(value) - 1, len(value) + 1, 2 * len(value), _LONG)
        length = int(rng.choice(lengths, p=(0.2, 0.15, 0.25, 0.25, 0.1, 0.05)))
        parent[key] = (value * (length // max(len(value), 1) + 1))[: max(length, 0)]
    elif isinstance(value, bool) or value is None:
        parent[key] = not value
    elif isinstance(value, int | float):
        parent[key] = _scale(value, float(rng.choice(FACTORS)))
    else:
        text = str(value)
        cut = int(rng.integers(len(text) + 1))
        parent[key] = text[:cut] + text[cut + 1 :] if rng.random() < 0.5 else text[:cut] * 2


def _scale(value: float, factor: float) -> float:
    try:
        return type(value)(value * factor)
    except (OverflowError, ValueError):  # of a number that is out of range already
        return -value


_CHANGES: tuple[Callable[[Any, Any, list[Place], np.random.Generator], None], ...]
_CHANGES = (_delete, _replace, _replace, _replace, _swap, _repeat, _rename, _wrap, _unwrap, _resize, _resize, _resize)
