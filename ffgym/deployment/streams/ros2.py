"""ROS 2: set-points for a joint trajectory controller, one point each, with effort if it takes that; messages in CDR.

The stream publishes trajectory_msgs/JointTrajectory and reads sensor_msgs/JointState. A point is to be reached one
cycle after its message came, and replaces the one before. Messages are written and read by rosbags, so that neither ROS
nor a compiler is needed; `ffgym.deployment.streams.dds` carries them.
"""

from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_number
from ffgym.core.types import Array
from ffgym.deployment.streams.wire import Feedback, JointAxes, PacketError, StreamCommand

STATE, TRAJECTORY = "sensor_msgs/msg/JointState", "trajectory_msgs/msg/JointTrajectory"
"""Types of the messages."""
_LARGEST = 65536
"""Bytes of the largest message that is read (chosen)."""
_TICK = 1e-6
"""Resolution of numbers that are made of time stamps [s]."""
_LATEST = 2**31
"""End of the time stamps [s]."""


class Ros2Wire:
    """Messages of ROS 2."""

    unsolicited = True
    needs_answers = False
    number_step = _TICK
    clock_step = _TICK
    wrap = 2**62

    def __init__(self, axes: JointAxes, *, cycle: float = 0.004, torques: bool = False) -> None:
        """Prepare messages.

        Args:
            axes: joints of the robot, with their names in ROS.
            cycle: time between joint states [s].
            torques: True for controllers that take effort.

        Raises:
            FFGymError: if rosbags is not installed.
        """
        try:
            from rosbags.typesys import Stores, get_typestore
        except ImportError as error:
            raise FFGymError("ROS 2 needs rosbags, which has its messages; pip install 'ffgym[streams]'.") from error
        self.axes, self.joints, self.torques = axes, list(axes.names), torques
        self.cycle = check_number("cycle", cycle, unit="s", low=0.0, open_low=True)
        self._store = get_typestore(Stores.ROS2_JAZZY)
        self._types = self._store.types

    def decode_feedback(self, data: bytes) -> Feedback:
        """Read a JointState, in which our joints are in any order."""
        message = self._read(data, STATE)
        stamp = message.header.stamp
        clock = stamp.sec + 1e-9 * stamp.nanosec
        if not (0 <= stamp.sec < _LATEST and 0 <= stamp.nanosec < 10**9):
            raise PacketError("no sequence number or time")
        places = {name: j for j, name in enumerate(message.name)}
        if len(message.position) != len(message.name) or not places.keys() >= set(self.joints):
            raise PacketError("number of joints")
        position = self.axes.check(np.array([message.position[places[name]] for name in self.joints]))
        return Feedback(sequence=round(clock / _TICK), time=clock, position=position)

    def encode_command(self, command: StreamCommand) -> bytes:
        """Write a JointTrajectory of one point."""
        point = self._types["trajectory_msgs/msg/JointTrajectoryPoint"](
            positions=command.position,
            velocities=command.velocity,
            accelerations=np.zeros(0),
            effort=command.effort if self.torques else np.zeros(0),
            time_from_start=self._types["builtin_interfaces/msg/Duration"](0, round(1e9 * self.cycle)),
        )
        # a stamp of 0 is now; the frame has no meaning for joints, and tells the time in the plan
        trajectory = self._types[TRAJECTORY](
            header=self._header(0.0, f"{command.time:.6f}"), joint_names=self.joints, points=[point]
        )
        return self._write(trajectory, TRAJECTORY)

    def encode_feedback(self, feedback: Feedback, planned: Array) -> bytes:
        """Write a JointState."""
        none = np.zeros(0)
        state = self._types[STATE](
            header=self._header(feedback.time, ""),
            name=self.joints,
            position=feedback.position,
            velocity=none,
            effort=none,
        )
        return self._write(state, STATE)

    def decode_command(self, data: bytes) -> StreamCommand:
        """Read a JointTrajectory of one point for our joints."""
        message = self._read(data, TRAJECTORY)
        if message.joint_names != self.joints or len(message.points) != 1:
            raise PacketError("number of joints")
        (point,) = message.points
        effort = point.effort if len(point.effort) else np.zeros(self.axes.n)
        if len(point.velocities) != self.axes.n or len(effort) != self.axes.n:
            raise PacketError("number of joints")
        if not (np.isfinite(point.velocities).all() and np.isfinite(effort).all()):
            raise PacketError("not finite")
        try:
            time = float(message.header.frame_id)
        except ValueError:
            raise PacketError("no sequence number or time") from None
        if not 0 <= time < _LATEST:
            raise PacketError("no sequence number or time")
        return StreamCommand(
            sequence=round(time / _TICK),
            time=time,
            position=self.axes.check(np.asarray(point.positions)),
            correction=np.zeros(self.axes.n),
            velocity=np.asarray(point.velocities),
            effort=np.asarray(effort),
        )

    def _header(self, time: float, frame: str) -> Any:
        seconds = int(time)
        stamp = self._types["builtin_interfaces/msg/Time"](seconds, round(1e9 * (time - seconds)) % 10**9)
        return self._types["std_msgs/msg/Header"](stamp, frame)

    def _write(self, message: Any, kind: str) -> bytes:
        return bytes(self._store.serialize_cdr(message, kind))

    def _read(self, data: bytes, kind: str) -> Any:
        if not 4 < len(data) <= _LARGEST or data[:2] != b"\x00\x01":  # little-endian CDR alone, as all senders use
            raise PacketError("not a message")
        try:
            return self._store.deserialize_cdr(data, kind)
        except Exception:  # rosbags raises a dozen types for wrong bytes
            raise PacketError("not a message") from None
