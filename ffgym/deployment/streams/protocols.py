"""Protocols by name, and how their two ends are connected."""

from collections.abc import Callable
from dataclasses import dataclass

from ffgym.core.errors import check_choice
from ffgym.deployment.streams.wire import Axes, Wire
from ffgym.robot import RobotDescription


def _egm(axes: Axes) -> Wire:
    from ffgym.deployment.streams.egm import EgmWire

    return EgmWire(axes)


def _rsi(axes: Axes) -> Wire:
    from ffgym.deployment.streams.rsi import RsiWire

    return RsiWire(axes)


def _rsi_12ms(axes: Axes) -> Wire:
    from ffgym.deployment.streams.rsi import RsiWire

    return RsiWire(axes, cycle=0.012)


@dataclass(frozen=True, kw_only=True)
class StreamProtocol:
    """A protocol, as users choose it."""

    title: str
    """Name in full."""
    port: int
    """Usual port."""
    make_wire: Callable[[Axes], Wire]
    """Function that makes its packets for a robot."""


PROTOCOLS = {
    "egm": StreamProtocol(title="ABB Externally Guided Motion", port=6510, make_wire=_egm),
    "rsi": StreamProtocol(title="KUKA Robot Sensor Interface, 4 ms", port=59152, make_wire=_rsi),
    "rsi_12ms": StreamProtocol(title="KUKA Robot Sensor Interface, 12 ms", port=59152, make_wire=_rsi_12ms),
}
"""Every protocol."""


def protocol_named(name: str) -> StreamProtocol:
    """Return a protocol by its name.

    Raises:
        FFGymError: if there is none of that name.
    """
    return PROTOCOLS[check_choice("protocol", name, tuple(PROTOCOLS))]


def axes_of(robot: RobotDescription) -> Axes:
    """Describe the joints of a robot for packets."""
    low, high = robot.kinematics.range.T
    return Axes(units=robot.kinematics.units, low=low, high=high)
