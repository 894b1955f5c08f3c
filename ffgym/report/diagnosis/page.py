"""A diagnosis on a page that can be sent, for readers who do not know the tool."""

from ffgym.diagnosis.regimes import REGIMES
from ffgym.diagnosis.result import Cause, Diagnosis, SeparatingMotion
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
from ffgym.report.page import Code, Items, Note, Page, Part, Section
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
        *_answer(diagnosis),
        *_gain(report, diagnosis),
        *_evidence(report),
        *_patterns(diagnosis),
        *_rivals(report, diagnosis),
        *_limits(diagnosis),
        _reading(diagnosis),
    ]
    meaning = (
        f"“{diagnosis.verdict}”: {VERDICTS[diagnosis.verdict]}. A cause is a hypothesis about the model, no finding of "
        "a workshop."
    )
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
    sections = []
    if diagnosis.wiring:
        titles = [", ".join([mistake.kind, *mistake.joints]) for mistake in diagnosis.wiring]
        boxes: list[Part] = [
            Section(title, [mistake.message], is_boxed=True)
            for title, mistake in zip(titles, diagnosis.wiring, strict=True)
        ]
        note = (
            "Columns that are not what they are called, by a fit over all logs. With an output folder, `columns.toml` "
            "in it is a column map that mends them: `ffgym diagnose LOGS --columns columns.toml`."
        )
        sections.append(Section("Wiring", [*boxes, Note(note)]))
    if diagnosis.causes:
        note = "Sizes with 90 % intervals from resampled blocks of the log; SI units."
        sections.append(Section("Causes", [*map(_cause, diagnosis.causes), Note(note)]))
    if diagnosis.separating_motion is not None:
        sections.append(_next(diagnosis.robot, diagnosis.separating_motion))
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


def _next(robot: str, motion: SeparatingMotion) -> Section:
    first, second = motion.between
    return Section(
        "Next experiment",
        [
            f"To tell **{first}** from **{second}**, save this as `next.toml`, record it, and diagnose again with both "
            "logs:",
            Code(motion.toml.strip()),
            Code(
                f"ffgym record {robot} next.toml --out more_logs\nffgym diagnose logs more_logs --robot {robot}",
            ),
            Note(
                "On a real machine, run the motions that `ffgym record` makes of it with its simulation. Of the "
                "protocols that were tried it has the largest expected evidence per second: "
                f"{motion.expected:.3g} in units of the log-likelihood ratio."
            ),
        ],
    )


def _gain(report: DiagnosisReport, diagnosis: Diagnosis) -> list[Section]:
    """What is left, and what is gained on the log, on other recordings, and in closed loop."""
    parts: list[Part] = []
    if diagnosis.levels:
        note = (
            "RMS of measured minus predicted over all rows that are judged: of the nominal model as it is, and of the "
            "extended model as it is written, each motion by one that was fitted without it. Small is what hardly "
            "exceeds noise, or 5 % of what was measured; allowed for is what errors of calibration, or friction at "
            "motion that the logs do not show, may come to."
        )
        if diagnosis.causes and not diagnosis.gains:
            note += " **The extended model leaves more than the nominal one, and was not written.**"
        parts = [levels_table(diagnosis), Note(note), *level_figures(report)]
    held_out = (
        "Both models, as their files say them, were replayed along recordings that were not diagnosed; RMS of what was "
        "measured, and of measured minus predicted."
    )
    closed_loop = (
        "Both models ran the references of recordings that were not diagnosed, under the documented controller; RMS of "
        "what was measured, and of measured minus simulated."
    )
    sections = [Section("What is left, and what is gained", parts)]
    for title, words, name, levels in (
        ("What is gained on recordings that were not diagnosed", held_out, "held-out", report.held_out),
        ("What is gained in closed loop", closed_loop, "closed-loop", report.closed_loop),
    ):
        if levels:
            sections.append(Section(title, [words, compared_table("quantity", levels, name)]))
    return sections


def _evidence(report: DiagnosisReport) -> list[Section]:
    """Where the model is wrong, and what that looks like."""
    motions = "; ".join(f"**{name}**, {meaning}" for name, meaning in REGIMES["motion"].items())
    where = (
        f"Rows of the log are sorted by what a joint was doing: {motions}. Load, position, log and temperature are cut "
        "into thirds."
    )
    looks = (
        "Joints of causes first, then those that stand out most. What the residual **depends on**: a fault that "
        "depends on a variable alone is the same in both directions of motion, one that has the sign of the speed, as "
        "friction has, is opposite. What **repeats** with a gear, a motor or a resolver stands up as a narrow peak; "
        "rhythms of the motions do not. **Friction over speed**: what differs from the line of the nominal model is "
        "the residual, whatever its cause."
    )
    maps = map_figures(report)
    evidence = [*(figure for place in report.places for figure in place_figures(report, place)), *tool_figures(report)]
    return [
        Section("Where the model is wrong", [where, *maps] if maps else []),
        Section("What it looks like", [looks, *evidence] if evidence else []),
    ]


def _patterns(diagnosis: Diagnosis) -> list[Section]:
    """What differs between recordings, and what the residual depends on."""
    sections = []
    if diagnosis.drifts:
        note = "Friction levels of each joint, fitted to each recording alone beside the model of all of them."
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


def _reading(diagnosis: Diagnosis) -> Section:
    words = (
        "The **nominal model** is what the simulation knows of the robot. Its arm is driven by the motor angles that "
        "were measured, and what it then predicts (torque of each motor, position of the tool, angles behind the "
        "gearboxes, torque of the servo) is compared with what was measured: the difference is the **residual**. Its "
        "**noise floor** is what it would be if the model were right, found by replaying the model over itself with "
        "this log's noise. The **extended model** is the nominal one with the causes. An effect counts only for what "
        "it explains on motions that were not used to fit it, and only beyond what a perfect model would reach by "
        "chance. Errors of calibration that any model has are allowed for before anything is named."
    )
    verdicts = "; ".join(f"**{word}**, {meaning}" for word, meaning in VERDICTS.items())
    motions = ", ".join(diagnosis.motions) or "none"
    return Section("How to read this page", [words, f"Verdicts: {verdicts}.", Note(f"Motions: {motions}.")])
