"""All readers, by the group whose process they share, and how many of a number of inputs each gets."""

from collections.abc import Sequence
from importlib import import_module

from scripts.fuzz.reader import Reader

GROUPS = tuple(
    f"scripts.fuzz.readers.{name}"
    for name in ("recordings", "logs", "leaderboard", "diagnosis", "deployment", "agents", "robots", "motions")
)
"""Modules with READERS."""


def load_readers(groups: Sequence[str] = GROUPS) -> dict[str, tuple[Reader, ...]]:
    """Import the readers of groups."""
    return {group: import_module(group).READERS for group in groups}


def share_inputs(readers: Sequence[Reader], inputs: int) -> dict[str, int]:
    """Share a number of inputs among readers, by name: each gets one at least."""
    total = sum(reader.share for reader in readers)
    return {reader.name: max(1, round(inputs * reader.share / total)) for reader in readers}
