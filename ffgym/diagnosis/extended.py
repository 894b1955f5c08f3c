"""The extended model: the nominal machine with causes and fitted numbers in it, and the machine file of both."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array
from ffgym.diagnosis.result import Cause, Diagnosis, FittedNumber
from ffgym.effects import EFFECTS, Effect, Origin, Parameter
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription
from ffgym.robot.reading.load import GROUPS
from ffgym.robot.reading.quantity import si_units
from ffgym.robot.reading.rules import RULES
from ffgym.simulation.plant import Climate, Machine, save_machine

_EFFECT = "effects"
"""First word of an entry that is a parameter of an effect."""


def list_fitted_numbers(nominal: Machine, fitted: Machine) -> tuple[FittedNumber, ...]:
    """List the numbers in which a fitted machine differs from the nominal one."""
    found = []
    for path, rule in RULES.items():
        before, after = _read_entry(nominal.robot, path), _read_entry(fitted.robot, path)
        if before is not None and after is not None and not np.array_equal(before, after):
            units = si_units(rule, rule.side, nominal.robot.kinematics.types)
            found.append(_compare_number(path, ", ".join(dict.fromkeys(units)), before, after))
    for effect in fitted.effects[len(nominal.effects) :]:
        for name, p in effect.parameters().items():
            value = getattr(effect, name)
            if p.null is not None and np.any(value != p.null):
                found.append(
                    _compare_number(f"{_EFFECT}.{effect.name}.{name}", p.unit, np.full_like(value, p.null), value)
                )
    return tuple(found)


def apply_numbers(nominal: Machine, numbers: Sequence[FittedNumber]) -> Machine:
    """Apply fitted numbers to the nominal machine; effects of sensors stand behind those that it has.

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
            parts.setdefault(GROUPS.get(group, ""), {})[name] = _shape_value(robot, number)
    changed = {part: replace(getattr(robot, part), **values) for part, values in parts.items()}
    robot = replace(robot, **changed)  # entries of one part only fit together
    beside = [_build_effect(kind, values, robot) for kind, values in effects.items()]
    return replace(nominal, robot=robot, effects=(*nominal.effects, *beside))


def _compare_number(entry: str, unit: str, before: Array, after: Array) -> FittedNumber:
    return FittedNumber(
        entry=entry, unit=unit, before=tuple(before.ravel().tolist()), after=tuple(after.ravel().tolist())
    )


def _read_entry(robot: RobotDescription, path: str) -> Array | None:
    """Read the numbers of one entry; None if it cannot be fitted, or the robot lacks it."""
    group, _, name = path.partition(".")
    part = getattr(robot, GROUPS[group]) if group in GROUPS else None
    value = None if part is None else getattr(part, name, None)
    return None if value is None else np.asarray(value, dtype=np.float64)


def _shape_value(robot: RobotDescription, number: FittedNumber) -> Array | float:
    """Shape the values of a number as its entry."""
    before = _read_entry(robot, number.entry)
    if before is None or before.size != len(number.after):
        raise FFGymError(
            f"Number {number.entry!r} of a diagnosis has {len(number.after)} values, which robot {robot.name!r} has no "
            f"place for. Use the description that was diagnosed."
        )
    value = np.array(number.after).reshape(before.shape)
    return value if value.ndim else float(value)


def _build_effect(name: str, values: dict[str, Array], robot: RobotDescription) -> Effect:
    kind = EFFECTS[check_choice("effect of a number", name, list(EFFECTS))]
    known = kind.parameters()
    full = {p: np.full(one.shape(robot.n_joints), one.neutral) for p, one in known.items() if one.null is not None}
    for parameter, value in values.items():
        check_choice(f"parameter of {name}", parameter, list(full))
        full[parameter] = value.reshape(full[parameter].shape)
    return kind(**full)


_NAMED = 4
"""Motions that a source names."""

_AT_ONCE = 1e-3
"""Time constant of a climate that does not change [s]: below any sample time."""


def extend_machine(nominal: Machine, causes: Sequence[Cause], numbers: Sequence[FittedNumber] = ()) -> Machine:
    """Extend the nominal machine by numbers that were fitted beside causes, and by the effects of the causes.

    Raises:
        FFGymError: if a cause names an unknown effect, joint or parameter, or the robot cannot have the effect.
    """
    machine = apply_numbers(nominal, numbers)
    effects = [build_effect(cause, nominal.robot) for cause in causes]
    return replace(machine, effects=(*machine.effects, *effects))


def build_effect(cause: Cause, robot: RobotDescription) -> Effect:
    """Build the effect of a cause, on its joint alone.

    Raises:
        FFGymError: if it names an unknown effect, joint or parameter, or lacks one.
    """
    kind = EFFECTS[check_choice("effect of a cause", cause.effect, list(EFFECTS))]
    known = kind.parameters()
    values: dict[str, Any] = {name: np.full(p.shape(robot.n_joints), p.neutral) for name, p in known.items()}
    given = {size.name: size.value for size in cause.parameters} | cause.fixed
    for name, value in given.items():
        parameter, place = _locate(name, cause, known, robot)
        values[parameter][place] = value
    said = {name.partition(".")[0] for name in given}
    if missing := [name for name, p in known.items() if p.null is not None and name not in said]:
        raise FFGymError(f"Cause {cause.effect} on {cause.joint or 'the machine'} does not say {', '.join(missing)}.")
    return kind(**values)


