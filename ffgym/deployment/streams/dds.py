"""Messages of ROS 2 over DDS, as ROS itself sends them, by Cyclone DDS; no ROS is needed on this computer."""

import os
import time
from collections import deque
from collections.abc import Hashable
from typing import Any

from ffgym.core.errors import FFGymError, check_whole

TOPIC = "/joint_trajectory_controller/joint_trajectory"
"""Usual topic of a joint trajectory controller."""
_STATES = "rt/joint_states"
_MOST = 32
"""Messages that are taken at once."""


class DdsPort:
    """Port that publishes one topic and reads another; messages are bytes in CDR."""

    def __init__(self, topic: str, *, is_controller: bool = False) -> None:
        """Join the domain of ROS_DOMAIN_ID.

        Args:
            topic: of the trajectories, as ROS names it.
            is_controller: True for an emulator, which reads trajectories and publishes states.

        Raises:
            FFGymError: if cyclonedds is not installed, or the domain cannot be joined.
        """
        try:
            from cyclonedds.core import DDSException, ReadCondition, WaitSet
            from cyclonedds.domain import DomainParticipant
            from cyclonedds.pub import DataWriter
            from cyclonedds.qos import Policy, Qos
            from cyclonedds.sub import DataReader
            from cyclonedds.topic import Topic

            from ffgym.deployment.streams.dds_types import JointState, JointTrajectory
        except ImportError as error:
            raise FFGymError("ROS 2 needs cyclonedds, which carries messages; pip install 'ffgym[streams]'.") from error
        domain = os.environ.get("ROS_DOMAIN_ID", "0")
        number = check_whole("ROS_DOMAIN_ID", int(domain) if domain.isdecimal() else domain, low=0, high=232)
        quality = Qos(Policy.Reliability.Reliable(0), Policy.History.KeepLast(_MOST))
        try:
            participant = DomainParticipant(number)
            states = Topic(participant, _STATES, JointState, qos=quality)
            trajectories = Topic(participant, f"rt/{topic.lstrip('/')}", JointTrajectory, qos=quality)
            sent, read = (states, trajectories) if is_controller else (trajectories, states)
            self._wrap = JointState if is_controller else JointTrajectory
            self._writer, self._reader = DataWriter(participant, sent), DataReader(participant, read)
            self._waiting = WaitSet(participant)
            self._waiting.attach(ReadCondition(self._reader, _ANY))
        except DDSException as error:
            raise FFGymError(
                f"Cannot join the ROS domain {number} for {topic!r}: {error}. Check CYCLONEDDS_URI and the network."
            ) from error
        self._messages: deque[bytes] = deque()
        self._participant: Any = participant

    def receive(self, timeout: float) -> tuple[bytes, Hashable] | None:
        """Wait at most `timeout` [s] for a message; returns it, or None."""
        until = time.perf_counter() + max(timeout, 0.0)
        while not self._messages:
            self._messages.extend(sample.data for sample in self._reader.take(N=_MOST) if hasattr(sample, "data"))
            if not self._messages:
                remaining = until - time.perf_counter()
                if remaining <= 0:
                    return None
                self._waiting.wait(timeout=int(1e9 * remaining))
        return self._messages.popleft(), None

    def send(self, data: bytes, receiver: Hashable) -> None:
        """Publish a message."""
        self._writer.write(self._wrap.of(data))

    def close(self) -> None:
        """Leave the domain."""
        self._messages.clear()
        del self._waiting, self._reader, self._writer, self._participant


_ANY = 0x7F
"""Mask of all states of samples, views and instances."""
