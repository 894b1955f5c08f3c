"""A plan on its way to a controller, packet by packet: pure, without sockets and clocks of its own."""

from collections import Counter
from dataclasses import dataclass, field
from typing import Literal, final

import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.deployment.plan import SetpointPlan
from ffgym.deployment.streams.envelope import LONGEST_SILENCE, Envelope, Guard, usual_silence
from ffgym.deployment.streams.validity import FIRST, Order
from ffgym.deployment.streams.wire import Feedback, StreamCommand, Wire
from ffgym.robot.drive import Drive

State = Literal["waiting", "running", "ended", "refused", "lost"]
"""Waiting for the controller; sending; at the end of the plan; not begun, as the pose was wrong; given up after a long
silence."""

_GIVE_UP = 0.5
"""Silence after which a session ends [s] (chosen): controllers stop by themselves after a second at most."""


@dataclass(eq=False)
class StreamLog:
    """Rows of a session, one for each valid packet while it ran."""

    time: list[float] = field(default_factory=list)
    """Controller's clock since the first set-point [s]."""
    measured: list[Array] = field(default_factory=list)
    """Joint positions at that time, link side, (N,) each."""
    sent: list[Array] = field(default_factory=list)
    """Set-point that answered, link side, (N,) each."""
    correction: list[Array] = field(default_factory=list)
    """Correction in it, (N,) each."""


@final
class StreamSession:
    """State of one stream. `receive` and `tick` give what is to be sent; times are of the caller's clock [s].

    The answer to a packet that the controller stamped t after the first one it got is the program at t, so that the
    program keeps its own time, whatever is lost. The correction passes the `Guard`. After a silence in which the
    correction left, the program goes on without it until it ends; nothing brings the correction back but a new session.
    """

    def __init__(self, plan: SetpointPlan, wire: Wire, envelope: Envelope, drive: Drive) -> None:
        """Prepare a session.

        Args:
            plan: what is sent.
            wire: protocol.
            envelope: limits of the correction.
            drive: gears of the robot, for torques.
        """
        if envelope.patience <= wire.cycle:
            raise FFGymError(
                f"patience = {1e3 * envelope.patience:g} ms must be longer than the controller's cycle of "
                f"{1e3 * wire.cycle:g} ms. Set it to {1e3 * usual_silence(wire.cycle):g} ms, and the ramp to what is "
                f"left of {1e3 * LONGEST_SILENCE:g} ms."
            )
        _check_sends(plan, wire)
        self.plan, self.wire, self.envelope = plan, wire, envelope
        self._program, correction, torque = sample_plan(plan, wire.cycle)
        self._velocity = np.gradient(self._program, wire.cycle, axis=0)
        self.cut_share = 0.0 if wire.torques else envelope.cut_share(correction, wire.cycle)
        """Share by which the plan exceeds the limit it exceeds most; 0 if all of it is sent."""
        self._correction = envelope.limit(correction, wire.cycle)
        self._torque, self._drive, self._none = torque, drive, np.zeros(len(plan.joints))
        self._guard, self._order = Guard(envelope, wire.cycle), Order(wire)
        self.state: State = "waiting"
        self.refusal = ""
        """Reason for not beginning; empty if there is none."""
        self.is_stopped = False
        """True if somebody stopped the correction."""
        self.log = StreamLog()
        self.received = self.sent = 0
        self.started_at: float | None = None
        """Controller's clock at the first set-point [s]; None before it."""
        self._index = self._corrected = 0
        self._is_closing = self._is_away = False
        self._begun_at = self._valid_at = self._due = float("nan")
        self._encode_nothing(None)  # what libraries prepare at their first message takes longer than a cycle

    @property
    def refused(self) -> Counter[str]:
        """Packets that were refused, by reason."""
        return self._order.refused

    @property
    def lost_after(self) -> float | None:
        """Time from the first set-point to a silence in which the correction left [s]; None if there was none."""
        lost = self._guard.lost_at
        return None if lost is None else lost - self._begun_at

    @property
    def is_over(self) -> bool:
        """True if nothing more will be sent."""
        return self.state not in ("waiting", "running")

    @property
    def due(self) -> float:
        """Time at which `tick` has something to do [s]; inf while it has not."""
        return self._due if self.state == "running" else float("inf")

    def receive(self, data: bytes, now: float) -> bytes | None:
        """Take a packet and give the answer to send, or None."""
        self.received += 1
        if self.is_over:
            return None
        feedback = self._order.read(data, now)
        if feedback is None:
            return None
        if self.state == "waiting" and not self._begin(feedback, now):
            return self._keep_alive(feedback)
        if not feedback.ready:  # as if it had been silent: the correction leaves, then the session is given up
            self.refused["not ready"] += 1
            return None
        assert self.started_at is not None
        self._guard.hear(now)
        self._valid_at, self._due = now, now + 1.5 * self.wire.cycle
        elapsed = feedback.time - self.started_at
        self._index = max(self._index, round(elapsed / self.wire.cycle))
        if not (feedback.started or self._is_closing):  # the controller broke off its program
            self._close(now)
        data, command = self._command(now, feedback.token)
        if self._has_ended(now) and not (self.wire.needs_answers and feedback.started):
            self.state = "ended"
        self.log.time.append(elapsed)
        self.log.measured.append(feedback.position)
        self.log.sent.append(command.position)
        self.log.correction.append(command.correction)
        return data

    def tick(self, now: float) -> bytes | None:
        """Send what is due though the controller is silent, where it takes that; give up after a long silence."""
        if self.state != "running" or now < self.due:
            return None
        silence = now - self._valid_at
        if silence > _GIVE_UP:
            self.state = "ended" if self._has_ended(now) else "lost"
            return None
        self._due = now + self.wire.cycle
        if not self.wire.unsolicited:
            return None
        expected = round((self.log.time[-1] + silence) / self.wire.cycle - 0.5)
        self._index = max(self._index, expected)
        data = self._command(now, None)[0]
        if self._has_ended(now):
            self.state = "ended"
        return data

    def stop(self, now: float) -> None:
        """Let the correction leave; the program goes on to its end without it."""
        self.is_stopped = True
        self._close(now)

    def _begin(self, feedback: Feedback, now: float) -> bool:
        """Begin once packets came in order, the controller takes set-points, and its pose is right.

        Two packets in a row must tell of a wrong pose: one may be damaged where a protocol has no checksum.
        """
        was_away = self._is_away
        self._is_away = bool((np.abs(feedback.position - self._program[0]) > self.envelope.start_tolerance).any())
        if self._order.agreed < FIRST or not feedback.ready or not feedback.started:
            return False
        if self._is_away:
            if was_away:
                self.state, self.refusal = "refused", self._describe_pose(feedback.position)
            return False
        self.state, self.started_at, self._begun_at = "running", feedback.time, now
        return True

    def _keep_alive(self, feedback: Feedback) -> bytes | None:
        """Answer without a correction a controller that needs answers before it begins."""
        return None if self.is_over or not self.wire.needs_answers else self._encode_nothing(feedback.token)

    def _encode_nothing(self, token: object) -> bytes:
        """Write a set-point at the first pose, without a correction."""
        idle = StreamCommand(
            sequence=self.sent,
            time=0.0,
            position=self._program[0],
            correction=self._none,
            velocity=self._none,
            effort=self._none,
            token=token,
        )
        return self.wire.encode_command(idle)

    def _close(self, now: float) -> None:
        """Let the correction leave; once is enough."""
        self._is_closing = True
        self._guard.close(now)

    def _has_ended(self, now: float) -> bool:
        """Tell if the plan is at its end and the correction out."""
        return self._index >= len(self._program) - 1 and self._guard.gate(now) == 0.0

    def _describe_pose(self, position: Array) -> str:
        j = int(np.argmax(np.abs(position - self._program[0])))
        unit = self.plan.units[j]
        return (
            f"The robot is not at the first pose of {self.plan.name!r}: joint {self.plan.joints[j]} is at "
            f"{position[j]:.5f} {unit}, the program begins at {self._program[0, j]:.5f} {unit}, and at most "
            f"{self.envelope.start_tolerance:g} {unit} apart is allowed. Move the robot there; nothing was sent."
        )

    def _command(self, now: float, token: object) -> tuple[bytes, StreamCommand]:
        """Make the set-point of the present sample."""
        last = len(self._program) - 1
        k = min(self._index, last)
        if self._index >= last and not self._is_closing:
            self._close(now)
        correction = torque = self._none
        if self.wire.torques:
            torque = self._guard.torque(self._torque[k], now)
        else:
            correction = self._guard.correct(self._correction[k], self._index - self._corrected, now)
        self._corrected = self._index
        command = StreamCommand(
            sequence=self.sent,
            time=self._index * self.wire.cycle,
            position=self._program[k] + correction,
            correction=correction,
            velocity=self._velocity[k],
            effort=self._drive.joint_torque(torque),
            token=token,
        )
        self.sent += 1
        return self.wire.encode_command(command), command


