"""Page of a diagnosis that can be sent: verdict, how to read it, causes, evidence, and input files."""

from ffgym.diagnosis.regimes import REGIMES
from ffgym.diagnosis.result import Diagnosis
from ffgym.effects import EFFECTS
from ffgym.report.diagnosis.diagnosis_report import DiagnosisReport
from ffgym.report.diagnosis.evidence import place_figures, tool_figures
from ffgym.report.diagnosis.maps import candidate_figures, level_figures, map_figures
from ffgym.report.diagnosis.words import (
    VERDICTS,
    causes_table,
    compare_levels,
    first_sentence,
    held_out_note,
    in_words,
    levels_table,
    place_of,
    rivals_of,
    short_sentence,
    shown_share,
    simulation_note,
    size_text,
    title_of,
    together,
    write_digits,
)
from ffgym.report.page import Code, Details, Items, Note, Page, Part, Section, words_of
from ffgym.report.table import Cell, Column, Table

_MOST_RIVALS = 8
"""Rivals of a cause that the table lists, those that explain most; a tie is always listed."""


def render_diagnosis_page(report: DiagnosisReport) -> str:
    """HTML of the page; the same diagnosis gives the same bytes.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    diagnosis = report.in_joint_units
    sections = [
        *_answer(report, diagnosis),
        *_gain(report, diagnosis),
        *_evidence(report),
        *_patterns(diagnosis),
        *_rivals(report, diagnosis),
        *_limits(diagnosis),
    ]
    n = len(diagnosis.motions)
    return Page(
        title=f"Diagnosis of {diagnosis.robot}",
        subtitle=f"Errors of the simulation model, their causes and their sizes, from {n} measured "
        f"motion{'s' * (n != 1)}.",
        reading=_reading(diagnosis),
        headline=[f"**{diagnosis.verdict.upper()}** {short_sentence(diagnosis)}"],
        parts=[section for section in sections if section.parts],
        provenance=diagnosis.provenance,
    ).html()


def _reading(diagnosis: Diagnosis) -> list[Part]:
    """Explain the page in a short paragraph with the meaning of the verdict, and terms on request."""
    words, motions = words_of("diagnosis"), ", ".join(diagnosis.motions) or "none"
    verdicts = "; ".join(f"**{word}**, {meaning}" for word, meaning in VERDICTS.items())
    terms = Details("Terms, verdicts and motions", [words["terms"], f"Verdicts: {verdicts}.", f"Motions: {motions}."])
    meaning = words["meaning"].format(verdict=diagnosis.verdict, meaning=VERDICTS[diagnosis.verdict])
    return [f"{words['reading']} {meaning}", terms]


def _answer(report: DiagnosisReport, diagnosis: Diagnosis) -> list[Section]:
    """Wiring mistakes, causes, and the commands to go on with."""
    words = words_of("diagnosis")
    sections = []
    if diagnosis.wiring:
        boxes: list[Part] = [
            Section(", ".join([mistake.kind, *mistake.joints]), [mistake.message], is_boxed=True)
            for mistake in diagnosis.wiring
        ]
        sections.append(Section("Wiring", [*boxes, Note(words["wiring"])]))
    if diagnosis.causes:
        notes: list[Part] = [
            Note(words["causes"] + held_out_note(diagnosis)),
            Details("How each cause shows", _signs(diagnosis)),
        ]
        sections.append(Section("Causes", [causes_table(diagnosis, on_page=True), *notes]))
    following: list[Part] = []
    if diagnosis.separating_motion is not None:
        motion = diagnosis.separating_motion
        first, second = motion.between
        following.append(words["record"].format(first=in_words(first), second=in_words(second)))
        following.append(Code(motion.toml.strip()))
        following.append(Note(words["machine"].format(expected=write_digits(motion.expected))))
    if report.commands:
        following += [words["next"], Code("\n".join(report.commands))]
        if note := simulation_note(report.commands):
            following.append(Note(note))
    if following:
        sections.append(Section("Next experiment", following))
    return sections


def _signs(diagnosis: Diagnosis) -> list[Part]:
    """Signature of each cause in measurements, and the parameters that were chosen instead of estimated."""
    parts: list[Part] = []
    for cause in diagnosis.causes:
        sizes = "; ".join(size_text(size) for size in cause.parameters)
        text = f"**{place_of(title_of(cause.effect), cause.joint)}** ({cause.code}, `{cause.effect}`): {sizes}."
        if cause.effect in EFFECTS:
            text = f"{text} {first_sentence(EFFECTS[cause.effect].__doc__ or '')}."
            text += f" Signature: {EFFECTS[cause.effect].signature}."
        if cause.fixed:
            chosen = ", ".join(f"{name} = {value:.4g}" for name, value in cause.fixed.items())
            text += f" Not estimated: {chosen}."
        parts.append(text)
    return parts


def _gain(report: DiagnosisReport, diagnosis: Diagnosis) -> list[Section]:
    """Residuals of both models on the log, on other recordings, and in closed loop."""
    words = words_of("diagnosis")
    parts: list[Part] = []
    if diagnosis.levels:
        is_worse = bool(diagnosis.causes and not diagnosis.gains)
        note = Note(words["levels"] + words["not_written"] * is_worse)
        parts = [levels_table(diagnosis), note, *level_figures(report)]
    sections = [Section("Residual of both models", parts)]
    for title, name, levels in (
        ("Prediction of recordings that were not diagnosed", "held_out", report.held_out),
        ("Closed loop", "closed_loop", report.closed_loop),
    ):
        if levels:
            table = compare_levels("quantity", levels, name.replace("_", "-"))
            sections.append(Section(title, [words[name], table]))
    return sections


def _evidence(report: DiagnosisReport) -> list[Section]:
    """Maps of the misfit, and pictures of the residual of the joints that stand out."""
    words = words_of("diagnosis")
    motions = "; ".join(f"**{name}**, {meaning}" for name, meaning in REGIMES["motion"].items())
    maps = map_figures(report)
    evidence = [*(figure for place in report.places for figure in place_figures(report, place)), *tool_figures(report)]
    return [
        Section("Where the model is wrong", [words["maps"].format(motions=motions), *maps] if maps else []),
        Section("Shape of the residual", [words["looks"], *evidence] if evidence else []),
    ]


def _patterns(diagnosis: Diagnosis) -> list[Section]:
    """Differences between recordings, and variables that the residual depends on."""
    sections = []
    if diagnosis.drifts:
        note = words_of("diagnosis")["drifts"]
        drifts = Items([drift.message for drift in diagnosis.drifts])
        sections.append(Section("Differences between recordings", [drifts, Note(note)]))
    if diagnosis.patterns:
        found = diagnosis.patterns
        leads = ["".join(f"Not a cause: {lead}. " for lead in pattern.leads).strip() for pattern in found]
        words = [Cell(pattern.message, lead) for pattern, lead in zip(found, leads, strict=True)]
        columns = [
            Column("channel", [pattern.channel for pattern in found], kind="text"),
            Column("where", [pattern.component for pattern in found], kind="text"),
            Column("pattern", words, kind="prose"),
            Column("share of the residual", [pattern.share for pattern in found], ".0%"),
        ]
        title = "Variables that the residual depends on, without a hypothesis about the cause"
        sections.append(Section(title, [Table(columns=columns, name="patterns")]))
    return sections


def _rivals(report: DiagnosisReport, diagnosis: Diagnosis) -> list[Section]:
    """Rivals of each cause, and why they lost."""
    tables = []
    for cause in diagnosis.causes:
        own = [rival for i, rival in enumerate(rivals_of(diagnosis, cause)) if rival.tied or i < _MOST_RIVALS]
        effects = [Cell(place_of(rival.effect, rival.joint), style="tie" * rival.tied) for rival in own]
        columns = [
            Column("effect", effects, kind="text"),
            Column("explains, in the fit", [shown_share(rival.held_out_gain) for rival in own], ".0%"),
            Column("reason", ["Cannot be excluded: " * rival.tied + rival.reason for rival in own], kind="prose"),
        ]
        if own:
            tables.append(Section(f"Instead of {place_of(cause.effect, cause.joint)}", [Table(columns=columns)]))
    return [Section("Rivals, and why they lost", [*candidate_figures(report), *tables])]


def _limits(diagnosis: Diagnosis) -> list[Section]:
    """Effects that could not be judged, and findings of the quality gate."""
    unjudged = (("not excited", diagnosis.not_excited), ("not judgeable", diagnosis.not_judgeable))
    rows = [(effects, f"{word}: {why}") for word, all_of in unjudged for effects, why in together(all_of)]
    columns = [
        Column("effects", [effects for effects, _ in rows], kind="prose"),
        Column("why", [why for _, why in rows], kind="prose"),
    ]
    table = Table(columns=columns, name="unjudged")
    return [
        Section("Effects on which these logs allow no statement", [table] if rows else []),
        Section("Findings of the quality gate", [Items(diagnosis.quality)] if diagnosis.quality else []),
    ]
