"""From a pattern to the effects that have its form, each with the reason why it is no cause."""

from collections.abc import Sequence
from dataclasses import replace

from ffgym.diagnosis.result import Cause, Pattern, Rival, Unjudged
from ffgym.effects import EFFECTS, Effect, ResolverEffect

_QUIET = "it explains no more of motions that were not used than chance, or than a cause must"


def with_leads(
    patterns: Sequence[Pattern],
    causes: Sequence[Cause],
    rivals: Sequence[Rival],
    not_excited: Sequence[Unjudged],
    not_judgeable: Sequence[Unjudged],
) -> tuple[Pattern, ...]:
    """Patterns with the effects that have their form, and why these are no causes."""
    return tuple(
        replace(pattern, leads=_leads(pattern, causes, rivals, (*not_judgeable, *not_excited))) for pattern in patterns
    )


def _leads(
    pattern: Pattern, causes: Sequence[Cause], rivals: Sequence[Rival], unjudged: Sequence[Unjudged]
) -> tuple[str, ...]:
    """One sentence for each effect of that form."""
    return tuple(
        f"{kind.title}: {_reason(kind.name, pattern.component, causes, rivals, unjudged)}"
        for kind in effects_of_form(pattern)
        if kind.side == "motor" or pattern.channel != "servo"
    )


def effects_of_form(pattern: Pattern) -> list[type[Effect]]:
    """Effects whose equation has the form of a pattern of its own joint, the nearest first.

    Of those that are as near, torques come before springs, and what acts before what is measured.
    """
    form = (pattern.kind, pattern.variable)
    found = [kind for kind in EFFECTS.values() if form in kind.patterns]
    return sorted(
        found, key=lambda kind: (kind.patterns.index(form), issubclass(kind, ResolverEffect), kind.needs_elasticity)
    )


def _reason(
    effect: str, joint: str, causes: Sequence[Cause], rivals: Sequence[Rival], unjudged: Sequence[Unjudged]
) -> str:
    """Why an effect of a joint does not explain a pattern."""
    here = ("", joint)
    if any(cause.effect == effect and cause.joint in here for cause in causes):
        return "it is a cause; what is left has another form than its equation"
    for one in unjudged:
        if one.effect == effect and one.joint in here:
            return one.reason
    lost = [rival for rival in rivals if rival.effect == effect and rival.joint in here]
    return lost[0].reason if lost else _QUIET
