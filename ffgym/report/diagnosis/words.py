"""Texts, tables, units and line styles by which a diagnosis is shown to people, on a page and in a terminal."""

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from textwrap import wrap
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.held_out import LoopLevel
from ffgym.diagnosis.held_out_share import compute_held_out_share
from ffgym.diagnosis.residual import UNITS, Channel, MotionResidual, Residual
from ffgym.diagnosis.result import Cause, Diagnosis, Level, Rival, Size, UnjudgedEffect, make_label
from ffgym.effects import EFFECTS
from ffgym.report.identification.plots import MEASURED, NEW, OLD
from ffgym.report.page import resource, words_of
from ffgym.report.table import WIDTH, Cell, Column, Kind, Table, wrap_text
from ffgym.robot import RobotDescription

VERDICTS = words_of("verdicts")
"""Meaning of each verdict."""


def place_of(effect: str, joint: str) -> str:
    """An effect with its joint, e.g. 'load friction, j2'."""
    return effect.replace("_", " ") + (f", {joint}" if joint else "")


def shown_share(gain: float) -> float:
    """Limit an explained share to 0 to 1: fits may take noise away, and the floor is an estimate."""
    return min(max(gain, 0.0), 1.0)


def title_of(effect: str) -> str:
    """Name an effect in words; by its name in the code if the library does not know it."""
    return EFFECTS[effect].title if effect in EFFECTS else effect.replace("_", " ")


def first_sentence(text: str) -> str:
    """Cut a docstring or a phrase after its first sentence, without the full stop, on one line."""
    return re.split(r"\. (?=[A-Z])", " ".join(text.split()), maxsplit=1)[0].removesuffix(".")


def in_words(label: str) -> str:
    """Write the label of an effect with its title, e.g. 'load-dependent friction on j2'."""
    effect, _, joint = label.partition(" on ")
    return make_label(title_of(effect), joint)


VERDICT_LINES = 3
"""Lines of a terminal that the sentence of a verdict may fill."""

_MORE = ", and more that is listed below."


def short_sentence(diagnosis: Diagnosis) -> str:
    """Cut the sentence of a verdict at the end of a clause, so that it fills at most three lines of a terminal."""
    whole = diagnosis.sentence
    room = VERDICT_LINES * WIDTH - len(diagnosis.verdict) - 2 - len(_MORE)
    if len(wrap(f"{diagnosis.verdict}: {whole}", WIDTH)) <= VERDICT_LINES:
        return whole
    ends = [found.start() for found in re.finditer(r"[;,.] | or ", whole) if found.start() <= 0.95 * room]
    end = ends[-1] if ends else whole.rfind(" ", 0, int(0.95 * room))
    return whole[:end] + _MORE


@cache
def _size_words() -> Mapping[str, Mapping[str, str]]:
    """Plain meaning of each size by effect and parameter, see sizes.toml."""
    texts: dict[str, dict[str, str]] = tomllib.loads(resource("sizes.toml"))
    return MappingProxyType(texts)


_READ_AS: Mapping[str, tuple[float, str]] = MappingProxyType({"rad": (1e3, "mrad"), "m": (1e3, "mm"), "s": (1e3, "ms")})
"""Factor and unit in which people read a size of that unit."""


def plain_size(effect: str, size: Size) -> tuple[str, str]:
    """Write a size with unit and plain meaning, e.g. '3.5 % of the torque that the gearbox carries', and its interval.

    Args:
        effect: name of the effect that the size is of.
        size: value, unit and interval; its name may end in a dot with the axis or the other joint.
    """
    name, _, part = size.name.partition(".")
    words = _size_words().get(effect, {}).get(name)
    if words is None:  # an effect of another package, in the words of its declaration
        of = EFFECTS[effect].parameters().get(name) if effect in EFFECTS else None
        meaning = "" if of is None else f" ({first_sentence(of.meaning)})"
        words = "{value} " + f"{name}{meaning}".replace("{", "{{").replace("}", "}}")
    factor, unit = _READ_AS.get(size.unit, (1.0, "" if size.unit == "1" else size.unit))
    if "{percent}" in words:
        factor, unit = 100.0, "%"
    shown = f"{factor * size.value:.3g} {unit}".strip()
    low, high = (f"{factor * end:.3g}" for end in size.interval)
    text = words.format(value=shown, percent=shown) + (f" ({part})" if part else "")
    return text, f"{low} to {high} {unit}".strip()


