"""Checks of plain TOML values that every part of a description uses."""

from typing import Any

from ffgym.core.errors import FFGymError


def table_of(path: str, value: Any) -> dict[str, Any]:
    """Return `value` if it is a table.

    Raises:
        FFGymError: if it is none.
    """
    if not isinstance(value, dict):
        raise FFGymError(f"[{path}] must be a table, got {value!r}.")
    return value


def names_of(what: str, value: Any) -> tuple[str, ...]:
    """Return a list of names, one or more.

    Raises:
        FFGymError: if it is none.
    """
    if not isinstance(value, list) or not value or not all(isinstance(name, str) and name for name in value):
        raise FFGymError(f"{what} must be names, non-empty text, got {value!r}.")
    return tuple(value)
