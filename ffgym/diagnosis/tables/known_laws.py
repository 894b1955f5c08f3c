"""Laws that follow from the friction that a controller knows, with their torques along the motions of a table."""

from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np

from ffgym.control import DynamicLuGreExact, FeedForwardLaw, NoCompensation, StaticLuGre
from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.robot.friction import LuGreParameters

KNOWN_LAWS = ("none", "lugre_static", "lugre_dynamic")
"""Laws that follow from the friction that a controller knows; all others learn on the machine."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PlayedLaw(FeedForwardLaw):
    """Law whose torques along some references are computed already."""

    torques: dict[int, Array]
    """Torques by `id` of the reference [N m], shape (T, N) each."""
    name: str = "played"

    def torque(self, reference: Reference) -> Array:
        """Return the torque along a reference."""
        return self.torques[id(reference)]


def make_known_law(name: str, known: LuGreParameters) -> FeedForwardLaw:
    """Make a law that needs no more than the friction that the controller knows."""
    if name == "none":
        return NoCompensation()
    return StaticLuGre(known) if name == "lugre_static" else DynamicLuGreExact(known)


class LawCache:
    """Torques of laws along the motions of a table; candidates that know the same friction share them."""

    def __init__(self, references: Sequence[Reference]) -> None:
        """Begin without torques."""
        self._references = references
        self._torques: dict[tuple[str, bytes], dict[int, Array]] = {}

    def law(self, name: str, known: LuGreParameters) -> FeedForwardLaw:
        """Return the law, which knows its torques along the references."""
        if name == "none":
            return NoCompensation()
        key = (name, np.concatenate([part for part in astuple(known) if part is not None]).tobytes())
        if key not in self._torques:
            law = make_known_law(name, known)
            self._torques[key] = {id(r): law.torque(r) for r in self._references}
        return PlayedLaw(name=name, torques=self._torques[key])

    def forget(self) -> None:
        """Drop torques of candidates that are done with."""
        self._torques.clear()
