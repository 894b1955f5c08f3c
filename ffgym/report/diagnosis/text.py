"""A diagnosis as plain text for a terminal, at most 120 columns wide."""

from collections.abc import Sequence

from ffgym.diagnosis.held_out import LoopLevel
from ffgym.diagnosis.result import Diagnosis
from ffgym.report.circles.tables import Column, aligned, filled, shortened
from ffgym.report.diagnosis.joint_units import in_joint_units
from ffgym.report.diagnosis.models import FINE
from ffgym.report.diagnosis.words import place_of, size_text, title_of, together
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
        parts += ["", _levels(diagnosis), ""]
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


def _levels(diagnosis: Diagnosis) -> str:
    """What is left, joint by joint, in the units in which people read it, and whether that is small."""
    levels = list(diagnosis.levels)
    scale = [FINE[level.unit] for level in levels]
    names = [("measured", "measured"), ("noise", "noise_floor"), ("nominal model", "before")]
    names += [("extended model", "after")] if diagnosis.causes else []
    columns: list[Column] = [("unit", [unit for _, unit in scale])]
    columns += [
        (heading, [f"{factor * getattr(level, name):.3g}" for level, (factor, _) in zip(levels, scale, strict=True)])
        for heading, name in names
    ]
    columns.append(("left", [diagnosis.tell_left(level).replace("not small", "NOT SMALL") for level in levels]))
    fixed: list[Column] = [
        ("RMS of", [level.channel for level in levels]),
        ("", [shortened(level.component) for level in levels]),
    ]
    return aligned(fixed, [columns])


def format_held_out(levels: Sequence[LoopLevel]) -> str:
    """What both models leave along recordings that were not diagnosed, as a table."""
    return _compared("held out, RMS of", levels)


def format_closed_loop(levels: Sequence[LoopLevel]) -> str:
    """How far both models are from the machine in closed loop, as a table."""
    return _compared("closed loop, RMS of", levels)


def _compared(heading: str, levels: Sequence[LoopLevel]) -> str:
    scale = [FINE[level.unit] for level in levels]
    names = [("measured", "measured"), ("nominal model", "before"), ("extended model", "after")]
    columns: list[Column] = [("unit", [unit for _, unit in scale])]
    columns += [
        (heading, [f"{factor * getattr(level, name):.3g}" for level, (factor, _) in zip(levels, scale, strict=True)])
        for heading, name in names
    ]
    fixed: list[Column] = [
        (heading, [level.quantity for level in levels]),
        ("", [shortened(level.component) for level in levels]),
    ]
    return aligned(fixed, [columns])
