"""What a diagnosis is good for: its extended model predicts motions that it has not seen, under the same controller."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.diagnosis.closed_loop import LoopLevel, closed_loop_gain
from ffgym.diagnosis.extended import extended_machine
from ffgym.diagnosis.result import Cause, Number
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Machine
from ffgym.simulation.protocols import Protocol
from ffgym.simulation.protocols.circles import Circles
from ffgym.simulation.protocols.excitation import Excitation
from scripts.exam.case import Case
from scripts.exam.recording import recorded

_LATER = 1200.0
"""When the motions are made, since the machine was switched on [s]; chosen: soon after the session."""

_SEED = 5
"""Of the phases of the large motion, which no protocol of a diagnosis has."""


@final
@dataclass(frozen=True, kw_only=True)
class Gain:
    """What simulation and machine differ by, in full closed loop, on two motions that were not diagnosed."""

    leftover: float
    """Energy with the causes, over that of noise and calibration without anything hidden; worst joint or axis."""
    before: float
    """RMS distance of the tool between the machine and its nominal model [m]."""
    after: float
    """The same with the causes."""


def gain_of(case: Case, causes: Sequence[Cause], numbers: Sequence[Number] = ()) -> Gain:
    """Gain by the causes of a diagnosis, and the numbers that were fitted beside them.

    Raises:
        FFGymError: if a cause does not fit the robot.
    """
    nominal = Machine(robot=case.arm.robot, climate=case.machine.climate)
    extended = extended_machine(nominal, causes, numbers)
    found = closed_loop_gain(nominal, extended, _held_out(case, case.complete), n_threads=1)
    quiet = closed_loop_gain(nominal, nominal, _held_out(case, case.machine), n_threads=1)
    left = [(level.after / floor.before) ** 2 for level, floor in zip(found, quiet, strict=True)]
    return Gain(leftover=max(left), before=_tool(found, "before"), after=_tool(found, "after"))


def _held_out(case: Case, machine: Machine) -> list[Recording]:
    protocols = _protocols(case.arm.robot)
    seed = int(case.generator(2).integers(2**32))
    return recorded(case.arm, machine, protocols, seed=seed, current_offset=case.current_offset, start=_LATER)


def _protocols(robot: RobotDescription) -> list[Protocol]:
    """Small circles at another place, if the robot has such places, and a large motion of all joints."""
    large: Protocol = Excitation(count=1, periods=1, seed=_SEED)
    if robot.work_area is None:
        return [large]
    return [Circles(positions=(list(robot.work_area.positions)[-1],), speeds=(0.030,)), large]


def _tool(levels: Sequence[LoopLevel], when: str) -> float:
    return float(np.sqrt(sum(getattr(level, when) ** 2 for level in levels if level.quantity == "tool")))
