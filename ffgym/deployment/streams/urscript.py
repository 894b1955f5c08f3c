"""URScript of the program that a Universal Robots robot runs while a stream sends to its registers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from ffgym.core.errors import FFGymError, check_number, check_shape

_MISSED = 10
"""Cycles without a new set-point after which the program stops the robot: 20 ms."""


@final
@dataclass(frozen=True, kw_only=True)
class ServoProgram:
    """Program that follows positions by servoj."""

    lookahead_time: float = 0.03
    """Smoothing [s], 0.03 to 0.2."""
    gain: float = 2000.0
    """Proportional gain, 100 to 2000."""

    def __post_init__(self) -> None:
        check_number("lookahead_time", self.lookahead_time, unit="s", low=0.03, high=0.2)
        check_number("gain of servoj", self.gain, low=100.0, high=2000.0)

    @property
    def command(self) -> str:
        """Lines of the program that move the robot for a cycle."""
        return f"    servoj(q, t=0.002, lookahead_time={self.lookahead_time:g}, gain={self.gain:g})"


@final
@dataclass(frozen=True, kw_only=True)
class TorqueProgram:
    """Program that controls positions itself, adds the torques of the stream, and calls direct_torque.

    direct_torque compensates gravity, and shares of the friction by a model of its own: by default 0.9 of the viscous
    and 0.8 of the Coulomb friction, 0.1 less on the elbow (PolyScope 5.25). A feed-forward law that stands for all
    friction needs scales of 0.
    """

    stiffness: Sequence[float]
    """Torque per position error of each joint [N m/rad]."""
    damping: Sequence[float]
    """Torque per speed error of each joint [N m s/rad]."""
    viscous_scale: Sequence[float] = (0.0,) * 6
    """Share of viscous friction that the robot compensates, 0 to 1."""
    coulomb_scale: Sequence[float] = (0.0,) * 6
    """Share of Coulomb friction that the robot compensates, 0 to 1."""

    def __post_init__(self) -> None:
        for name in ("stiffness", "damping", "viscous_scale", "coulomb_scale"):
            values = check_shape(name, getattr(self, name), (6,))
            most = 1.0 if name.endswith("scale") else float("inf")
            if values.min() < 0 or values.max() > most:
                raise FFGymError(f"{name} = {values.tolist()} must be within [0, {most:g}] for each joint.")

    @property
    def command(self) -> str:
        """Lines of the program that move the robot for a cycle."""
        scales = f"viscous_scale={_list(self.viscous_scale)}, coulomb_scale={_list(self.coulomb_scale)}"
        return "\n".join(
            [
                "    q_now = get_actual_joint_positions()",
                "    qd_now = get_actual_joint_speeds()",
                f"    stiffness = {_list(self.stiffness)}",
                f"    damping = {_list(self.damping)}",
                "    torque = u",
                "    j = 0",
                "    while j < 6:",
                "      torque[j] = u[j] + stiffness[j] * (q[j] - q_now[j]) + damping[j] * (qd[j] - qd_now[j])",
                "      j = j + 1",
                "    end",
                f"    direct_torque(torque, {scales})",
            ]
        )


def _list(values: Sequence[float]) -> str:
    """Write numbers as a list of URScript."""
    return str([float(value) for value in values])


def write_urscript(program: ServoProgram | TorqueProgram) -> str:
    """Write the program that reads the registers of `RtdeWire` and moves the robot.

    It takes no set-point before the first one came, and stops the robot after 20 ms without a new one.
    """

    def read(first: int) -> str:
        return "[" + ", ".join(f"read_input_float_register({first + j})" for j in range(6)) + "]"

    return "\n".join(
        [
            "def ffgym_stream():",
            "  write_output_integer_register(24, 1)",
            "  last = read_input_integer_register(24)",
            "  while read_input_integer_register(24) == last:",
            "    sync()",
            "  end",
            "  missed = 0",
            f"  while missed < {_MISSED}:",
            "    number = read_input_integer_register(24)",
            "    if number == last:",
            "      missed = missed + 1",
            "    else:",
            "      missed = 0",
            "    end",
            "    last = number",
            f"    q = {read(24)}",
            f"    qd = {read(30)}",
            f"    u = {read(36)}",
            program.command,
            "  end",
            "  write_output_integer_register(24, 0)",
            "  stopj(4.0)",
            "end",
            "",
        ]
    )
