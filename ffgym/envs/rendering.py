"""Pictures of an episode."""

from typing import Any

from ffgym.errors import check_choice
from ffgym.types import Array, IntArray


def check_render_mode(mode: str | None, available: list[str]) -> str | None:
    """Return a render mode if it is None or one of `available`."""
    return None if mode is None else check_choice("render_mode", mode, [*available, "human"])


class EpisodeRenderer:
    """Draws the robots of an engine."""

    def __init__(self, core: Any) -> None:
        self._core = core

    def begin(self, ids: IntArray) -> None:
        """Forget the trails of sub-environments `ids`, which begin an episode."""

    def follow(self) -> None:
        """Add the present TCP to the trails."""

    def frame(self, index: int) -> Array:
        """Picture of a sub-environment."""
        raise NotImplementedError

    def show(self) -> None:
        """Show sub-environment 0 in MuJoCo's viewer."""

    def close(self) -> None:
        """Free the context."""
