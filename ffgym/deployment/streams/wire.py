"""Words of streams and emulators to each other, in any protocol: feedback, set-points, packets that are none."""

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from ffgym.core.types import Array
from ffgym.deployment.plan import numbers_per_unit


class PacketError(Exception):
    """A packet that says nothing that can be trusted; its text is the reason, of few kinds, for counts."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Feedback:
    """Message of a controller, once in a cycle."""

    sequence: int
    """Number of the packet."""
    time: float
    """Clock of the controller [s]."""
    position: Array
    """Measured joint positions, link side [rad or m], shape (N,)."""
    ready: bool = True
    """True if the controller takes set-points: motors on, program running."""
    started: bool = True
    """True once the program moves, for controllers that run it themselves."""
    token: Any = None
    """What an answer has to repeat."""


@dataclass(frozen=True, kw_only=True, eq=False)
class StreamCommand:
    """Message to a controller, once in a cycle."""

    sequence: int
    """Number of the packet."""
    time: float
    """Time since the start of the plan [s]."""
    position: Array
    """Set-point, program and correction, link side [rad or m], shape (N,)."""
    correction: Array
    """The correction in it, link side [rad or m], shape (N,)."""
    velocity: Array
    """Speed of the program, link side [rad/s or m/s], shape (N,)."""
    effort: Array
    """Feed-forward torque, link side [N m or N], shape (N,)."""
    token: Any = None
    """What the feedback wants repeated; None if it is no answer."""


class Wire(Protocol):
    """Protocol on the wire, both of its ends: streams use two of these functions, emulators the other two."""

    cycle: float
    """Time between packets of the controller [s]."""
    torques: bool
    """True if set-points carry torques in place of corrections of positions."""
    unsolicited: bool
    """True if the controller takes set-points that answer no packet of its own."""
    needs_answers: bool
    """True if the controller runs the program by itself, and wants an answer to each of its packets."""
    clock_step: float
    """Resolution of the controller's clock [s]."""
    number_step: float
    """Time from one sequence number to the next [s]."""
    wrap: int
    """Number at which sequence numbers begin again at 0."""

    def decode_feedback(self, data: bytes) -> Feedback:
        """Read a packet of the controller.

        Raises:
            PacketError: if it is none.
        """
        ...

    def encode_command(self, command: StreamCommand) -> bytes:
        """Write a packet for the controller."""
        ...

    def encode_feedback(self, feedback: Feedback, planned: Array) -> bytes:
        """Write what a controller sends that measures `feedback` and has planned positions (N,), link side."""
        ...

    def decode_command(self, data: bytes) -> StreamCommand:
        """Read a set-point as the controller does.

        Raises:
            PacketError: if it is none.
        """
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class JointAxes:
    """Joints as packets have them."""

    names: tuple[str, ...]
    """Names of the joints."""
    units: tuple[str, ...]
    """Unit of each joint, rad or m."""
    low: Array
    """Ends of the joint ranges [rad or m], shape (N,)."""
    high: Array
    n: int = field(init=False)
    """Number of joints N."""
    scale: Array = field(init=False)
    """Number in a packet of degrees and millimetres for one rad or m, shape (N,)."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "scale", numbers_per_unit(self.units))
        object.__setattr__(self, "n", len(self.units))

    def from_degrees(self, numbers: Any) -> Array:
        """Read positions that came in degrees and millimetres, one per joint.

        Raises:
            PacketError: if they are too few or too many, not finite, or beyond the range of a joint.
        """
        return self.check(np.fromiter(numbers, dtype=np.float64) / self.scale if len(numbers) == self.n else None)

    def check(self, position: Array | None) -> Array:
        """Return positions that a joint can have; None is a wrong number of them.

        Raises:
            PacketError: if they are not finite, or beyond the range of a joint.
        """
        if position is None or len(position) != self.n:
            raise PacketError("number of joints")
        if not ((position >= self.low) & (position <= self.high)).all():
            raise PacketError("out of range" if np.isfinite(position).all() else "not finite")
        return position