def causes_table(diagnosis: Diagnosis, *, on_page: bool = False) -> Table:
    """Table of causes: joint, cause, size, interval, share explained on motions that were left out, rivals.

    Effects that tie with a cause, or with each other, are not adopted; they stand below the causes, without a size.
    """
    rows: list[tuple[Any, ...]] = []
    for cause in diagnosis.causes:
        held_out = compute_held_out_share(diagnosis.levels, [cause.joint])
        share = None if held_out is None else Cell(f"{100 * held_out.share:.0f} %", f"({held_out.channel})")
        rivals = _name_rivals(rivals_of(diagnosis, cause), on_page=on_page)
        first = (cause.joint or "machine", title_of(cause.effect), share, rivals)
        sizes = [plain_size(cause.effect, size) for size in cause.parameters] or [("present", "-")]
        for k, (size, interval) in enumerate(sizes):
            joint, title, explained, against = first if k == 0 else ("", "", "", "")
            rows.append((joint, title, size, interval, explained, against))
    # effects that were not adopted as a tie left it open, each once
    adopted = {(cause.effect, cause.joint) for cause in diagnosis.causes}
    ties: dict[tuple[str, str], list[str]] = {}
    for rival in diagnosis.rivals:
        if rival.tied and (rival.effect, rival.joint) not in adopted:
            ties.setdefault((rival.effect, rival.joint), []).append(in_words(rival.against))
    for (effect, joint), against_them in ties.items():
        first_of, *others = dict.fromkeys(against_them)
        behind = f" and {' and '.join(others) if on_page else f'{len(others)} more'}" if others else ""
        against = f"ties with {first_of}{behind}"
        rows.append((joint or "machine", title_of(effect), "not adopted", None, None, against))
    headings = ("joint", "cause", "size", "90 % interval", "held out", "rivals")
    kinds: tuple[Kind, ...] = ("text", "text", "prose", "text", "text", "prose") if on_page else ("text",) * 6
    columns = [
        Column(heading, [row[k] for row in rows], kind=kind)
        for k, (heading, kind) in enumerate(zip(headings, kinds, strict=True))
    ]
    return Table(columns=columns, name="causes", fixed=2)


def _name_rivals(rivals: Sequence[Rival], *, on_page: bool) -> str:
    """Name rivals of a cause that tie, and the nearest that lost; in a terminal count them."""
    own = {(rival.effect, rival.joint): rival for rival in reversed(rivals)}  # one of several waves may tie
    ties, lost = [
        [make_label(title_of(effect), joint) for (effect, joint), rival in reversed(own.items()) if rival.tied == tied]
        for tied in (True, False)
    ]
    if not on_page:
        counts = [f"{len(names)} {word}" for word, names in (("tied", ties), ("lost", lost)) if names]
        return ", ".join(counts) or "none"
    parts = [f"tied: {', '.join(ties)}"] if ties else []
    if lost:
        parts.append(f"lost: {lost[0]}" + (f" and {len(lost) - 1} more" if lost[1:] else ""))
    return "; ".join(parts) or "none"


def held_out_note(diagnosis: Diagnosis) -> str:
    """Say how the share in the column 'held out' was computed, or why there is none."""
    words = words_of("diagnosis")
    if compute_held_out_share(diagnosis.levels, [cause.joint for cause in diagnosis.causes]) is None:
        return words["no_held_out"]
    return words["held_out_share" if len(diagnosis.motions) > 1 else "held_out_halves"]


