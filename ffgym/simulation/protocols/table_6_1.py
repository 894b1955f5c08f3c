"""The sines of table 6.1 of the thesis, from which the dynamic LuGre model of a joint is identified."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.paths import Reference, joint_reference
from ffgym.paths.circles import DWELL
from ffgym.paths.excitations import joint_path
from ffgym.paths.motion import Segment, standstill
from ffgym.paths.motions.part import entry
from ffgym.published import FRICTION_RECORDS, FrictionRecord
from ffgym.simulation.protocols.protocol import JointProtocol, Scheduled
from ffgym.simulation.protocols.stage import Stage


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Table61(JointProtocol):
    """Sines of the motor speed, dq_ref = A sin(2 pi f t), one joint at a time, over whole periods.

    Record 11 has A = 10 rad/s, see `ffgym.published.FRICTION_RECORDS`.
    """

    name: ClassVar[str] = "table_6_1"
    purpose: ClassVar[str] = "dynamic friction (sigma_0, sigma_1) of each joint, thesis table 6.1 and (6.13)"

    records: Sequence[int] = entry("numbers of the records; absent is all fifteen", default=())
    least: float = entry("shortest time of a sine", "s", default=6.0)
    periods: int = entry("fewest periods", default=3)

    def motions(self, stage: Stage) -> list[Scheduled]:
        """One for each joint and record."""
        least = check_number("least", self.least, unit="s", low=0.0, high=3600.0)
        periods = check_whole("periods", self.periods, low=1, high=1000)
        known = {record.number: record for record in FRICTION_RECORDS}
        numbers = check_shape("records", self.records, (None,)).tolist()
        unknown = [number for number in numbers if number not in known]
        if unknown or len(set(numbers)) < len(numbers):
            raise FFGymError(f"records = {numbers} must be numbers from 1 to {len(known)}, each of them once.")
        chosen = [known[number] for number in numbers or known]
        return self.paused(
            [
                _sine(stage, joint, record, max(periods, int(np.ceil(least * record.frequency))))
                for joint in stage.moved(self.joints)
                for record in chosen
            ]
        )


def _sine(stage: Stage, joint: int, record: FrictionRecord, periods: int) -> Reference:
    """Speed A sin(2 pi f t) of one motor: the joint starts and ends at rest, at one end of its way."""
    omega = 2 * np.pi * record.frequency
    half_way = stage.only([joint], stage.joint_side(record.amplitude / omega))
    start = stage.about(stage.rest, half_way) - half_way

    def evaluate(tau: Array) -> tuple[Array, Array, Array]:
        phase = omega * tau[:, None]
        return (
            start + half_way * (1 - np.cos(phase)),
            half_way * omega * np.sin(phase),
            half_way * omega**2 * np.cos(phase),
        )

    duration = periods / record.frequency
    label = f"{record.amplitude:g} rad/s at {record.frequency:g} Hz"
    segments = [
        standstill("rest 0", start, DWELL),
        Segment(label=label, kind="motion", duration=duration, evaluate=evaluate),
        standstill("rest 1", start, DWELL),
    ]
    name = f"{stage.robot.joints[joint]}.record_{record.number:02d}"
    return joint_reference(stage.robot, joint_path(name, segments, stage.dt))
