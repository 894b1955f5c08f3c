"""Results by name: recordings of motions with laws of different names, and selections among them."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeVar

from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.simulation import Rig, Run

Key = TypeVar("Key", bound=tuple[object, ...])
"""Name of a result, e.g. law, position and speed."""


def record_all(
    rig: Rig, references: Mapping[Any, Reference], laws: Sequence[FeedForwardLaw], **options: Any
) -> dict[Any, Recording]:
    """Record every motion with every law, side by side, by the law's name and the parts of the motion's key.

    `options` are those of `Rig.run`; laws that share a name are an error.
    """
    names = [law.name for law in laws]
    if len(set(names)) < len(names):
        raise FFGymError(f"Feed-forward laws {names} of one study must have different names.")
    runs = {
        (law.name, *(key if isinstance(key, tuple) else (key,))): Run(reference=reference, law=law)
        for key, reference in references.items()
        for law in laws
    }
    return dict(zip(runs, rig.run(list(runs.values()), **options), strict=True))


def pick(keys: Iterable[Key], **wanted: Sequence[object] | None) -> list[Key]:
    """Pick keys whose parts, one after the other, are among `wanted`, e.g. law=["none"]; None takes all."""
    keys = list(keys)
    for place, (what, values) in enumerate(wanted.items()):
        held = list(dict.fromkeys(key[place] for key in keys))
        if unknown := [value for value in values or () if value not in held]:
            raise FFGymError(f"The study has no {what} {unknown[0]!r}, only {held}.")
        keys = [key for key in keys if values is None or key[place] in values]
    return keys
