"""ABB Externally Guided Motion: joint position guidance at 250 Hz, protobuf over UDP.

Messages are those that ABB's egm.proto defines, as abb-robot-client has compiled them: EgmRobot from the controller,
EgmSensor to it, angles in degrees (linear axes in millimetres), time stamps in milliseconds.
"""

from types import ModuleType
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.deployment.streams.wire import Feedback, JointAxes, PacketError, StreamCommand

_MOST_JOINTS = 6
"""Joints of a robot in EgmJoints; a seventh and external axes travel elsewhere."""
_CYCLE = 0.004
_UINT32 = 2**32


def load_messages() -> ModuleType:
    """Import the compiled messages of ABB's egm.proto.

    Raises:
        FFGymError: if abb-robot-client is not installed.
    """
    try:
        from abb_robot_client.egm import egm_pb2
    except ImportError as error:
        raise FFGymError("EGM needs abb-robot-client, which has its messages; pip install 'ffgym[streams]'.") from error
    module: ModuleType = egm_pb2
    return module


class EgmWire:
    """Packets of EGM."""

    cycle = _CYCLE
    torques = False
    unsolicited = True
    needs_answers = False
    clock_step = 0.001
    number_step = _CYCLE
    wrap = _UINT32

    def __init__(self, axes: JointAxes) -> None:
        """Prepare packets for a robot with `axes`, six at most."""
        if axes.n > _MOST_JOINTS:
            raise FFGymError(f"EGM sends {_MOST_JOINTS} joints of a robot, this one has {axes.n}.")
        self.axes = axes
        self._messages = load_messages()
        from google.protobuf.message import DecodeError

        self._bad = DecodeError

    def decode_feedback(self, data: bytes) -> Feedback:
        """Read an EgmRobot message."""
        message = self._parse(self._messages.EgmRobot(), data)
        self._check_header(message.header, self._messages.EgmHeader.MSGTYPE_DATA)
        position = self.axes.from_degrees(message.feedBack.joints.joints)
        motors, guided = message.motorState, message.mciState
        ready = motors.state == motors.MOTORS_ON and guided.state == guided.MCI_RUNNING
        header = message.header
        return Feedback(sequence=header.seqno, time=1e-3 * header.tm, position=position, ready=ready)

    def encode_command(self, command: StreamCommand) -> bytes:
        """Write an EgmSensor message with joint positions."""
        message = self._messages.EgmSensor()
        message.header.seqno = command.sequence % _UINT32
        message.header.tm = round(1e3 * command.time) % _UINT32
        message.header.mtype = self._messages.EgmHeader.MSGTYPE_CORRECTION
        message.planned.joints.joints.extend((command.position * self.axes.scale).tolist())
        data: bytes = message.SerializeToString()
        return data

    def encode_feedback(self, feedback: Feedback, planned: Array) -> bytes:
        """Write an EgmRobot message."""
        message = self._messages.EgmRobot()
        message.header.seqno = feedback.sequence % _UINT32
        message.header.tm = round(1e3 * feedback.time) % _UINT32
        message.header.mtype = self._messages.EgmHeader.MSGTYPE_DATA
        message.feedBack.joints.joints.extend((feedback.position * self.axes.scale).tolist())
        seconds = int(feedback.time)
        message.feedBack.time.sec, message.feedBack.time.usec = seconds, int(1e6 * (feedback.time - seconds))
        message.planned.joints.joints.extend((planned * self.axes.scale).tolist())
        motors, guided, program = message.motorState, message.mciState, message.rapidExecState
        motors.state = motors.MOTORS_ON if feedback.ready else motors.MOTORS_OFF
        guided.state = guided.MCI_RUNNING if feedback.ready else guided.MCI_STOPPED
        program.state = program.RAPID_RUNNING if feedback.ready else program.RAPID_STOPPED
        data: bytes = message.SerializeToString()
        return data

    def decode_command(self, data: bytes) -> StreamCommand:
        """Read an EgmSensor message with joint positions."""
        message = self._parse(self._messages.EgmSensor(), data)
        self._check_header(message.header, self._messages.EgmHeader.MSGTYPE_CORRECTION)
        none = np.zeros(self.axes.n)
        return StreamCommand(
            sequence=message.header.seqno,
            time=1e-3 * message.header.tm,
            position=self.axes.from_degrees(message.planned.joints.joints),
            correction=none,
            velocity=none,
            effort=none,
        )

    def _parse(self, message: Any, data: bytes) -> Any:
        try:
            message.ParseFromString(data)
        except self._bad:
            raise PacketError("not a message") from None
        return message

    def _check_header(self, header: Any, kind: int) -> None:
        if not (header.HasField("seqno") and header.HasField("tm")):
            raise PacketError("no sequence number or time")
        if header.mtype != kind:
            raise PacketError("kind of message")
