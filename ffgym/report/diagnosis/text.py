"""A diagnosis as plain text for a terminal, at most 120 columns wide."""

from collections.abc import Sequence

from ffgym.diagnosis.closed_loop import LoopLevel
from ffgym.diagnosis.result import Diagnosis
from ffgym.report.circles.tables import Column, aligned, filled, shortened
from ffgym.report.diagnosis.diagnosis_report import STANDS_OUT
from ffgym.report.diagnosis.models import FINE
from ffgym.report.diagnosis.words import place_of, size_text, title_of, together


def format_diagnosis(diagnosis: Diagnosis) -> str:
    """Verdict, causes with sizes, ties, patterns, what is left, what was not judged, what to record next."""
    parts = [format_findings(diagnosis)]
    ties = [rival for rival in diagnosis.rivals if rival.tied]
    parts += [filled(f"cannot be excluded: {place_of(tie.effect, tie.joint)}: {tie.reason}") for tie in ties]
    parts += [filled(f"pattern: {pattern.message}") for pattern in diagnosis.patterns]
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
    """Residuals that stand out, in the units in which people read them; all if none does."""
    standing_out = [level for level in diagnosis.levels if level.before > STANDS_OUT * level.noise_floor]
    levels = standing_out or list(diagnosis.levels)
    scale = [FINE[level.unit] for level in levels]
    names = [("noise", "noise_floor"), ("nominal model", "before")]
    names += [("extended model", "after")] if diagnosis.causes else []
    columns: list[Column] = [("unit", [unit for _, unit in scale])]
    columns += [
        (heading, [f"{factor * getattr(level, name):.3g}" for level, (factor, _) in zip(levels, scale, strict=True)])
        for heading, name in names
    ]
    fixed: list[Column] = [
        ("RMS of", [level.channel for level in levels]),
        ("", [shortened(level.component) for level in levels]),
    ]
    return aligned(fixed, [columns])


def format_closed_loop(levels: Sequence[LoopLevel]) -> str:
    """How far both models are from the machine in closed loop, as a table."""
    scale = [FINE[level.unit] for level in levels]
    names = [("measured", "measured"), ("nominal model", "before"), ("extended model", "after")]
    columns: list[Column] = [("unit", [unit for _, unit in scale])]
    columns += [
        (heading, [f"{factor * getattr(level, name):.3g}" for level, (factor, _) in zip(levels, scale, strict=True)])
        for heading, name in names
    ]
    fixed: list[Column] = [
        ("closed loop, RMS of", [level.quantity for level in levels]),
        ("", [shortened(level.component) for level in levels]),
    ]
    return aligned(fixed, [columns])
