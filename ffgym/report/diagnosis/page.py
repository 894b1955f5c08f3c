"""A diagnosis on a page that can be sent, for readers who do not know the tool."""

from collections.abc import Sequence

from ffgym.diagnosis.regimes import REGIMES
from ffgym.diagnosis.result import Cause, Diagnosis, Rival, SeparatingMotion, Unjudged
from ffgym.report.diagnosis.diagnosis_report import DiagnosisReport
from ffgym.report.diagnosis.figures import candidate_figures, level_figures, map_figures, place_figures, tool_figures
from ffgym.report.diagnosis.text import compared_table, levels_table
from ffgym.report.diagnosis.words import (
    VERDICTS,
    in_joint_units,
    place_of,
    rivals_of,
    signature_of,
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
    diagnosis = in_joint_units(report.diagnosis, None if report.before is None else report.before.robot)
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
    if signature := signature_of(cause.effect):
        parts.append(Note(f"How it shows: {signature}"))
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
    maps = f"Rows of the log are sorted by what a joint was doing: {motions}. Load, position, log and temperature are "
    looks = (
        "Joints of causes first, then those that stand out most. What the residual **depends on**: a fault that "
        "depends on a variable alone is the same in both directions of motion, one that has the sign of the speed, as "
        "friction has, is opposite. What **repeats** with a gear, a motor or a resolver stands up as a narrow peak; "
        "rhythms of the motions do not. **Friction over speed**: what differs from the line of the nominal model is "
        "the residual, whatever its cause."
    )
    evidence = [*(figure for place in report.places for figure in place_figures(report, place)), *tool_figures(report)]
    return [
        Section(title, [words, *figures] if figures else [])
        for title, words, figures in (
            ("Where the model is wrong", f"{maps}cut into thirds.", map_figures(report)),
            ("What it looks like", looks, evidence),
        )
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
    rivals = [(cause, _listed(rivals_of(diagnosis, cause))) for cause in diagnosis.causes]
    tables = [
        Section(f"Instead of {place_of(cause.effect, cause.joint)}", [_rival_table(own)])
        for cause, own in rivals
        if own
    ]
    return [Section("Rivals, and why they lost", [*candidate_figures(report), *tables])]


def _listed(rivals: Sequence[Rival]) -> list[Rival]:
    return [rival for i, rival in enumerate(rivals) if rival.tied or i < _MOST_RIVALS]


def _rival_table(rivals: Sequence[Rival]) -> Table:
    names = [place_of(rival.effect, rival.joint) for rival in rivals]
    effects = [Cell(name, style="tie" * rival.tied) for name, rival in zip(names, rivals, strict=True)]
    columns = [
        Column("effect", effects, kind="text"),
        Column("explains", [rival.held_out_gain for rival in rivals], ".0%"),
        Column("why not", ["Cannot be excluded: " * rival.tied + rival.reason for rival in rivals], kind="prose"),
    ]
    return Table(columns=columns)


def _limits(diagnosis: Diagnosis) -> list[Section]:
    """What the logs say nothing about, and what the quality gate says of them."""
    unjudged: dict[str, Sequence[Unjudged]] = {
        "not excited": diagnosis.not_excited,
        "not judgeable": diagnosis.not_judgeable,
    }
    rows = [(effects, f"{word}: {why}") for word, all_of in unjudged.items() for effects, why in together(all_of)]
    columns = [
        Column("effects", [effects for effects, _ in rows], kind="prose"),
        Column("why", [why for _, why in rows], kind="prose"),
    ]
    silent = [Table(columns=columns, name="unjudged")] if rows else []
    said = [Items(diagnosis.quality)] if diagnosis.quality else []
    return [
        Section("What these logs say nothing about", silent),
        Section("What the quality gate says of the logs", said),
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
