"""The results in a few sentences, and what of the published experiment the simulation shows too; all of it counted."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeAlias

from ffgym.report.circles.comparison import FACTOR, Row, SpeedTable, circle_tables, nearness, percent, reduction
from ffgym.report.laws import ORACLE, UNCOMPENSATED, baseline_of, law_styles
from ffgym.studies import CircleStudy, OneAxisStudy

REPRODUCED, PARTLY = 0.75, 0.5
"""Shares of circles that must agree with the real robot for 'reproduced' and for 'partly reproduced'; chosen."""


Comparison: TypeAlias = tuple[str, bool, bool]
"""Where two circles are, and whether the first has the smaller RMS path error: simulated, published."""


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One question to simulation and real robot."""

    question: str
    verdict: str
    """'reproduced', 'partly reproduced', 'not reproduced' or 'not comparable'."""
    text: str
    """The numbers behind the verdict."""


def findings(study: CircleStudy) -> list[Finding]:
    """Questions and answers, speed by speed; questions that no published number answers are left out."""
    tables = circle_tables(study)
    found: list[Finding | None] = []
    for table in tables:
        if not table.is_published:
            found.append(_unpublished(table))
            continue
        others = [agent for agent in table.agents if agent != UNCOMPENSATED]
        found += [_size(table, agent) for agent in table.agents]
        found += [_better(table, agent, UNCOMPENSATED) for agent in others]
        found += [_better(table, after, before) for before, after in pairwise(others)]
        found.append(_grows_with_radius(table))
    return [finding for finding in [*found, _grows_with_speed(tables)] if finding is not None]


def _size(table: SpeedTable, agent: str) -> Finding | None:
    """Whether simulated and published errors are equally large."""
    near = nearness(table.ratios(agent).values())
    if near is None:
        return None
    return Finding(
        question=f"{table.speed_mm_s:g} mm/s: size of the path error with {_label(table, agent)}",
        verdict=_verdict(near.near, near.total),
        text=f"{near.near} of {near.total} circles within a factor of {FACTOR:g}; median simulated / published "
        f"{near.median:.2f}.",
    )


def _better(table: SpeedTable, law: str, than: str) -> Finding | None:
    """Whether one law beats another on the same circles as on the real robot."""
    question = f"{table.speed_mm_s:g} mm/s: is {_label(table, law)} better than {_label(table, than)}?"
    finding = _answer(question, "circles", "smaller error", [_compare(row, law, row, than) for row in table.rows])
    simulated = reduction(table.mean_rms(law), table.mean_rms(than))
    published = reduction(table.mean_published_rms(law), table.mean_published_rms(than))
    if finding is None or simulated is None or published is None:
        return finding
    means = f"Mean RMS {percent(simulated)} simulated, {percent(published)} published."
    return replace(finding, text=f"{means} {finding.text}")


def _grows_with_radius(table: SpeedTable) -> Finding | None:
    pairs = [
        _compare(small, UNCOMPENSATED, large, UNCOMPENSATED)
        for large in table.rows
        for small in table.rows
        if small.position == large.position and small.radius_mm < large.radius_mm
    ]
    question = f"{table.speed_mm_s:g} mm/s: has the smaller circle the smaller error, without compensation?"
    return _answer(question, "pairs of circles", "yes", pairs)


def _grows_with_speed(tables: Sequence[SpeedTable]) -> Finding | None:
    pairs = [
        _compare(a, UNCOMPENSATED, b, UNCOMPENSATED)
        for i, slow in enumerate(tables)
        for fast in tables[i + 1 :]
        for a in slow.rows
        for b in fast.rows
        if (a.position, a.radius_mm) == (b.position, b.radius_mm)
    ]
    question = "Has the slower motion the smaller error, without compensation?"
    return _answer(question, "pairs of speeds", "yes", pairs)


def _unpublished(table: SpeedTable) -> Finding:
    means = {agent: table.mean_rms(agent) for agent in table.agents}
    parts = ", ".join(f"{_label(table, agent)} {mean:.3f} mm" for agent, mean in means.items() if mean is not None)
    return Finding(
        question=f"{table.speed_mm_s:g} mm/s: path error",
        verdict="not comparable",
        text=f"No numbers were published for these circles at this speed. Simulated mean RMS: {parts}.",
    )


