"""What effects of an exam are to the library: variants of an effect in another equation, or nothing it knows."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

from ffgym.effects import TorqueEffect
from ffgym.effects.effect import Effect, Side


class Variant(Effect):
    """An effect of the library in an equation of its own, so that who fits the library's meets a stranger."""

    variant_of: ClassVar[str]
    """Name of the effect that a diagnosis should give."""
    signature: ClassVar[str] = "as of the effect that it is a variant of"
    way_in: ClassVar[str] = "torque at every physics step"


@dataclass(frozen=True, kw_only=True)
class Clue:
    """What an answer must say of an effect that no library holds."""

    words: tuple[str, ...]
    """One of them must stand in the variable that a pattern names."""
    joint: str | None = None
    """Whose variable that is; None is nobody's, as time is."""
    frequency: float | None = None
    """[Hz], of a line in time; a multiple of it is right, too. None if there is none."""


class Outsider(TorqueEffect):
    """An effect that no effect of the library can express."""

    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = "only in patterns of the residual"
    way_in: ClassVar[str] = "torque at every physics step"

    @abstractmethod
    def clue(self, joints: tuple[str, ...], joint: str) -> Clue:
        """What an answer must name, for the effect on `joint` of a robot with these `joints`."""