def _check_sends(plan: SetpointPlan, wire: Wire) -> None:
    """Check that the correction of a plan is timed for what the protocol sends.

    Raises:
        FFGymError: if it is not.
    """
    wanted = "corrections" if wire.needs_answers else "positions"
    planned = plan.meta.get("sends", wanted)
    if planned == wanted or wire.torques or not plan.correction.any():
        return
    raise FFGymError(
        f"Plan {plan.name!r} was made to send {planned}, this protocol sends {wanted}: its correction would come at "
        f"the wrong time. Plan the motion again: ffgym plan --sends {wanted}."
    )


def sample_plan(plan: SetpointPlan, cycle: float) -> tuple[Array, Array, Array]:
    """Sample program, correction and torque of a plan once a `cycle` [s], shape (T, N) each.

    They are joined by cubic splines where the samples of the plan lie elsewhere.

    Raises:
        FFGymError: if the plan is too short.
    """
    parts = plan.program, plan.correction, plan.torque
    if abs(plan.dt - cycle) < 1e-12:
        return parts
    count = int(np.floor(plan.t[-1] / cycle + 1e-9)) + 1
    if len(plan.program) < 4 or count < 2:
        raise FFGymError(f"Plan {plan.name!r} lasts {plan.t[-1]:g} s, too short for a cycle of {cycle:g} s.")
    times = np.arange(count) * cycle
    program, correction, torque = (
        np.asarray(scipy.interpolate.make_interp_spline(plan.t, part, k=3)(times), dtype=np.float64) for part in parts
    )
    return program, correction, torque
