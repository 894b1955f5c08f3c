"""Protocols by name, and how their two ends are connected."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import partial

from ffgym.core.errors import FFGymError, check_choice
from ffgym.deployment.streams.ports import Port, UdpPort, parse_address
from ffgym.deployment.streams.wire import JointAxes, Wire
from ffgym.robot import RobotDescription

Connection = tuple[Port, Hashable]
"""Port, and the address to which its packets go."""


@dataclass(frozen=True, kw_only=True)
class StreamProtocol:
    """A protocol, as users choose it."""

    title: str
    """Name in full."""
    make_wire: Callable[[JointAxes], Wire]
    """Function that makes its packets for a robot."""
    open_stream: Callable[[str | None], Port]
    """Function that opens the port of a stream for an address as users write it; None is the usual one."""
    open_emulator: Callable[[str | None, float], Connection]
    """Function that opens the port of an emulator, and waits for a stream at most so long [s]."""


def _egm(axes: JointAxes) -> Wire:
    from ffgym.deployment.streams.egm import EgmWire

    return EgmWire(axes)


def _rsi(axes: JointAxes, cycle: float) -> Wire:
    from ffgym.deployment.streams.rsi import RsiWire

    return RsiWire(axes, cycle=cycle)


def _rtde(axes: JointAxes, torques: bool) -> Wire:
    from ffgym.deployment.streams.rtde import RtdeWire

    return RtdeWire(axes, torques=torques)


def _ros2(axes: JointAxes, torques: bool) -> Wire:
    from ffgym.deployment.streams.ros2 import Ros2Wire

    return Ros2Wire(axes, torques=torques)


def _connect_rtde(address: str | None) -> Port:
    from ffgym.deployment.streams.rtde_ports import connect_rtde

    if address is None:
        raise FFGymError("Say where the robot is that serves RTDE: --address HOST.")
    return connect_rtde(parse_address(address, _RTDE_PORT))


def _accept_rtde(address: str | None, longest: float) -> Connection:
    from ffgym.deployment.streams.rtde_ports import accept_rtde

    return accept_rtde(parse_address(address or "", _RTDE_PORT), longest), None


def _join_ros(topic: str | None) -> Port:
    from ffgym.deployment.streams.dds import TOPIC, DdsPort

    return DdsPort(topic or TOPIC)


def _join_ros_as_controller(topic: str | None, longest: float) -> Connection:
    from ffgym.deployment.streams.dds import TOPIC, DdsPort

    return DdsPort(topic or TOPIC, is_controller=True), None


def _over_udp(title: str, port: int, make_wire: Callable[[JointAxes], Wire]) -> StreamProtocol:
    """Make a protocol in which the controller sends to the stream's UDP port."""

    def open_emulator(address: str | None, longest: float) -> Connection:
        there = parse_address(address or "", port)
        return UdpPort(), there

    return StreamProtocol(
        title=title,
        make_wire=make_wire,
        open_stream=lambda address: UdpPort(parse_address(address or "0.0.0.0", port)),
        open_emulator=open_emulator,
    )


def _over_rtde(title: str, torques: bool) -> StreamProtocol:
    """Make a protocol in which the stream connects to the robot's RTDE."""
    wire = partial(_rtde, torques=torques)
    return StreamProtocol(title=title, make_wire=wire, open_stream=_connect_rtde, open_emulator=_accept_rtde)


def _over_ros(title: str, torques: bool) -> StreamProtocol:
    """Make a protocol of topics of ROS 2."""
    wire = partial(_ros2, torques=torques)
    return StreamProtocol(title=title, make_wire=wire, open_stream=_join_ros, open_emulator=_join_ros_as_controller)


_RTDE_PORT = 30004
"""Port of RTDE on a robot."""

PROTOCOLS = {
    "egm": _over_udp("ABB Externally Guided Motion", 6510, _egm),
    "rsi": _over_udp("KUKA Robot Sensor Interface, 4 ms", 59152, partial(_rsi, cycle=0.004)),
    "rsi_12ms": _over_udp("KUKA Robot Sensor Interface, 12 ms", 59152, partial(_rsi, cycle=0.012)),
    "rtde": _over_rtde("Universal Robots RTDE, servoj", False),
    "rtde_torque": _over_rtde("Universal Robots RTDE, direct_torque", True),
    "ros2": _over_ros("ROS 2 joint trajectory controller, positions", False),
    "ros2_effort": _over_ros("ROS 2 joint trajectory controller, positions and effort", True),
}
"""Every protocol."""


def protocol_named(name: str) -> StreamProtocol:
    """Return a protocol by its name.

    Raises:
        FFGymError: if there is none of that name.
    """
    return PROTOCOLS[check_choice("protocol", name, tuple(PROTOCOLS))]


def axes_of(robot: RobotDescription) -> JointAxes:
    """Describe the joints of a robot for packets."""
    low, high = robot.kinematics.range.T
    return JointAxes(names=robot.joints, units=robot.kinematics.units, low=low, high=high)
