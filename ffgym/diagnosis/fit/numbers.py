"""Numbers of a model that were fitted beside causes, put into the model: what is measured is then what is written."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.calibration import Doubt
from ffgym.diagnosis.fit.setting import Setting
from ffgym.effects import ClockEffect, Effect, NativeEffect
from ffgym.effects.friction.stribeck import StribeckPeak
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Machine

_ROUNDING = 1e-12
"""By which a breakaway torque is more than the Coulomb torque at least, as a share of it: sums are rounded."""


def are_of_the_machine(doubts: Sequence[Doubt]) -> BoolArray:
    """Tell calibration errors of the machine from those of how rows were written, shape (len(doubts),)."""
    return np.array([not issubclass(doubt.column.effect, ClockEffect) for doubt in doubts], dtype=np.bool_)


def with_numbers(nominal: Machine, doubts: Sequence[Doubt], sizes: Array) -> Machine:
    """The nominal machine with its calibration errors corrected.

    Args:
        nominal: the machine whose numbers they are.
        doubts: what is open of it.
        sizes: in standard deviations, shape (len(doubts),); 0 for those that are not of the machine.
    """
    robot, beside = nominal.robot, list[Effect]()
    for effect in _effects(nominal, doubts, sizes):
        if effect.is_null:
            continue
        if isinstance(effect, StribeckPeak):
            effect = _not_below_coulomb(effect, robot)
        if isinstance(effect, NativeEffect):
            robot = effect.in_description(robot)
        else:
            beside.append(effect)
    return replace(nominal, robot=robot, effects=(*nominal.effects, *beside))


def possible_numbers(setting: Setting, sizes: Array) -> Machine | None:
    """The machine with its numbers corrected; None if none can be so."""
    try:
        machine = with_numbers(setting.nominal, setting.doubts, sizes)
        _ = machine.physical
    except FFGymError:
        return None
    return machine


def _not_below_coulomb(peak: StribeckPeak, robot: RobotDescription) -> StribeckPeak:
    """A breakaway torque that is less by as much as it may be: it is no less than the Coulomb torque."""
    friction = robot.friction
    return replace(peak, level=np.maximum(peak.level, (1 + _ROUNDING) - friction.static / friction.coulomb))


def _effects(nominal: Machine, doubts: Sequence[Doubt], sizes: Array) -> list[Effect]:
    """Calibration errors as effects, one of each kind with the numbers of all its joints."""
    n, values = nominal.robot.n_joints, dict[type[Effect], dict[str, Array]]()
    for doubt, size in zip(doubts, sizes.tolist(), strict=True):
        column, known = doubt.column, doubt.column.effect.parameters()
        own = values.setdefault(
            column.effect, {name: np.full(p.shape(n), p.neutral) for name, p in known.items() if p.null is not None}
        )
        place = _place(doubt, nominal)
        own[column.parameter][place] += size * doubt.sigma
    return [kind(**own) for kind, own in values.items()]


def _place(doubt: Doubt, nominal: Machine) -> int | tuple[()]:
    """Where the number of a column stands among those of its parameter."""
    column = doubt.column
    if column.joint:
        return nominal.robot.joints.index(column.joint)
    return () if column.part is None else column.part
