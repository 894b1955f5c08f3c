"""How a diagnosis is written and drawn for people, in the units that they read; as text for a terminal, as tables."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.held_out import LoopLevel
from ffgym.diagnosis.residual import UNITS, Channel, MotionResidual, Residual
from ffgym.diagnosis.result import Cause, Diagnosis, Level, Rival, Size, UnjudgedEffect
from ffgym.effects import EFFECTS
from ffgym.report.identification.plots import MEASURED, NEW, OLD
from ffgym.report.page import words_of
from ffgym.report.table import Column, Table, filled
from ffgym.robot import RobotDescription

VERDICTS = words_of("verdicts")
"""What each verdict means."""


def place_of(effect: str, joint: str) -> str:
    """An effect with its joint, e.g. 'load friction, j2'."""
    return effect.replace("_", " ") + (f", {joint}" if joint else "")


def title_of(effect: str) -> str:
    """What an effect is, in words; its name if the library does not know it."""
    return EFFECTS[effect].title if effect in EFFECTS else effect.replace("_", " ")


def size_text(size: Size) -> str:
    """A size with unit and interval."""
    unit = "" if size.unit == "1" else f" {size.unit}"
    low, high = size.interval
    return f"{size.name} = {size.value:.3g}{unit} ({low:.3g} to {high:.3g})"


def rivals_of(diagnosis: Diagnosis, cause: Cause) -> list[Rival]:
    """Rivals of a cause, ties first, then those that explain most; they name its effect, with or without its joint."""
    names = (cause.effect, f"{cause.effect} on {cause.joint}")
    own = [rival for rival in diagnosis.rivals if rival.against in names]
    return sorted(own, key=lambda rival: (not rival.tied, -rival.held_out_gain))


def together(unjudged: Sequence[UnjudgedEffect]) -> list[tuple[str, str]]:
    """Effects with their joints, and the reason; those that share a reason stand together."""
    joints: dict[tuple[str, str], list[str]] = {}
    for one in unjudged:
        joints.setdefault((one.reason, one.effect), []).append(one.joint)
    reasons: dict[str, list[str]] = {}
    for (reason, effect), places in joints.items():
        where = ", ".join(place for place in places if place)
        reasons.setdefault(reason, []).append(effect.replace("_", " ") + (f" ({where})" if where else ""))
    return [("; ".join(effects), reason) for reason, effects in reasons.items()]


NOMINAL, EXTENDED = "nominal model", "extended model"
"""What models are called in pictures."""

LOOKS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "measured": {"color": MEASURED, "linewidth": 2.2},
        NOMINAL: {"color": OLD, "linewidth": 1.1, "linestyle": "--"},
        EXTENDED: {"color": NEW, "linewidth": 1.1},
    }
)
"""How lines are drawn."""

FINE: Mapping[str, tuple[float, str]] = MappingProxyType(
    {"N m": (1.0, "N m"), "N": (1.0, "N"), "m": (1e6, "µm"), "rad": (1e6, "µrad")}
)
"""Factor and unit in which people read a residual of that unit."""


def by_model(before: Residual | None, after: Residual | None) -> dict[str, Residual]:
    """Residuals by the name of the model, of those that there are: the nominal one, and the extended one."""
    return {name: each for name, each in ((NOMINAL, before), (EXTENDED, after)) if each is not None}


def counting(motion: MotionResidual, values: Array) -> Array:
    """Values (R,) along a motion, NaN in rows that do not count."""
    return np.where(motion.valid, values, np.nan)


BEHIND = {
    "N m": ("N", 1),
    "N m/rad": ("N/m", 2),
    "N m s/rad": ("N s/m", 2),
    "N m/A": ("N/A", 1),
    "kg m^2": ("kg", 2),
    "rad": ("m", -1),
    "rad/s": ("m/s", -1),
}
"""Unit of a hinge or a motor -> unit of a sliding joint, and the power of the gear ratio [rad/m] that brings a number
of the motor behind the gearbox."""

_NUMBERS = ("measured", "noise_floor", "before", "after")
"""What a level holds in its unit."""


def scale_of(robot: RobotDescription, channel: Channel, joint: int) -> tuple[float, str]:
    """Factor and unit in which a quantity of a joint is shown."""
    return _behind(robot, joint, UNITS[channel], motor=channel != "link")


def fine_scale_of(robot: RobotDescription, channel: Channel, joint: int) -> tuple[float, str]:
    """Factor and unit in which people read a residual of a joint."""
    factor, unit = scale_of(robot, channel, joint)
    fine, named = FINE[unit]
    return factor * fine, named


def in_joint_units(diagnosis: Diagnosis, robot: RobotDescription | None) -> Diagnosis:
    """The diagnosis with sizes and levels of sliding joints behind the gearbox; as it is without one."""
    if robot is None or not robot.kinematics.is_sliding.any():
        return diagnosis
    causes = []
    for cause in diagnosis.causes:
        sizes = cause.parameters
        if cause.joint in robot.joints and cause.effect in EFFECTS:
            joint, motor = robot.joints.index(cause.joint), EFFECTS[cause.effect].side == "motor"
            sizes = tuple(_size(size, *_behind(robot, joint, size.unit, motor=motor)) for size in sizes)
        causes.append(replace(cause, parameters=sizes))
    levels = []
    for level in diagnosis.levels:
        if level.component in robot.joints:
            joint = robot.joints.index(level.component)
            factor, unit = _behind(robot, joint, level.unit, motor=level.channel != "link")
            numbers: dict[str, Any] = {name: factor * getattr(level, name) for name in _NUMBERS}
            levels.append(replace(level, unit=unit, **numbers))
        else:
            levels.append(level)
    return replace(diagnosis, causes=tuple(causes), levels=tuple(levels))


def _size(size: Size, factor: float, unit: str) -> Size:
    low, high = sorted(factor * end for end in size.interval)
    return replace(size, value=factor * size.value, unit=unit, interval=(low, high))


def _behind(robot: RobotDescription, joint: int, unit: str, *, motor: bool) -> tuple[float, str]:
    """Factor and unit behind the gearbox of a number of a sliding joint; 1 and the unit as it is for all others."""
    if not robot.kinematics.is_sliding[joint] or unit not in BEHIND:
        return 1.0, unit
    named, power = BEHIND[unit]
    return (abs(float(robot.drive.gear_ratio[joint])) ** power if motor else 1.0), named


def format_diagnosis(diagnosis: Diagnosis, robot: RobotDescription | None = None) -> str:
    """Verdict, causes with sizes, ties, patterns, what is left, what was not judged, what to record next.

    Args:
        diagnosis: what was found.
        robot: on which; sizes of its sliding joints are then told behind the gearbox.
    """
    diagnosis = in_joint_units(diagnosis, robot)
    parts = [format_findings(diagnosis)]
    ties = [rival for rival in diagnosis.rivals if rival.tied]
    parts += [filled(f"cannot be excluded: {place_of(tie.effect, tie.joint)}: {tie.reason}") for tie in ties]
    parts += [filled(f"between recordings: {drift.message}") for drift in diagnosis.drifts]
    for pattern in diagnosis.patterns:
        parts += [filled(f"pattern: {pattern.message}"), *(filled(f"  no cause: {lead}") for lead in pattern.leads)]
    if diagnosis.levels:
        table = levels_table(diagnosis).text().replace("not small", "NOT SMALL")  # what is wrong stands out
        parts += ["", table, ""]
    for word, unjudged in (("not excited", diagnosis.not_excited), ("not judgeable", diagnosis.not_judgeable)):
        parts += [filled(f"{word}: {effects}: {reason}") for effects, reason in together(unjudged)]
    parts += [filled(f"log: {line}") for line in diagnosis.quality]
    if diagnosis.separating_motion is not None:
        first, second = diagnosis.separating_motion.between
        protocol = diagnosis.separating_motion.protocol
        parts.append(filled(f"record next: {protocol}, to tell {first} from {second}"))
    return "\n".join(parts)


def format_findings(diagnosis: Diagnosis) -> str:
    """The verdict in one sentence, and the causes with their sizes."""
    parts = [filled(f"{diagnosis.verdict}: {diagnosis.sentence}")]
    parts += [filled(f"wiring: {mistake.message}") for mistake in diagnosis.wiring]
    for cause in diagnosis.causes:
        where = f" of {cause.joint}" if cause.joint else ""
        sizes = "; ".join(size_text(size) for size in cause.parameters)
        gain = f"explains {cause.held_out_gain:.0%} on motions that were not used"
        parts.append(filled(f"cause: {title_of(cause.effect)}{where} ({cause.code}): {sizes}; {gain}"))
    return "\n".join(parts)


def levels_table(diagnosis: Diagnosis) -> Table:
    """What is left, joint by joint, in the units in which people read it, and whether that is small."""
    levels = diagnosis.levels
    numbers = {"measured": "measured", "noise": "noise_floor", NOMINAL: "before"}
    numbers |= {EXTENDED: "after"} if diagnosis.causes else {}
    columns = _columns("RMS of", levels, [level.channel for level in levels], numbers)
    columns.append(Column("left", [diagnosis.tell_left(level) for level in levels], kind="text"))
    return Table(columns=columns, name="levels", fixed=2, ruled_by=0)


def compared_table(heading: str, levels: Sequence[LoopLevel], name: str = "") -> Table:
    """What was measured, and what both models leave of it."""
    numbers = {"measured": "measured", NOMINAL: "before", EXTENDED: "after"}
    columns = _columns(heading, levels, [level.quantity for level in levels], numbers)
    return Table(columns=columns, name=name, fixed=2, ruled_by=0)


def _columns(
    heading: str, levels: Sequence[Level] | Sequence[LoopLevel], quantities: Sequence[str], numbers: Mapping[str, str]
) -> list[Column]:
    """Quantity, place and unit of each level, and numbers of it by their headings."""
    scale = [FINE[level.unit] for level in levels]
    columns = [
        Column(heading, quantities, kind="text"),
        Column("where", [level.component for level in levels], kind="name"),
        Column("unit", [unit for _, unit in scale], kind="text"),
    ]
    for title, name in numbers.items():
        values = [factor * getattr(level, name) for level, (factor, _) in zip(levels, scale, strict=True)]
        columns.append(Column(title, values, ".3g"))
    return columns
