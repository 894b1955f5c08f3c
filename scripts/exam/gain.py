"""Gain of a diagnosis: its extended model predicts motions that it has not seen, under the same controller."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ffgym.diagnosis.extended import extend_machine
from ffgym.diagnosis.held_out import compare_in_closed_loop
from ffgym.diagnosis.result import Cause, FittedNumber
from ffgym.recordings import Recording
from ffgym.simulation.plant import Machine
from ffgym.simulation.protocols import Protocol
from ffgym.simulation.protocols.mixtures import Circles
from ffgym.simulation.protocols.together import Excitation
from scripts.exam.draw import Case
from scripts.exam.marks import Gain

_LATER = 1200.0
"""When the motions are made, since the machine was switched on [s]; chosen: soon after the session."""

_SEED = 5
"""Seed of the phases of the large motion, which no protocol of a diagnosis has."""


def gain_of(case: Case, causes: Sequence[Cause], numbers: Sequence[FittedNumber] = ()) -> Gain:
    """Gain by the causes of a diagnosis, and the numbers that were fitted beside them.

    Raises:
        FFGymError: if a cause does not fit the robot.
    """
    nominal = Machine(robot=case.robot, climate=case.machine.climate)
    extended = extend_machine(nominal, causes, numbers)
    found = compare_in_closed_loop(nominal, extended, _held_out(case, case.complete), n_threads=1)
    quiet = compare_in_closed_loop(nominal, nominal, _held_out(case, case.machine), n_threads=1)
    left = [(level.after / floor.before) ** 2 for level, floor in zip(found, quiet, strict=True)]
    axes = [level for level in found if level.quantity == "tool"]
    before, after = (float(np.sqrt(sum(getattr(axis, when) ** 2 for axis in axes))) for when in ("before", "after"))
    return Gain(leftover=max(left), before=before, after=after)


def _held_out(case: Case, machine: Machine) -> list[Recording]:
    protocols: list[Protocol] = [Excitation(count=1, periods=1, seed=_SEED)]  # a large motion of all joints
    if (area := case.robot.work_area) is not None:  # and before it small circles at another place
        protocols.insert(0, Circles(positions=(list(area.positions)[-1],), speeds=(0.030,)))
    bench = replace(case.bench, protocols=tuple(protocols), lacks=())
    seed = int(case.generator(2).integers(2**32))
    return bench.record(machine, seed=seed, current_offset=case.current_offset, start=_LATER)
