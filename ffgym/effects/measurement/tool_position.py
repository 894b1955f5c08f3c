"""Tool positions of a recording, replaced by those that a tracker sees; common part of tracker effects."""

from collections.abc import Callable

from ffgym.core.types import Array
from ffgym.recordings import Recording


def replace_tool_positions(recording: Recording, seen: Callable[[Array], Array]) -> Recording:
    """Replace tool positions [m] (T, 3) by `seen` of them; a recording without any stays as it is."""
    if not recording.has("tcp.position"):
        return recording
    position = seen(recording.vector("tcp.position"))
    columns = {f"tcp.position.{axis}": position[:, k] for k, axis in enumerate("xyz")}
    return recording.derive({**recording.columns, **columns})
