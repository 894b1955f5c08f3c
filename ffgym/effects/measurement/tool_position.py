"""What tracker effects share: tool positions of a recording, and the recording with others."""

from collections.abc import Callable

from ffgym.core.types import Array
from ffgym.recordings import Recording


def with_tool_at(recording: Recording, seen: Callable[[Array], Array]) -> Recording:
    """The recording with `seen` of its tool positions [m] (T, 3) in their place; as it is, if it has none."""
    if not recording.has("tcp.position"):
        return recording
    position = seen(recording.vector("tcp.position"))
    columns = {f"tcp.position.{axis}": position[:, k] for k, axis in enumerate("xyz")}
    return Recording(columns=dict(recording.columns) | columns, header=recording.header)
