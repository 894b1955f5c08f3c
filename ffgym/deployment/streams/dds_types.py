# mypy: disable-error-code="call-arg"
"""Types of ROS 2 as DDS announces them; samples are the bytes of a message, which others write and read."""

from dataclasses import dataclass
from typing import Any

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float64, int32, sequence, uint32


def _as_bytes(kind: type[Any]) -> type[Any]:
    """Let samples of a type be messages in CDR, `data`, which are neither written nor read here."""

    def of(data: bytes) -> Any:
        sample: Any = object.__new__(kind)
        sample.data = data
        return sample

    kind.of = staticmethod(of)
    kind.serialize = lambda self, *_, **__: self.data
    kind.deserialize = staticmethod(lambda data, *_, **__: of(data))
    return kind


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    """builtin_interfaces/Time."""

    sec: int32
    nanosec: uint32


@dataclass
class Duration(IdlStruct, typename="builtin_interfaces::msg::dds_::Duration_"):
    """builtin_interfaces/Duration."""

    sec: int32
    nanosec: uint32


@dataclass
class StdHeader(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    """std_msgs/Header."""

    stamp: Time
    frame_id: str


@dataclass
class JointTrajectoryPoint(IdlStruct, typename="trajectory_msgs::msg::dds_::JointTrajectoryPoint_"):
    """trajectory_msgs/JointTrajectoryPoint."""

    positions: sequence[float64]
    velocities: sequence[float64]
    accelerations: sequence[float64]
    effort: sequence[float64]
    time_from_start: Duration


@_as_bytes
@dataclass
class JointState(IdlStruct, typename="sensor_msgs::msg::dds_::JointState_"):
    """sensor_msgs/JointState."""

    header: StdHeader
    name: sequence[str]
    position: sequence[float64]
    velocity: sequence[float64]
    effort: sequence[float64]


@_as_bytes
@dataclass
class JointTrajectory(IdlStruct, typename="trajectory_msgs::msg::dds_::JointTrajectory_"):
    """trajectory_msgs/JointTrajectory."""

    header: StdHeader
    joint_names: sequence[str]
    points: sequence[JointTrajectoryPoint]