def simulation_note(commands: Sequence[str]) -> str:
    """Warn that commands which record simulate, so that their logs are not those of the machine; empty without any."""
    records = any(command.startswith("ffgym record ") and " --out " in command for command in commands)
    return words_of("diagnosis")["simulated"] if records else ""


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
"""Names of models in pictures."""

LOOKS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "measured": {"color": MEASURED, "linewidth": 2.2},
        NOMINAL: {"color": OLD, "linewidth": 1.1, "linestyle": "--"},
        EXTENDED: {"color": NEW, "linewidth": 1.1},
    }
)
"""Styles of lines."""

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
"""Fields of a level in its unit."""


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
    """Write verdict, causes, ties, patterns, residuals, effects that were not judged, and the next motions.

    Args:
        diagnosis: result to write.
        robot: robot of the logs; sizes of its sliding joints are then written behind the gearbox.
    """
    diagnosis = in_joint_units(diagnosis, robot)
    parts = [format_findings(diagnosis)]
    ties = [
        f"cannot be excluded: {place_of(tie.effect, tie.joint)} instead of {place_of(tie.against, '')}: {tie.reason}"
        for tie in diagnosis.rivals
        if tie.tied
    ]
    parts += map(wrap_text, dict.fromkeys(ties))  # several waves of a cause may have the same rival
    parts += [wrap_text(f"between recordings: {drift.message}") for drift in diagnosis.drifts]
    for pattern in diagnosis.patterns:
        parts += [
            wrap_text(f"pattern: {pattern.message}"),
            *(wrap_text(f"  not a cause: {lead}") for lead in pattern.leads),
        ]
    if diagnosis.levels:
        table = levels_table(diagnosis).text().replace("not small", "NOT SMALL")  # what is wrong stands out
        parts += ["", table, ""]
    for word, unjudged in (("not excited", diagnosis.not_excited), ("not judgeable", diagnosis.not_judgeable)):
        parts += [wrap_text(f"{word}: {effects}: {reason}") for effects, reason in together(unjudged)]
    parts += [wrap_text(f"log: {line}") for line in diagnosis.quality]
    if diagnosis.separating_motion is not None:
        first, second = diagnosis.separating_motion.between
        protocol = diagnosis.separating_motion.protocol
        parts.append(wrap_text(f"record next: {protocol}, to tell {first} from {second}"))
    return "\n".join(parts)


def format_findings(diagnosis: Diagnosis) -> str:
    """Write the verdict in at most three lines, wiring mistakes, and the causes in a table with how to read it."""
    parts = [wrap_text(f"{diagnosis.verdict}: {short_sentence(diagnosis)}")]
    parts += [wrap_text(f"wiring: {mistake.message}") for mistake in diagnosis.wiring]
    if diagnosis.causes:
        parts += ["", causes_table(diagnosis).text(), wrap_text(held_out_note(diagnosis))]
    return "\n".join(parts)


def levels_table(diagnosis: Diagnosis) -> Table:
    """List the residual, joint by joint, in the units in which people read it, and whether it is small."""
    levels = diagnosis.levels
    numbers = {"measured": "measured", "noise": "noise_floor", NOMINAL: "before"}
    numbers |= {EXTENDED: "after"} if diagnosis.causes else {}
    columns = _columns("RMS of", levels, [level.channel for level in levels], numbers)
    columns.append(Column("left", [diagnosis.tell_left(level) for level in levels], kind="text"))
    return Table(columns=columns, name="levels", fixed=2, ruled_by=0)


def compare_levels(heading: str, levels: Sequence[LoopLevel], name: str = "") -> Table:
    """Compare the measurement with what both models leave of it."""
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
        columns.append(Column(title, [write_digits(value) for value in values]))
    return columns


def write_digits(value: float) -> str:
    """Write a number with three digits; large ones without an exponent."""
    text = f"{value:.3g}"
    return f"{float(text):.0f}" if "e+" in text else text
