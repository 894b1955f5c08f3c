"""An improvement as plain text for a terminal, at most 120 columns wide."""

from ffgym.improvement.contenders import BASELINE, MODEL
from ffgym.improvement.gain import Score
from ffgym.improvement.loop import Improvement
from ffgym.improvement.rounds import Round
from ffgym.report.circles.comparison import percent
from ffgym.report.circles.tables import Column, aligned, filled
from ffgym.report.diagnosis.words import size_text, title_of


def format_improvement(improvement: Improvement) -> str:
    """What each round found, and what the laws leave."""
    parts = [filled(line) for each in improvement.rounds for line in round_lines(each)]
    parts += [filled(f"ended: {improvement.ended}"), "", score_table(improvement), "", filled(verdict_of(improvement))]
    return "\n".join(parts)


def round_lines(each: Round) -> list[str]:
    """What one round recorded and found."""
    what = f"{', '.join(each.protocols)}, {each.seconds:.0f} s"
    lines = [f"round {each.number} ({what}): {each.diagnosis.verdict}: {each.diagnosis.sentence}"]
    for cause in each.diagnosis.causes:
        where = f" of {cause.joint}" if cause.joint else ""
        lines.append(f"  {title_of(cause.effect)}{where}: {'; '.join(size_text(size) for size in cause.parameters)}")
    return lines


def score_table(improvement: Improvement) -> str:
    """Mean RMS path error of every law at every speed [um], and what it takes off dynamic LuGre."""
    scores = improvement.gain.scores
    speeds = list(dict.fromkeys(score.speed_mm_s for score in scores))
    laws = list(dict.fromkeys(score.title for score in scores))
    blocks: list[list[Column]] = [
        [
            ("um", [f"{_of(scores, law, speed).rms_um:.1f}" for law in laws]),
            ("", [change(_of(scores, law, speed)) for law in laws]),
        ]
        for speed in speeds
    ]
    return aligned([("mean RMS path error", laws)], blocks, [f"{speed:g} mm/s" for speed in speeds])


def _of(scores: tuple[Score, ...], title: str, speed: float) -> Score:
    return next(score for score in scores if score.title == title and score.speed_mm_s == speed)


def change(score: Score) -> str:
    """What a law takes off the error of the baseline."""
    if score.law == BASELINE:
        return ""
    return percent(score.against) if score.against else "the same"


def verdict_of(improvement: Improvement) -> str:
    """What the model of the last round gains, in one sentence."""
    own = [score for score in improvement.gain.scores if score.law == MODEL]
    said = ", ".join(f"{percent(score.against)} at {score.speed_mm_s:g} mm/s" for score in own)
    better, circles = (sum(getattr(score, name) for score in own) for name in ("better_on", "circles"))
    return (
        f"Feed-forward from the extended model against dynamic LuGre with nominal parameters, mean RMS path error: "
        f"{said}; smaller on {better} of {circles} circles that no round recorded."
    )
