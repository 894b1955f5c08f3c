"""Findings: results in a few sentences, and agreement of simulation and published experiment, by counts of circles."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeAlias

from ffgym.report.circles.comparison import FACTOR, CircleRow, circle_tables, nearness, percent, reduction
from ffgym.report.laws import ORACLE, UNCOMPENSATED, baseline_of, law_styles
from ffgym.studies import CircleStudy, OneAxisStudy

REPRODUCED, PARTLY = 0.75, 0.5
"""Shares of circles that must agree with the real robot for 'reproduced' and for 'partly reproduced'; chosen."""


Compared: TypeAlias = tuple[CircleRow, str, CircleRow, str]
"""Two circles, each with a law, of which the first may have the smaller error."""


@dataclass(frozen=True, kw_only=True)
class ReproductionFinding:
    """Answer of simulation and real robot to one question."""

    question: str
    verdict: str
    """'reproduced', 'partly reproduced', 'not reproduced' or 'not comparable'."""
    text: str
    """The numbers behind the verdict."""


def findings(study: CircleStudy) -> list[ReproductionFinding]:
    """Answer questions speed by speed; questions without published numbers are left out."""
    tables = circle_tables(study)
    labels = {agent: style.label for agent, style in law_styles([*tables[0].agents, UNCOMPENSATED]).items()}
    found: list[ReproductionFinding | None] = []
    for table in tables:
        rows, speed = table.rows, f"{table.speed_mm_s:g} mm/s"
        if not table.is_published:
            means = {agent: table.mean_rms(agent) for agent in table.agents}
            parts = ", ".join(f"{labels[agent]} {mean:.3f} mm" for agent, mean in means.items() if mean is not None)
            text = f"No numbers were published for these circles at this speed. Simulated mean RMS: {parts}."
            found.append(ReproductionFinding(question=f"{speed}: path error", verdict="not comparable", text=text))
            continue
        # are simulated and published errors equally large?
        for agent in table.agents:
            if (near := nearness(table.ratios(agent).values())) is not None:
                question = f"{speed}: size of the path error with {labels[agent]}"
                ratio = f"median simulated / published {near.median:.2f}"
                text = f"{near.near} of {near.total} circles within a factor of {FACTOR:g}; {ratio}."
                found.append(ReproductionFinding(question=question, verdict=_verdict(near.near, near.total), text=text))
        # is each law better than no compensation, and than the law before it?
        others = [agent for agent in table.agents if agent != UNCOMPENSATED]
        pairs = [(law, UNCOMPENSATED) for law in others] + [(after, before) for before, after in pairwise(others)]
        for law, than in pairs:
            question = f"{speed}: is {labels[law]} better than {labels[than]}?"
            finding = _answer(question, "circles", "smaller error", ((row, law, row, than) for row in rows))
            simulated = reduction(table.mean_rms(law), table.mean_rms(than))
            published = reduction(table.mean_published_rms(law), table.mean_published_rms(than))
            if finding is not None and simulated is not None and published is not None:
                means_text = f"Mean RMS {percent(simulated)} simulated, {percent(published)} published."
                finding = replace(finding, text=f"{means_text} {finding.text}")
            found.append(finding)
        # does the error grow with the radius?
        question = f"{speed}: has the smaller circle the smaller error, without compensation?"
        sizes = (
            (small, UNCOMPENSATED, large, UNCOMPENSATED)
            for large in rows
            for small in rows
            if small.position == large.position and small.radius_mm < large.radius_mm
        )
        found.append(_answer(question, "pairs of circles", "yes", sizes))
    # does the error grow with the speed?
    speeds = (
        (a, UNCOMPENSATED, b, UNCOMPENSATED)
        for i, slow in enumerate(tables)
        for fast in tables[i + 1 :]
        for a in slow.rows
        for b in fast.rows
        if (a.position, a.radius_mm) == (b.position, b.radius_mm)
    )
    question = "Has the slower motion the smaller error, without compensation?"
    found.append(_answer(question, "pairs of speeds", "yes", speeds))
    return [finding for finding in found if finding is not None]


def _answer(question: str, things: str, yes: str, pairs: Iterable[Compared]) -> ReproductionFinding | None:
    """Count where the first circle has the smaller error, simulated and published; published ties do not count."""
    known: list[tuple[str, bool, bool]] = []
    for first, first_law, second, second_law in pairs:
        a, b = first.entries.get(first_law), second.entries.get(second_law)
        if a is None or b is None or a.published_rms is None or b.published_rms is None:
            continue
        if a.published_rms != b.published_rms:
            radii = " and ".join(f"{radius:g}" for radius in sorted({first.radius_mm, second.radius_mm}))
            known.append((f"{radii} mm at {first.position}", a.rms < b.rms, a.published_rms < b.published_rms))
    if not known:
        return None
    simulated, published = sum(here for _, here, _ in known), sum(there for _, _, there in known)
    unlike = [where for where, here, there in known if here != there]
    differ = f"They differ on {', '.join(unlike)}." if unlike else "They agree on all."
    text = f"Of {len(known)} {things}, {yes} on {simulated} simulated and {published} published. {differ}"
    return ReproductionFinding(question=question, verdict=_verdict(len(known) - len(unlike), len(known)), text=text)


def _verdict(agree: int, total: int) -> str:
    share = agree / total
    return "reproduced" if share >= REPRODUCED else "partly reproduced" if share >= PARTLY else "not reproduced"


def headline(circle: CircleStudy, one_axis: OneAxisStudy) -> list[str]:
    """Write the gain of the best law at each speed, the nearness to the real robot, and the gain on one axis.

    The best law is the one with the smallest mean RMS path error at the slowest speed; the oracle does not compete.
    """
    tables = circle_tables(circle)
    agents = tables[0].agents
    base, labels = baseline_of(agents), {agent: style.label for agent, style in law_styles(agents).items()}
    others = [agent for agent in agents if agent not in (base, ORACLE)]
    # gain of the best law at each speed
    sentences = []
    for table in tables if others else ():
        law = min(others, key=lambda agent: tables[0].mean_rms(agent) or 0.0)
        before, after, worst = table.mean_rms(base), table.mean_rms(law), table.max_error(law)
        change = reduction(after, before)
        if before is None or after is None or worst is None or change is None:
            sentences.append(f"At {table.speed_mm_s:g} mm/s not both {labels[law]} and {labels[base]} were run.")
            continue
        published = reduction(table.mean_published_rms(law), table.mean_published_rms(base))
        real = "not published" if published is None else f"real robot: {percent(published)}"
        sentences.append(
            f"At {table.speed_mm_s:g} mm/s the mean RMS path error with {labels[law]} is {after:.3f} mm, "
            f"{percent(change)} than the {before:.3f} mm with {labels[base]} ({real}); at worst the tool is "
            f"{worst:.2f} mm off the circle."
        )
    # nearness to the real robot
    summary = nearness(ratio for table in tables for ratio in table.ratios().values())
    if summary is not None:
        sentences.append(
            f"Without compensation the simulated RMS error is within a factor of {FACTOR:g} of the real robot's on "
            f"{summary.near} of {summary.total} circles (median ratio {summary.median:.2f})."
        )
    # gain of the best law in the motor error of one axis
    styles = law_styles(result.agent for result in one_axis.results)
    base = baseline_of(list(styles))
    results = [result for result in one_axis.results if result.agent not in (base, ORACLE)]
    if results:
        best = max(results, key=lambda result: result.reduction).agent
        changes = " and ".join(f"{percent(r.reduction)} at {r.frequency_hz:g} Hz" for r in results if r.agent == best)
        sentences.append(
            f"On one axis that follows a sine, the RMS motor error with {styles[best].label} is {changes} than with "
            f"{styles[base].label}."
        )
    return sentences
