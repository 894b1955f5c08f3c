"""Numbers that were fitted beside causes, as a diagnosis tells them: entries of descriptions, effects of sensors."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array
from ffgym.diagnosis.result import Number
from ffgym.effects import EFFECTS, Effect
from ffgym.robot import RobotDescription
from ffgym.robot.reading.load import GROUPS
from ffgym.robot.reading.quantity import JointFrame, si_units
from ffgym.robot.reading.rules import RULES
from ffgym.simulation.plant import Machine

_EFFECT = "effects"
"""First word of an entry that is a parameter of an effect."""


def fitted_numbers(nominal: Machine, fitted: Machine) -> tuple[Number, ...]:
    """In what a machine with fitted numbers differs from the nominal one."""
    joints = JointFrame(types=nominal.robot.kinematics.types, gear_ratio=nominal.robot.drive.gear_ratio)
    found = []
    for path, rule in RULES.items():
        before, after = _entry(nominal.robot, path), _entry(fitted.robot, path)
        if before is not None and after is not None and not np.array_equal(before, after):
            units = si_units(rule, rule.side, joints)
            found.append(_number(path, ", ".join(dict.fromkeys(units)), before, after))
    for effect in fitted.effects[len(nominal.effects) :]:
        for name, p in effect.parameters().items():
            value = getattr(effect, name)
            if p.null is not None and np.any(value != p.null):
                found.append(_number(f"{_EFFECT}.{effect.name}.{name}", p.unit, np.full_like(value, p.null), value))
    return tuple(found)


def with_fitted_numbers(nominal: Machine, numbers: Sequence[Number]) -> Machine:
    """The nominal machine with fitted numbers; effects of sensors stand behind those that it has.

    Raises:
        FFGymError: if an entry is unknown, or has another number of values.
    """
    robot, parts, effects = nominal.robot, dict[str, dict[str, Any]](), dict[str, dict[str, Array]]()
    for number in numbers:
        group, _, name = number.entry.partition(".")
        if group == _EFFECT:
            kind, _, parameter = name.partition(".")
            effects.setdefault(kind, {})[parameter] = np.array(number.after)
        else:
            parts.setdefault(GROUPS.get(group, ""), {})[name] = _value(robot, number)
    changed = {part: replace(getattr(robot, part), **values) for part, values in parts.items()}
    robot = replace(robot, **changed)  # entries of one part only fit together
    beside = [_effect(kind, values, robot) for kind, values in effects.items()]
    return replace(nominal, robot=robot, effects=(*nominal.effects, *beside))


def _number(entry: str, unit: str, before: Array, after: Array) -> Number:
    return Number(entry=entry, unit=unit, before=tuple(before.ravel().tolist()), after=tuple(after.ravel().tolist()))


def _entry(robot: RobotDescription, path: str) -> Array | None:
    """Numbers of one entry that can be fitted; None if it cannot, or the robot has none."""
    group, _, name = path.partition(".")
    part = getattr(robot, GROUPS[group]) if group in GROUPS else None
    value = None if part is None else getattr(part, name, None)
    return None if value is None else np.asarray(value, dtype=np.float64)


def _value(robot: RobotDescription, number: Number) -> Array | float:
    """Values of a number in the shape that its entry has."""
    before = _entry(robot, number.entry)
    if before is None or before.size != len(number.after):
        raise FFGymError(
            f"Number {number.entry!r} of a diagnosis has {len(number.after)} values, which robot {robot.name!r} has no "
            f"place for. Use the description that was diagnosed."
        )
    value = np.array(number.after).reshape(before.shape)
    return value if value.ndim else float(value)


def _effect(name: str, values: dict[str, Array], robot: RobotDescription) -> Effect:
    kind = EFFECTS[check_choice("effect of a number", name, list(EFFECTS))]
    known = kind.parameters()
    full = {p: np.full(one.shape(robot.n_joints), one.neutral) for p, one in known.items() if one.null is not None}
    for parameter, value in values.items():
        check_choice(f"parameter of {name}", parameter, list(full))
        full[parameter] = value.reshape(full[parameter].shape)
    return kind(**full)
