"""Protocols by name, and how their two ends are connected."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import partial

from ffgym.core.errors import check_choice
from ffgym.deployment.streams.ports import Port, UdpPort
from ffgym.deployment.streams.wire import Axes, Wire
from ffgym.robot import RobotDescription

Connection = tuple[Port, Hashable]
"""Port, and the address that an emulator sends to."""


@dataclass(frozen=True, kw_only=True)
class StreamProtocol:
    """A protocol, as users choose it."""

    title: str
    """Name in full."""
    port: int
    """Usual port."""
    make_wire: Callable[[Axes], Wire]
    """Function that makes its packets for a robot."""
    open_stream: Callable[[tuple[str, int]], Port]
    """Function that opens the port of a stream at an address, this computer's, or that of a robot that serves."""
    open_emulator: Callable[[tuple[str, int], float], Connection]
    """Function that opens the port of an emulator for such an address, and waits for a stream at most so long [s]."""
    robot_serves: bool = False
    """True if the address is that of the robot, and streams connect to it."""


def _egm(axes: Axes) -> Wire:
    from ffgym.deployment.streams.egm import EgmWire

    return EgmWire(axes)


def _rsi(axes: Axes, cycle: float) -> Wire:
    from ffgym.deployment.streams.rsi import RsiWire

    return RsiWire(axes, cycle=cycle)


def _rtde(axes: Axes, torques: bool) -> Wire:
    from ffgym.deployment.streams.rtde import RtdeWire

    return RtdeWire(axes, torques=torques)


def _connect_rtde(address: tuple[str, int]) -> Port:
    from ffgym.deployment.streams.rtde_ports import connect_rtde

    return connect_rtde(address)


def _accept_rtde(address: tuple[str, int], longest: float) -> Connection:
    from ffgym.deployment.streams.rtde_ports import accept_rtde

    return accept_rtde(address, longest), None


def _over_udp(title: str, port: int, make_wire: Callable[[Axes], Wire]) -> StreamProtocol:
    """Make a protocol in which the controller sends to the stream's UDP port."""
    return StreamProtocol(
        title=title,
        port=port,
        make_wire=make_wire,
        open_stream=UdpPort,
        open_emulator=lambda address, longest: (UdpPort(), address),
    )


def _over_rtde(title: str, torques: bool) -> StreamProtocol:
    """Make a protocol in which the stream connects to the robot's RTDE."""
    return StreamProtocol(
        title=title,
        port=30004,
        make_wire=partial(_rtde, torques=torques),
        open_stream=_connect_rtde,
        open_emulator=_accept_rtde,
        robot_serves=True,
    )


PROTOCOLS = {
    "egm": _over_udp("ABB Externally Guided Motion", 6510, _egm),
    "rsi": _over_udp("KUKA Robot Sensor Interface, 4 ms", 59152, partial(_rsi, cycle=0.004)),
    "rsi_12ms": _over_udp("KUKA Robot Sensor Interface, 12 ms", 59152, partial(_rsi, cycle=0.012)),
    "rtde": _over_rtde("Universal Robots RTDE, servoj", False),
    "rtde_torque": _over_rtde("Universal Robots RTDE, direct_torque", True),
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
