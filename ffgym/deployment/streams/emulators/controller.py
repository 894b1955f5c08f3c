"""Controller of an emulator: a packet to the stream in every cycle, and the newest valid answer for the servo."""

from collections import Counter
from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.errors import check_number
from ffgym.core.types import Array
from ffgym.deployment.streams.emulators.robot import EmulatedRobot
from ffgym.deployment.streams.wire import Feedback, PacketError, StreamCommand, Wire
from ffgym.robot.friction import LuGreParameters

_TIMEOUT = 1.0
"""Time without a valid set-point after which the controller stops [s], ABB's default of CommTimeout."""
_ANSWERS = 50
"""Answers that a controller which runs a program by itself waits for before it begins (chosen)."""


@final
@dataclass(frozen=True, kw_only=True)
class DirectTorque:
    """Torque control of Universal Robots' direct_torque, beside a position control; torques act in their cycle."""

    viscous_scale: float = 0.0
    """Share of the robot's viscous friction that the controller compensates, 0 to 1."""
    coulomb_scale: float = 0.0
    """Share of its Coulomb friction that it compensates, 0 to 1."""

    def __post_init__(self) -> None:
        for name in ("viscous_scale", "coulomb_scale"):
            check_number(name, getattr(self, name), low=0.0, high=1.0)

    def compensate(self, friction: LuGreParameters, speed: Array) -> Array:
        """Compute the torque against friction at a speed, motor side [N m], shape (N,)."""
        return self.viscous_scale * friction.viscous * speed + self.coulomb_scale * friction.coulomb * np.sign(speed)


@final
class EmulatedController:
    """Controller with a robot behind it, which speaks the protocol of a wire."""

    def __init__(
        self,
        robot: EmulatedRobot,
        wire: Wire,
        *,
        direct_torque: DirectTorque | None = None,
        clock: float = 17.0,
        first: int = 4711,
    ) -> None:
        """Begin at rest.

        Args:
            robot: robot behind the controller.
            wire: protocol.
            direct_torque: how it takes torques, for protocols that have them; None takes positions alone.
            clock: what the clock of the controller shows at the start [s].
            first: number of its first packet.
        """
        self.robot, self.wire, self.direct_torque = robot, wire, direct_torque
        self.start = clock
        """What the clock showed at the start [s]."""
        self._first = first
        self._answer: StreamCommand | None = None
        self._last = -1
        self._silent = self._answered = 0
        self.refused: Counter[str] = Counter()
        """Set-points that were refused, by reason."""
        self.begun = False
        """True once a set-point came."""
        # what libraries prepare at their first message takes longer than a cycle
        none = np.zeros_like(robot.position)
        first_pose = StreamCommand(
            sequence=0, time=0.0, position=robot.position, correction=none, velocity=none, effort=none, token=0
        )
        wire.decode_command(wire.encode_command(first_pose))

    @property
    def stopped(self) -> bool:
        """True if set-points stayed out for too long."""
        return self.begun and self._silent * self.wire.cycle > _TIMEOUT

    def feedback(self) -> bytes:
        """Write the packet of this cycle."""
        robot = self.robot
        feedback = Feedback(
            sequence=self._first + robot.cycles,
            time=self.start + robot.time,
            position=robot.position,
            ready=not self.stopped,
            started=robot.runs,
        )
        return self.wire.encode_feedback(feedback, robot.planned)

    def receive(self, data: bytes) -> None:
        """Take a set-point for this cycle; older ones than the newest are refused."""
        try:
            command = self.wire.decode_command(data)
        except PacketError as error:
            self.refused[str(error)] += 1
            return
        if self.begun and not 0 < (command.sequence - self._last) % self.wire.wrap < self.wire.wrap // 2:
            self.refused["out of order"] += 1
            return
        if self.wire.needs_answers and command.time < self.start + self.robot.time - 0.5 * self.wire.cycle:
            self.refused["late"] += 1
            return
        self._last, self._answer, self.begun = command.sequence, command, True

    def advance(self) -> None:
        """Simulate the cycle with the set-point that came, if one did."""
        answer, self._answer = self._answer, None
        self._silent = 0 if answer is not None else self._silent + 1
        taken = None if self.stopped else answer
        self.robot.advance(None if taken is None else taken.position, self._torque(taken))
        # a program begins with a cycle whose packet says so
        if self.wire.needs_answers and self.begun:
            self._answered += answer is not None
            self.robot.runs = self._answered > _ANSWERS and not (self.stopped or self.robot.has_ended)

    def _torque(self, answer: StreamCommand | None) -> Array | None:
        """Compute the torque of a cycle beside that of the servo, motor side [N m]."""
        if self.direct_torque is None:
            return None
        robot, drive = self.robot.robot, self.robot.robot.drive
        against = self.direct_torque.compensate(robot.friction, self.robot.motor_speed)
        return against if answer is None else against + drive.motor_torque(answer.effort)
