"""A diagnosis on a page that can be sent, for readers who do not know the tool."""

from ffgym.diagnosis.regimes import REGIMES
from ffgym.diagnosis.result import Cause, Diagnosis
from ffgym.effects import EFFECTS
from ffgym.report.diagnosis.diagnosis_report import DiagnosisReport
from ffgym.report.diagnosis.evidence import place_figures, tool_figures
from ffgym.report.diagnosis.maps import candidate_figures, level_figures, map_figures
from ffgym.report.diagnosis.words import (
    VERDICTS,
    compared_table,
    levels_table,
    place_of,
    rivals_of,
    size_text,
    title_of,
    together,
)
from ffgym.report.page import Code, Items, Note, Page, Part, Section, words_of
from ffgym.report.table import Cell, Column, Table

_MOST_RIVALS = 8
"""Rivals of a cause that the table lists, those that explain most; a tie is always listed."""


def render_diagnosis_page(report: DiagnosisReport) -> str:
    """HTML of the page; the same diagnosis gives the same bytes.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    diagnosis = report.in_joint_units
    words, motions = words_of("diagnosis"), ", ".join(diagnosis.motions) or "none"
    verdicts = "; ".join(f"**{word}**, {meaning}" for word, meaning in VERDICTS.items())
    reading: list[Part] = [words["reading"], f"Verdicts: {verdicts}.", Note(f"Motions: {motions}.")]
    sections = [
        *_answer(diagnosis),
        *_gain(report, diagnosis),
        *_evidence(report),
        *_patterns(diagnosis),
        *_rivals(report, diagnosis),
        *_limits(diagnosis),
        Section("How to read this page", reading),
    ]
    meaning = words["meaning"].format(verdict=diagnosis.verdict, meaning=VERDICTS[diagnosis.verdict])
    n = len(diagnosis.motions)
    return Page(
        title=f"Diagnosis of {diagnosis.robot}",
        subtitle=f"What the simulation gets wrong, from {n} measured motion{'s' * (n != 1)}, and which cause explains "
        "it.",
        headline=[f"**{diagnosis.verdict.upper()}** {diagnosis.sentence}", meaning],
        parts=[section for section in sections if section.parts],
        provenance=diagnosis.provenance,
        is_dated=False,
    ).html()


def _answer(diagnosis: Diagnosis) -> list[Section]:
    """Mistakes of wiring, causes, and what to record next."""
    words = words_of("diagnosis")
    sections = []
    if diagnosis.wiring:
        boxes: list[Part] = [
            Section(", ".join([mistake.kind, *mistake.joints]), [mistake.message], is_boxed=True)
            for mistake in diagnosis.wiring
        ]
        sections.append(Section("Wiring", [*boxes, Note(words["wiring"])]))
    if diagnosis.causes:
        sections.append(Section("Causes", [*map(_cause, diagnosis.causes), Note(words["causes"])]))
    if diagnosis.separating_motion is not None:
        motion = diagnosis.separating_motion
        first, second = motion.between
        commands = f"ffgym record {diagnosis.robot} next.toml --out more_logs\n"
        commands += f"ffgym diagnose logs more_logs --robot {diagnosis.robot}"
        parts: list[Part] = [
            words["record"].format(first=first, second=second),
            Code(motion.toml.strip()),
            Code(commands),
            Note(words["machine"].format(expected=motion.expected)),
        ]
        sections.append(Section("Next experiment", parts))
    return sections


def _cause(cause: Cause) -> Section:
    parts: list[Part] = [size_text(size) for size in cause.parameters]
    if cause.fixed:
        chosen = ", ".join(f"{name} = {value:.4g}" for name, value in cause.fixed.items())
        parts.append(Note(f"Chosen, not estimated: {chosen}."))
    parts.append(
        f"Explains **{100 * cause.held_out_gain:.0f} %** of what stood above the noise, on motions that were not used "
        "to fit it."
    )
    if cause.effect in EFFECTS:
        parts.append(Note(f"How it shows: {EFFECTS[cause.effect].signature}"))
    where = f", {cause.joint}" if cause.joint else ""
    return Section(f"{title_of(cause.effect)}{where} ({cause.code}, `{cause.effect}`)", parts, is_boxed=True)


def _gain(report: DiagnosisReport, diagnosis: Diagnosis) -> list[Section]:
    """What is left, and what is gained on the log, on other recordings, and in closed loop."""
    words = words_of("diagnosis")
    parts: list[Part] = []
    if diagnosis.levels:
        is_worse = bool(diagnosis.causes and not diagnosis.gains)
        note = Note(words["levels"] + words["not_written"] * is_worse)
        parts = [levels_table(diagnosis), note, *level_figures(report)]
    sections = [Section("What is left, and what is gained", parts)]
    for title, name, levels in (
        ("What is gained on recordings that were not diagnosed", "held_out", report.held_out),
        ("What is gained in closed loop", "closed_loop", report.closed_loop),
    ):
        if levels:
            table = compared_table("quantity", levels, name.replace("_", "-"))
            sections.append(Section(title, [words[name], table]))
    return sections


def _evidence(report: DiagnosisReport) -> list[Section]:
    """Where the model is wrong, and what that looks like."""
    words = words_of("diagnosis")
    motions = "; ".join(f"**{name}**, {meaning}" for name, meaning in REGIMES["motion"].items())
    maps = map_figures(report)
    evidence = [*(figure for place in report.places for figure in place_figures(report, place)), *tool_figures(report)]
    return [
        Section("Where the model is wrong", [words["maps"].format(motions=motions), *maps] if maps else []),
        Section("What it looks like", [words["looks"], *evidence] if evidence else []),
    ]


def _patterns(diagnosis: Diagnosis) -> list[Section]:
    """What differs between recordings, and what the residual depends on."""
    sections = []
    if diagnosis.drifts:
        note = words_of("diagnosis")["drifts"]
        drifts = Items([drift.message for drift in diagnosis.drifts])
        sections.append(Section("What differs between recordings", [drifts, Note(note)]))
    if diagnosis.patterns:
        found = diagnosis.patterns
        leads = ["".join(f"No cause: {lead}. " for lead in pattern.leads).strip() for pattern in found]
        words = [Cell(pattern.message, lead) for pattern, lead in zip(found, leads, strict=True)]
        columns = [
            Column("channel", [pattern.channel for pattern in found], kind="text"),
            Column("where", [pattern.component for pattern in found], kind="text"),
            Column("pattern", words, kind="prose"),
            Column("share of the residual", [pattern.share for pattern in found], ".0%"),
        ]
        title = "What the residual depends on, said without any cause"
        sections.append(Section(title, [Table(columns=columns, name="patterns")]))
    return sections


def _rivals(report: DiagnosisReport, diagnosis: Diagnosis) -> list[Section]:
    """Candidates beside the causes, and why they lost."""
    tables = []
    for cause in diagnosis.causes:
        own = [rival for i, rival in enumerate(rivals_of(diagnosis, cause)) if rival.tied or i < _MOST_RIVALS]
        effects = [Cell(place_of(rival.effect, rival.joint), style="tie" * rival.tied) for rival in own]
        columns = [
            Column("effect", effects, kind="text"),
            Column("explains", [rival.held_out_gain for rival in own], ".0%"),
            Column("why not", ["Cannot be excluded: " * rival.tied + rival.reason for rival in own], kind="prose"),
        ]
        if own:
            tables.append(Section(f"Instead of {place_of(cause.effect, cause.joint)}", [Table(columns=columns)]))
    return [Section("Rivals, and why they lost", [*candidate_figures(report), *tables])]


def _limits(diagnosis: Diagnosis) -> list[Section]:
    """What the logs say nothing about, and what the quality gate says of them."""
    unjudged = (("not excited", diagnosis.not_excited), ("not judgeable", diagnosis.not_judgeable))
    rows = [(effects, f"{word}: {why}") for word, all_of in unjudged for effects, why in together(all_of)]
    columns = [
        Column("effects", [effects for effects, _ in rows], kind="prose"),
        Column("why", [why for _, why in rows], kind="prose"),
    ]
    table = Table(columns=columns, name="unjudged")
    return [
        Section("What these logs say nothing about", [table] if rows else []),
        Section("What the quality gate says of the logs", [Items(diagnosis.quality)] if diagnosis.quality else []),
    ]
