"""The results in a few sentences, all of them computed."""

from ffgym.report.circles.comparison import FACTOR, SpeedTable, circle_tables, nearness, percent, reduction
from ffgym.report.laws import ORACLE, baseline_of, law_styles
from ffgym.studies import CircleStudy, OneAxisStudy


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
