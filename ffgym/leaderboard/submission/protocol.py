"""What is said between the process that simulates and the one that holds an agent: frames over two pipes.

A frame is one letter, the length of its payload (4 bytes, little endian), and the payload: JSON, or numbers whose shape
both sides know. Nothing in it can run as a program.
"""

import json
import os
import struct
import threading
from typing import Any, Final

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray

JSON: Final = b"J"
"""An order, or its answer."""
OBSERVATIONS: Final = b"O"
"""What agents see; payload as `pack_observations`."""
ACTIONS: Final = b"A"
"""What they decide; payload as `pack_actions`."""
REFUSED: Final = b"R"
"""JSON with the reason why the agent is not accepted; it may come at any time."""

LONGEST = 2**26
"""Bytes of a payload."""

_HEAD = struct.Struct("<cI")
_SHAPE = struct.Struct("<II?")
_TIME = struct.Struct("<Q")


class Closed(Exception):
    """The other side has gone."""


class Channel:
    """One end of two pipes, given by their file descriptors."""

    def __init__(self, reads: int, writes: int) -> None:
        self._reads, self._writes = reads, writes
        self._lock = threading.RLock()

    def send(self, kind: bytes, payload: bytes) -> None:
        """Send a frame, whole, whichever thread sends another.

        Raises:
            Closed: if the other side has gone.
        """
        data = memoryview(_HEAD.pack(kind, len(payload)) + payload)
        with self._lock:
            while data:
                try:
                    data = data[os.write(self._writes, data) :]
                except OSError as error:
                    raise Closed from error

    def send_json(self, value: Any, kind: bytes = JSON) -> None:
        """Send JSON."""
        self.send(kind, json.dumps(value).encode())

    def receive(self) -> tuple[bytes, bytes]:
        """Kind and payload of the next frame.

        Raises:
            Closed: if the other side has gone.
            FFGymError: if the frame is longer than any that is meant.
        """
        kind, length = _HEAD.unpack(self._read(_HEAD.size))
        if length > LONGEST:
            raise FFGymError(f"A message of {length} bytes is longer than any of this protocol.")
        return kind, self._read(length)

    def _read(self, length: int) -> bytes:
        parts = []
        while length:
            try:
                part = os.read(self._reads, min(length, 2**16))
            except OSError as error:
                raise Closed from error
            if not part:
                raise Closed
            parts.append(part)
            length -= len(part)
        return b"".join(parts)


def pack_observations(observation: Array, starts: BoolArray | None, *, first: bool) -> bytes:
    """Payload of observations (B, D), of where episodes begin (B,), and of whether there is no state yet."""
    rows, columns = observation.shape
    flags = np.zeros(rows, dtype=np.bool_) if starts is None else np.asarray(starts, dtype=np.bool_)
    numbers = np.ascontiguousarray(observation, dtype="<f8")
    return _SHAPE.pack(rows, columns, first) + flags.tobytes() + numbers.tobytes()


def unpack_observations(payload: bytes) -> tuple[Array, BoolArray, bool]:
    """Observations, where episodes begin, and whether there is no state yet."""
    rows, columns, first = _SHAPE.unpack_from(payload)
    flags = np.frombuffer(payload, dtype=np.bool_, count=rows, offset=_SHAPE.size)
    numbers = np.frombuffer(payload, dtype="<f8", count=rows * columns, offset=_SHAPE.size + rows)
    return numbers.reshape(rows, columns).astype(np.float64), flags.copy(), first


def pack_actions(action: Array, elapsed_ns: int) -> bytes:
    """Payload of actions (B, N), which are sent as float32, and of the time that they took [ns]."""
    return _TIME.pack(elapsed_ns) + np.ascontiguousarray(action, dtype="<f4").tobytes()


def unpack_actions(payload: bytes, rows: int, joints: int) -> tuple[Array, int]:
    """Actions, shape (rows, joints), and the time that they took [ns].

    Raises:
        FFGymError: if the payload is not that of as many numbers.
    """
    wanted = _TIME.size + 4 * rows * joints
    if len(payload) != wanted:
        raise FFGymError(f"Actions have {len(payload)} bytes, must have {wanted}.")
    (elapsed,) = _TIME.unpack_from(payload)
    numbers = np.frombuffer(payload, dtype="<f4", offset=_TIME.size)
    return numbers.reshape(rows, joints).astype(np.float64), elapsed
