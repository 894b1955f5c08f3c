"""Results are filed by name: names that differ, and a choice among them."""

from collections.abc import Iterable, Sequence
from typing import TypeVar

from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError

Key = TypeVar("Key", bound=tuple[object, ...])
"""What results are filed under, e.g. law, position and speed."""


def distinct(laws: Sequence[FeedForwardLaw]) -> Sequence[FeedForwardLaw]:
    """Return `laws` if their names differ, since results are filed by name.

    Raises:
        FFGymError: if two share a name.
    """
    names = [law.name for law in laws]
    if len(set(names)) < len(names):
        raise FFGymError(f"Feed-forward laws {names} of one study must have different names.")
    return laws


def picked(keys: Iterable[Key], **wanted: Sequence[object] | None) -> list[Key]:
    """Those of the keys whose parts, one after the other, are among `wanted`, e.g. law=["none"]; None takes all.

    Raises:
        FFGymError: if a wanted part is in none of the keys.
    """
    keys = list(keys)
    for place, (what, values) in enumerate(wanted.items()):
        held = list(dict.fromkeys(key[place] for key in keys))
        if unknown := [value for value in values or () if value not in held]:
            raise FFGymError(f"The study has no {what} {unknown[0]!r}, only {held}.")
        keys = [key for key in keys if values is None or key[place] in values]
    return keys
