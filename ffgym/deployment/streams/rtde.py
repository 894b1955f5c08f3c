"""Universal Robots RTDE at 500 Hz over TCP: set-points, speeds and torques in registers of a program on the robot.

The program is that of `write_urscript`: it follows positions by servoj, or adds torques to a position control of its
own and calls direct_torque. Packages are those of version 2 of the protocol: size and kind in three bytes, the number
of the recipe, then the fields of the recipe, big-endian. Angles are in rad, torques in N m at the joints.
"""

import struct

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.deployment.streams.wire import Feedback, JointAxes, PacketError, StreamCommand

_JOINTS = 6
_CYCLE = 0.002
DATA = ord("U")
"""Kind of a data package."""
OUTPUTS = {
    "timestamp": "DOUBLE",
    "actual_q": "VECTOR6D",
    "target_q": "VECTOR6D",
    "robot_mode": "INT32",
    "safety_mode": "INT32",
    "output_int_register_24": "INT32",
}
"""Fields that the robot sends, and their types; the program writes 1 into the register while it takes set-points."""
INPUTS = {
    "input_int_register_24": "INT32",
    **{f"input_double_register_{24 + k}": "DOUBLE" for k in range(3 * _JOINTS)},
}
"""Fields that the robot gets: the number of the set-point; then positions, speeds and torques. Registers 24 to 47 are
for external clients."""
_CODES = {"DOUBLE": "d", "VECTOR6D": "6d", "INT32": "i"}
_OUTPUT = struct.Struct(">HBB" + "".join(_CODES[kind] for kind in OUTPUTS.values()))
_INPUT = struct.Struct(">HBB" + "".join(_CODES[kind] for kind in INPUTS.values()))
RECIPE = 1
"""Number of the first recipe of each kind that a client agrees on."""
_RUNNING, _NORMAL = 7, 1
"""Robot mode and safety mode of a robot that moves."""


class RtdeWire:
    """Data packages of RTDE."""

    unsolicited = True
    needs_answers = False
    cycle = _CYCLE
    number_step = _CYCLE
    clock_step = 1e-6
    wrap = 2**31

    def __init__(self, axes: JointAxes, *, torques: bool = False) -> None:
        """Prepare packages for a robot with `axes`, six hinges; with `torques` for a program that takes these."""
        if axes.n != _JOINTS or set(axes.units) != {"rad"}:
            raise FFGymError(f"RTDE is for robots of {_JOINTS} hinges, this one has joints in {', '.join(axes.units)}.")
        self.axes, self.torques = axes, torques

    def decode_feedback(self, data: bytes) -> Feedback:
        """Read a data package of the robot."""
        fields = _unpack(_OUTPUT, data)
        clock, mode, safety, takes = fields[0], *fields[-3:]
        if not 0 <= clock < 2**31 * _CYCLE:  # NaN is not, either
            raise PacketError("no sequence number or time")
        ready = (mode, safety, takes) == (_RUNNING, _NORMAL, 1)
        position = self.axes.check(np.array(fields[1:7]))
        return Feedback(sequence=round(clock / _CYCLE), time=clock, position=position, ready=ready)

    def encode_command(self, command: StreamCommand) -> bytes:
        """Write a data package with position, speed and torque."""
        values = (*command.position.tolist(), *command.velocity.tolist(), *command.effort.tolist())
        number = (round(command.time / _CYCLE) + 1) % self.wrap  # 0 is that of a register nobody wrote
        return _INPUT.pack(_INPUT.size, DATA, RECIPE, number, *values)

    def encode_feedback(self, feedback: Feedback, planned: Array) -> bytes:
        """Write a data package as the robot does."""
        takes = 1 if feedback.ready else 0
        positions = (*feedback.position.tolist(), *planned.tolist())
        return _OUTPUT.pack(_OUTPUT.size, DATA, RECIPE, feedback.time, *positions, _RUNNING, _NORMAL, takes)

    def decode_command(self, data: bytes) -> StreamCommand:
        """Read a data package as the robot does."""
        number, *values = _unpack(_INPUT, data)
        position, velocity, effort = np.array(values).reshape(3, _JOINTS)
        self.axes.check(position)
        if not np.isfinite([velocity, effort]).all():
            raise PacketError("not finite")
        return StreamCommand(
            sequence=int(number),
            time=(number - 1) * _CYCLE,
            position=position,
            correction=np.zeros(_JOINTS),
            velocity=velocity,
            effort=effort,
        )


def _unpack(form: struct.Struct, data: bytes) -> tuple[float, ...]:
    """Read the fields of a data package of one length and one recipe."""
    if len(data) != form.size:
        raise PacketError("length")
    size, kind, recipe, *fields = form.unpack(data)
    if (size, kind, recipe) != (form.size, DATA, RECIPE):
        raise PacketError("kind of message")
    return tuple(fields)
