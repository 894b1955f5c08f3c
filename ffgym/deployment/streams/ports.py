"""Ports: where packets of a stream or an emulator come in and go out, in real time."""

import selectors
import socket
import time
from collections.abc import Hashable
from contextlib import suppress
from typing import Protocol, Self, cast

from ffgym.core.errors import FFGymError, check_whole

_LARGEST = 65536
"""Bytes of the largest packet of UDP."""


class Port(Protocol):
    """Place where packets arrive, and from where answers go to who sent them."""

    def receive(self, timeout: float) -> tuple[bytes, Hashable] | None:
        """Wait at most `timeout` [s] for a packet; returns it and its sender, or None."""
        ...

    def send(self, data: bytes, receiver: Hashable) -> None:
        """Send a packet; one that cannot be sent is lost."""
        ...

    def close(self) -> None:
        """Free the port."""
        ...


class UdpPort:
    """Port of UDP."""

    def __init__(self, listen: tuple[str, int] | None = None) -> None:
        """Open a port at an address, or at any that is free.

        Raises:
            FFGymError: if the address is taken, or not of this machine.
        """
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind(listen or ("", 0))
        except OSError as error:
            self._socket.close()
            raise FFGymError(
                f"Cannot listen at {format_address(listen or ('', 0))}: {error.strerror}. Another program may have the "
                f"port, or the address is not of this machine."
            ) from error
        self._socket.setblocking(False)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._socket, selectors.EVENT_READ)

    @property
    def address(self) -> tuple[str, int]:
        """Address of this port."""
        host, port = self._socket.getsockname()
        return host, port

    def receive(self, timeout: float) -> tuple[bytes, Hashable] | None:
        """Wait at most `timeout` [s] for a packet; returns it and its sender, or None."""
        if not self._selector.select(max(timeout, 0.0)):
            return None
        try:
            return self._socket.recvfrom(_LARGEST)
        except OSError:  # of an answer to nobody, or a packet with a wrong checksum
            return None

    def send(self, data: bytes, receiver: Hashable) -> None:
        """Send a packet; one that cannot be sent is lost."""
        with suppress(OSError):  # of a full buffer, or a network that is down: as lost as on the way
            self._socket.sendto(data, cast("tuple[str, int]", receiver))

    def close(self) -> None:
        """Free the port."""
        self._selector.close()
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def parse_address(text: str, default_port: int) -> tuple[str, int]:
    """Read `host:port`, `host` or `:port`, and look the host up: its address has numbers.

    Raises:
        FFGymError: if the port is no number from 1 to 65535, or there is no such host.
    """
    host, _, port = text.partition(":")
    number = int(port) if port.isdecimal() else port or default_port
    number = check_whole(f"port of {text!r}", number, low=1, high=65535)
    try:
        return socket.gethostbyname(host or "127.0.0.1"), number
    except (OSError, UnicodeError) as error:  # unknown, or no name that a host can have
        reason = getattr(error, "strerror", None) or "no name of a host"
        raise FFGymError(f"There is no host {host!r}: {reason}. Check its name, or give its address (IPv4).") from error


def format_address(address: tuple[str, int]) -> str:
    """Write an address as `host:port`."""
    return f"{address[0] or '*'}:{address[1]}"


def sleep_until(moment: float) -> None:
    """Wait until `moment` of the clock `time.perf_counter` [s]."""
    remaining = moment - time.perf_counter()
    if remaining > 0:
        time.sleep(remaining)
