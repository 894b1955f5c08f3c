"""Set-point channel: a law's torque by corrections of the set-points that a servo follows."""

from dataclasses import dataclass, field
from typing import final

from ffgym.control.corrections import CorrectionLimits, invert_servo, limit_correction
from ffgym.control.setpoint_response import SetpointResponse
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.robot.parts import Servo


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SetpointChannel:
    """Way of corrections of set-points to the servo, and what their sender knows of it; motor side."""

    response: SetpointResponse = field(default_factory=SetpointResponse)
    """What the controller does to corrections between sender and servo."""
    known: SetpointResponse | None = None
    """What the sender compensates; None is all of `response`, `SetpointResponse()` nothing."""
    limits: CorrectionLimits | None = None
    """Limits of what is sent, motor side; None is none."""

    def __post_init__(self) -> None:
        if not isinstance(self.response, SetpointResponse) or not isinstance(self.known, SetpointResponse | None):
            raise FFGymError(
                f"response and known of a set-point channel must be SetpointResponse(), got {self.response!r} and "
                f"{self.known!r}."
            )

    @property
    def compensated(self) -> SetpointResponse:
        """Part of the response that the sender compensates."""
        return self.response if self.known is None else self.known

    def send(self, servo: Servo, torque: Array) -> Array:
        """Compute the corrections to send for a torque (T, N) [N m]: motor side [rad], shape (T, N).

        Raises:
            FFGymError: if the servo has a gain that is not positive.
        """
        sent = self.compensated.invert(invert_servo(servo, torque), servo.control_dt)
        sent -= sent[0]  # which the machine begins at
        return sent if self.limits is None else limit_correction(self.limits, sent, servo.control_dt)

    def correct(self, servo: Servo, torque: Array) -> Array:
        """Compute the corrections that reach the servo for a torque, as `send`."""
        return self.response.apply(self.send(servo, torque), servo.control_dt)