def _compare(first: Row, first_law: str, second: Row, second_law: str) -> Comparison | None:
    """Compare two circles; None where one of the numbers is missing, or the published ones are equal."""
    a, b = first.entries.get(first_law), second.entries.get(second_law)
    if a is None or b is None or a.published_rms is None or b.published_rms is None:
        return None
    radii = " and ".join(f"{radius:g}" for radius in sorted({first.radius_mm, second.radius_mm}))
    smaller = (a.rms < b.rms, a.published_rms < b.published_rms)
    return None if a.published_rms == b.published_rms else (f"{radii} mm at {first.position}", *smaller)


def _answer(question: str, things: str, yes: str, pairs: Iterable[Comparison | None]) -> Finding | None:
    """Count where the first is the smaller one."""
    known = [pair for pair in pairs if pair is not None]
    if not known:
        return None
    simulated, published = sum(here for _, here, _ in known), sum(there for _, _, there in known)
    unlike = [where for where, here, there in known if here != there]
    differ = f"They differ on {', '.join(unlike)}." if unlike else "They agree on all."
    text = f"Of {len(known)} {things}, {yes} on {simulated} simulated and {published} published. {differ}"
    return Finding(question=question, verdict=_verdict(len(known) - len(unlike), len(known)), text=text)


def _label(table: SpeedTable, agent: str) -> str:
    return law_styles(table.agents)[agent].label if agent in table.agents else agent


def _verdict(agree: int, total: int) -> str:
    share = agree / total
    return "reproduced" if share >= REPRODUCED else "partly reproduced" if share >= PARTLY else "not reproduced"


def headline(circle: CircleStudy, one_axis: OneAxisStudy) -> list[str]:
    """What the best law does at each speed, how near the simulation is to the real robot, and what one axis shows.

    The best law is the one with the smallest mean RMS path error at the slowest speed; the oracle does not compete.
    """
    tables = circle_tables(circle)
    base = baseline_of(tables[0].agents)
    others = [agent for agent in tables[0].agents if agent not in (base, ORACLE)]
    sentences = []
    if others:
        best = min(others, key=lambda agent: tables[0].mean_rms(agent) or 0.0)
        sentences = [_effect(table, best, base) for table in tables]
    summary = nearness(ratio for table in tables for ratio in table.ratios().values())
    if summary is not None:
        sentences.append(
            f"Without compensation the simulated RMS error is within a factor of {FACTOR:g} of the real robot's on "
            f"{summary.near} of {summary.total} circles (median ratio {summary.median:.2f})."
        )
    return sentences + _one_axis(one_axis)


def _effect(table: SpeedTable, law: str, base: str) -> str:
    """Mean error with and without a law at one speed, and what stays."""
    labels = {agent: style.label for agent, style in law_styles(table.agents).items()}
    before, after, worst = table.mean_rms(base), table.mean_rms(law), table.max_error(law)
    change = reduction(after, before)
    if before is None or after is None or worst is None or change is None:
        return f"At {table.speed_mm_s:g} mm/s not both {labels[law]} and {labels[base]} were run."
    text = (
        f"At {table.speed_mm_s:g} mm/s the mean RMS path error with {labels[law]} is {after:.3f} mm, {percent(change)} "
        f"than the {before:.3f} mm with {labels[base]}"
    )
    published = reduction(table.mean_published_rms(law), table.mean_published_rms(base))
    real = "not published" if published is None else f"real robot: {percent(published)}"
    return f"{text} ({real}); at worst the tool is {worst:.2f} mm off the circle."


def _one_axis(study: OneAxisStudy) -> list[str]:
    """What the best law does to the motor error of one axis."""
    styles = law_styles(result.agent for result in study.results)
    base = baseline_of(list(styles))
    others = [result for result in study.results if result.agent not in (base, ORACLE)]
    if not others:
        return []
    best = max(others, key=lambda result: result.reduction).agent
    changes = " and ".join(f"{percent(r.reduction)} at {r.frequency_hz:g} Hz" for r in others if r.agent == best)
    return [
        f"On one axis that follows a sine, the RMS motor error with {styles[best].label} is {changes} than with "
        f"{styles[base].label}."
    ]
