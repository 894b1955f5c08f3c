"""The two ends of an RTDE connection: hands shaken, then data packages."""

import selectors
import socket
import struct
import time
from collections.abc import Hashable
from contextlib import suppress

from ffgym.core.errors import FFGymError
from ffgym.deployment.streams.ports import format_address
from ffgym.deployment.streams.rtde import DATA, INPUTS, OUTPUTS, RECIPE

_VERSION, _OUTPUTS, _INPUTS, _START = (ord(letter) for letter in "VOIS")
_LARGEST = 4096
"""Bytes of the largest package that is believed [chosen]; ours have 125 and 152."""
_FREQUENCY = 500.0
_PATIENCE = 2.0
"""Time to wait for an answer of the other end [s] (chosen)."""


class RtdePort:
    """One end of an RTDE connection, as `Port`; packages that are no data are passed over."""

    def __init__(self, connection: socket.socket) -> None:
        """Take over a connection."""
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setblocking(False)
        self._socket = connection
        self._selector = selectors.DefaultSelector()
        self._selector.register(connection, selectors.EVENT_READ)
        self._buffer = self._unsent = b""

    def receive(self, timeout: float) -> tuple[bytes, Hashable] | None:
        """Wait at most `timeout` [s] for a data package; returns it, or None."""
        until = time.perf_counter() + max(timeout, 0.0)
        while True:
            package = self.next_package(until - time.perf_counter())
            if package is None or package[2] == DATA:
                return None if package is None else (package, None)

    def next_package(self, timeout: float) -> bytes | None:
        """Wait at most `timeout` [s] for a package of any kind."""
        until = time.perf_counter() + timeout
        while (package := self._cut()) is None:
            if not self._selector.select(max(until - time.perf_counter(), 0.0)):
                return None
            try:
                received = self._socket.recv(1 << 16)
            except BlockingIOError:  # nothing came after all
                continue
            except OSError:
                received = b""
            if not received:  # the other end is gone
                time.sleep(max(until - time.perf_counter(), 0.0))
                return None
            self._buffer += received
        return package

    def send(self, data: bytes, receiver: Hashable) -> None:
        """Send a package; one that cannot be sent is lost, and one that was sent in part goes on first."""
        with suppress(OSError):
            if self._unsent:
                self._unsent = self._unsent[self._socket.send(self._unsent) :]
            if not self._unsent:
                self._unsent = data[self._socket.send(data) :]

    def request(self, kind: int, payload: bytes) -> bytes:
        """Send a request and return the payload of its answer.

        Raises:
            FFGymError: if there is none.
        """
        self.send(pack_package(kind, payload), None)
        until = time.perf_counter() + _PATIENCE
        while (package := self.next_package(until - time.perf_counter())) is not None:
            if package[2] == kind:
                return package[3:]
        raise FFGymError(f"The robot does not answer the RTDE request {chr(kind)!r}. Is the port that of RTDE, 30004?")

    def close(self) -> None:
        """End the connection."""
        self._selector.close()
        self._socket.close()

    def _cut(self) -> bytes | None:
        """Cut a whole package off the buffer; with a length that cannot be, all of it is thrown away."""
        if len(self._buffer) < 3:
            return None
        (size,) = struct.unpack_from(">H", self._buffer)
        if not 3 <= size <= _LARGEST:
            self._buffer = b""
            return None
        if len(self._buffer) < size:
            return None
        package, self._buffer = self._buffer[:size], self._buffer[size:]
        return package


def connect_rtde(address: tuple[str, int]) -> RtdePort:
    """Connect to a robot, agree on version and recipes, and start its packages.

    Raises:
        FFGymError: if it cannot be reached, or refuses.
    """
    try:
        port = RtdePort(socket.create_connection(address, timeout=_PATIENCE))
    except OSError as error:
        raise FFGymError(
            f"Cannot connect to {format_address(address)}: {error.strerror or error}. Check the address of the robot, "
            f"and that RTDE is enabled in its security settings."
        ) from error
    try:
        if port.request(_VERSION, struct.pack(">H", 2)) != b"\x01":
            raise FFGymError("The robot does not speak version 2 of RTDE; update its software.")
        _agree(port, _OUTPUTS, struct.pack(">d", _FREQUENCY), OUTPUTS)
        _agree(port, _INPUTS, b"", INPUTS)
        if port.request(_START, b"") != b"\x01":
            raise FFGymError("The robot does not start RTDE; restart its program.")
    except FFGymError:
        port.close()
        raise
    return port


def _agree(port: RtdePort, kind: int, prefix: bytes, fields: dict[str, str]) -> None:
    """Set up a recipe.

    Raises:
        FFGymError: if the robot lacks a field, another program has it, or the recipe is not the first.
    """
    answer = port.request(kind, prefix + ",".join(fields).encode())
    types = answer[1:].decode("ascii", errors="replace").split(",")
    wrong = [f"{name} ({got})" for (name, kind), got in zip(fields.items(), types, strict=False) if got != kind]
    if wrong or len(types) != len(fields):
        raise FFGymError(
            f"The robot refuses RTDE fields {', '.join(wrong) or types}. IN_USE: another client has them; end it. "
            f"NOT_FOUND: update the robot's software."
        )
    if answer[0] != RECIPE:
        raise FFGymError(
            f"The robot gives RTDE recipe {answer[0]} where {RECIPE} is the first. Restart the robot's RTDE clients."
        )


def accept_rtde(address: tuple[str, int], longest: float) -> RtdePort:
    """Wait for a client as a robot does, and agree on what it wants; for emulators.

    Raises:
        FFGymError: if the address is taken, or no client comes in `longest` [s].
    """
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    with listener:
        try:
            listener.bind(address)
            listener.listen(1)
            listener.settimeout(longest if longest < float("inf") else None)
            connection, _ = listener.accept()
        except OSError as error:
            reason = "no client came" if isinstance(error, TimeoutError) else error.strerror
            raise FFGymError(f"Cannot serve RTDE at {format_address(address)}: {reason}.") from error
    port = RtdePort(connection)
    known = OUTPUTS | INPUTS
    while (package := port.next_package(_PATIENCE)) is not None:
        kind, payload = package[2], package[3:]
        if kind in (_OUTPUTS, _INPUTS):
            names = payload[8 if kind == _OUTPUTS else 0 :].decode("ascii", errors="replace").split(",")
            types = [known.get(name, "NOT_FOUND") for name in names]
            port.send(pack_package(kind, bytes([RECIPE]) + ",".join(types).encode()), None)
        elif kind in (_VERSION, _START):
            port.send(pack_package(kind, b"\x01"), None)
        if kind == _START:
            return port
    port.close()
    raise FFGymError("The client did not start RTDE.")


def pack_package(kind: int, payload: bytes) -> bytes:
    """Write a package of RTDE."""
    return struct.pack(">HB", 3 + len(payload), kind) + payload
