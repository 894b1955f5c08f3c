"""What a picture of an episode can be told."""

from dataclasses import dataclass

from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole

LARGEST = 4096
"""Largest width and height [pixel]; software OpenGL draws no larger ones."""


@dataclass(frozen=True, kw_only=True)
class Rendering:
    """How episodes are drawn."""

    magnify: float | None = None
    """Factor on the error that is drawn; None takes a round one that suits the motion, the same for every agent."""
    width: int = 960
    """Of a picture [pixel]."""
    height: int = 540
    """Of a picture [pixel]."""
    title: str = ""
    """First line of the text, e.g. the agent's name."""

    def __post_init__(self) -> None:
        if self.magnify is not None:
            check_number("magnify", self.magnify, low=0.0, high=1e6, open_low=True)
        check_whole("width", self.width, unit="pixel", low=64, high=LARGEST)
        check_whole("height", self.height, unit="pixel", low=64, high=LARGEST)


def check_render_mode(mode: str | None, num_envs: int) -> str | None:
    """Return a render mode if it is None or one that can show `num_envs` robots.

    Raises:
        FFGymError: if it is not.
    """
    if mode is None:
        return None
    check_choice("render_mode", mode, ("human", "rgb_array"))
    if mode == "human" and num_envs != 1:
        raise FFGymError(
            f"render_mode='human' shows one robot, num_envs = {num_envs}; use gym.make, or render_mode='rgb_array'."
        )
    return mode
