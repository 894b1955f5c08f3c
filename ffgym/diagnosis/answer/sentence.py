"""The verdict in one sentence."""

from collections import Counter
from collections.abc import Sequence

from ffgym.diagnosis.answer.verdict import Judged
from ffgym.diagnosis.result import Cause, Pattern, Rival
from ffgym.robot import RobotDescription

_PATTERNS = 3
"""Components of which the sentence says what is left there depends on; chosen: more are in the list of patterns."""

_AS_MUCH = 0.9
"""Share of what the strongest pattern of a component explains from which on another one stands beside it in the
sentence; chosen: chance orders two that are so near."""


def sentence_of(
    judged: Judged,
    causes: Sequence[Cause],
    rivals: Sequence[Rival],
    patterns: Sequence[Pattern],
    robot: RobotDescription,
) -> str:
    """What a diagnosis says, in one sentence."""
    tied = [rival for rival in rivals if rival.tied]
    instead = [rival for rival in tied if rival.against in {cause.label for cause in causes}]
    left = "; ".join(_strongest(patterns))
    named, others = _all_of(causes), _any_of(tied)
    share = f"{100 * min(judged.removed, 1.0):.0f} %"
    if judged.verdict == "none":
        return f"These motions do not falsify the model of {robot.name}: what is left is noise and calibration."
    if judged.verdict == "unknown":
        what = left or "nothing that was looked for"
        return f"Something is there that no effect of the library explains; what is left depends on: {what}."
    if judged.verdict == "ambiguous":
        return f"Consistent with {named}; but {others} would explain these motions as well."
    if judged.verdict == "partly":
        more = f"; what is left depends on: {left}" if left else ", and something is left"
        if judged.stretched:
            more = f", and {judged.stretched[0]} is at the end of what is plausible: it may stand for something else"
        elif beyond := [rival for rival in tied if rival not in instead]:
            then = f"; what is left then depends on: {left}" if left else ""
            more = f"; beyond that, {_any_of(beyond)} would explain more{then}"
        besides = f" (these logs cannot tell it from {_any_of(instead)})" if instead else ""
        return f"Partly explained by {named}{besides}: that removes {share} of what noise does not explain{more}."
    return f"Consistent with {named}, which removes {share} of what noise does not explain."


def _strongest(patterns: Sequence[Pattern]) -> list[str]:
    """The strongest pattern of each of the first few components that have one, and those that explain as much."""
    first: dict[tuple[str, str], Pattern] = {}
    for pattern in patterns:
        first.setdefault((pattern.channel, pattern.component), pattern)
    chosen = list(first.values())[:_PATTERNS]
    return [
        pattern.message
        for best in chosen
        for pattern in patterns
        if (pattern.channel, pattern.component) == (best.channel, best.component)
        and (pattern is best or pattern.share > _AS_MUCH * best.share)
    ]


def _all_of(causes: Sequence[Cause]) -> str:
    """Each effect on its joint once, however many waves it has."""
    counts = Counter(_named(cause) for cause in causes)
    return ", and ".join(name if n == 1 else f"{name} in {n} waves" for name, n in counts.items())


def _any_of(rivals: Sequence[Rival]) -> str:
    return " or ".join(dict.fromkeys(_place(rival.effect, rival.joint) for rival in rivals))


def _named(cause: Cause) -> str:
    return f"{cause.title} {'of ' + cause.joint if cause.joint else ''}".strip()


def _place(effect: str, joint: str) -> str:
    return f"{effect.replace('_', ' ')} of {joint}" if joint else effect.replace("_", " ")
