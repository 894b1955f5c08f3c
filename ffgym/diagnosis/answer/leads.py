"""From a pattern to the effects that have its form, each with the reason why it is no cause."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from ffgym.diagnosis.result import Cause, Pattern, PatternKind, Rival, Unjudged
from ffgym.effects import EFFECTS

FORMS: Mapping[tuple[PatternKind, str], tuple[str, ...]] = MappingProxyType(
    {
        ("sign-locked function", "load"): ("load_friction",),
        ("sign-locked function", "motor angle"): ("position_friction",),
        ("sign-locked function", "size of the motor speed"): ("nonlinear_viscous", "falling_friction"),
        ("sign-locked function", "motor speed"): ("coulomb_level", "asymmetry"),
        ("sign-locked function", "temperature"): ("temperature_friction",),
        ("sign-locked function", "time"): ("viscous_drift", "coulomb_drift"),
        ("sign-locked function", "travel since the last reversal"): ("presliding",),
        ("sign-locked function", "time at rest before the move"): ("dwell_stiction",),
        ("function", "motor speed"): ("viscous_level", "nonlinear_viscous", "asymmetry"),
        ("function", "size of the motor speed"): ("asymmetry",),
        ("function", "motor acceleration"): ("rotor_inertia",),
        ("function", "motor angle"): ("gravity_term", "cable_pull"),
        ("function", "load"): ("torque_constant", "payload"),
        ("periodic", "motor angle"): ("cogging", "torque_ripple", "kinematic_error", "resolver_ripple"),
    }
)
"""Effects whose equation has the form of a pattern of its own joint."""

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
    found = []
    for effect in FORMS.get((pattern.kind, pattern.variable), ()):
        if EFFECTS[effect].side != "motor" and pattern.channel == "servo":
            continue
        found.append(f"{EFFECTS[effect].title}: {_reason(effect, pattern.component, causes, rivals, unjudged)}")
    return tuple(found)


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