def save_extended(
    path: str | Path,
    diagnosis: Diagnosis,
    nominal: Machine,
    *,
    robot: str | Path | None = None,
    origins: Sequence[Origin] = (),
    recordings: Sequence[Recording] = (),
) -> Machine:
    """Write the nominal machine with the causes of a diagnosis as a machine file, and return it.

    Every number says what it was diagnosed from, its interval, and that it was nothing before; numbers that the nominal
    machine had keep what was said of them.

    Args:
        path: ends in .toml.
        diagnosis: its causes are added; one without any gives the nominal machine.
        nominal: the model that was diagnosed.
        robot: what the file calls the robot: a built-in name, or the path of its description; None is its own name.
        origins: where the numbers of the nominal machine's effects come from.
        recordings: that were diagnosed; a machine of which no climate is known is as warm as they say, if they do.

    Raises:
        FFGymError: if a cause does not fit the robot, or the file cannot be written.
    """
    machine = extend_machine(nominal, diagnosis.causes, diagnosis.numbers)
    if machine.climate is None:
        machine = replace(machine, climate=derive_climate(recordings))
    # origins: those of the nominal effects, none of fitted numbers, and the diagnosis for the causes
    beside = len(machine.effects) - len(diagnosis.causes)
    known = [*origins, *(Origin() for _ in range(beside - len(origins)))]
    new = [_describe_origin(cause, nominal.robot, diagnosis) for cause in diagnosis.causes]
    save_machine(
        machine,
        path,
        title=f"{nominal.robot.title}, extended by ffgym diagnose",
        source=f"fitted beside the causes to {_name_logs(diagnosis)}"
        if diagnosis.numbers
        else "as before the diagnosis",
        robot=robot,
        origins=[*known, *new],
    )
    return machine


def derive_climate(recordings: Sequence[Recording]) -> Climate | None:
    """Derive a climate in which each joint keeps its mean temperature; None if recordings have no temperatures."""
    told = [recording.joint_array("temperature") for recording in recordings if recording.has("temperature")]
    columns = np.concatenate(told) if told else np.full((1, 1), np.nan)
    if np.isnan(columns).all(axis=0).any():
        return None
    means = np.nanmean(columns, axis=0)
    ambient = float(means.min())
    return Climate(ambient=ambient, rise=means - ambient, time_constant=_AT_ONCE)


def _locate(name: str, cause: Cause, known: Any, robot: RobotDescription) -> tuple[str, Any]:
    """Locate a number by parameter and index; its name may end with a dot and an axis, or the other joint of a pair.

    A vector without an axis is all of it: one that stayed where it was.
    """
    parameter, _, part = name.partition(".")
    p: Parameter = known[check_choice(f"parameter of {cause.effect}", parameter, list(known))]
    if p.per == "machine":
        return parameter, ()
    if p.per == "vector":
        axes = ("x", "y", "z")
        return parameter, axes.index(check_choice(f"axis of {cause.effect}.{parameter}", part, axes)) if part else ...
    check_choice(f"joint of cause {cause.effect}", cause.joint, robot.joints)
    joint = robot.joints.index(cause.joint)
    if p.per == "joint":
        return parameter, joint
    check_choice(f"other joint of {cause.effect}.{parameter}", part, robot.joints)
    return parameter, (joint, robot.joints.index(part))


def _describe_origin(cause: Cause, robot: RobotDescription, diagnosis: Diagnosis) -> Origin:
    """Describe the origin and the interval of each number of a cause, for its table in the machine file."""
    kind = EFFECTS[cause.effect]
    effect, where = build_effect(cause, robot), f" on {cause.joint}" if cause.joint else ""
    logs, sources, intervals = _name_logs(diagnosis), dict[str, str](), dict[str, Any]()
    for name, known in kind.parameters().items():
        sizes = [size for size in cause.parameters if size.name.partition(".")[0] == name]
        if not sizes:
            sources[name] = f"chosen by the diagnosis{where}"
            continue
        before = "" if known.null is None else f"; before {known.null:g}"
        sources[name] = f"diagnosed{where} from {logs}; 90 % interval{before}"
        # numbers that were not diagnosed are as sure as they were said
        ends = np.stack([getattr(effect, name)] * 2, axis=-1)
        for size in sizes:
            ends[_locate(size.name, cause, kind.parameters(), robot)[1]] = size.interval
        intervals[name] = ends
    return Origin(label=cause.joint, sources=sources, intervals=intervals)


def _name_logs(diagnosis: Diagnosis) -> str:
    """Name the motions of a diagnosis, the first few of many."""
    more = f" and {len(diagnosis.motions) - _NAMED} more" if len(diagnosis.motions) > _NAMED else ""
    return ", ".join(diagnosis.motions[:_NAMED]) + more
