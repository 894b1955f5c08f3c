"""A diagnosis as plain text for a terminal, and its tables, which a page has too."""

from collections.abc import Mapping, Sequence

from ffgym.diagnosis.held_out import LoopLevel
from ffgym.diagnosis.result import Diagnosis, Level
from ffgym.report.diagnosis.words import (
    EXTENDED,
    FINE,
    NOMINAL,
    in_joint_units,
    place_of,
    size_text,
    title_of,
    together,
)
from ffgym.report.table import Column, Table, filled
from ffgym.robot import RobotDescription


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
