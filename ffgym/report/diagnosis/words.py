"""How verdicts, effects, places and sizes are written for people."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from ffgym.diagnosis.result import Cause, Diagnosis, Rival, Size, Unjudged, Verdict
from ffgym.effects import EFFECTS

VERDICTS: Mapping[Verdict, str] = MappingProxyType(
    {
        "none": "these motions do not falsify the model",
        "named": "causes explain what the model lacks",
        "partly": "a cause explains much, and something is left",
        "ambiguous": "several causes explain it as well, and one more motion would tell them apart",
        "unknown": "something is there that no effect of the library explains; patterns say what it depends on",
        "wiring": "columns are not what they are called; no physical cause was looked for",
        "insufficient": "these logs do not allow a diagnosis",
    }
)
"""What each verdict means."""


def place_of(effect: str, joint: str) -> str:
    """An effect with its joint, e.g. 'load friction, j2'."""
    return effect.replace("_", " ") + (f", {joint}" if joint else "")


def title_of(effect: str) -> str:
    """What an effect is, in words; its name if the library does not know it."""
    return EFFECTS[effect].title if effect in EFFECTS else effect.replace("_", " ")


def signature_of(effect: str) -> str:
    """How an effect shows in measurements; nothing if the library does not know it."""
    return EFFECTS[effect].signature if effect in EFFECTS else ""


def size_text(size: Size) -> str:
    """A size with unit and interval."""
    unit = "" if size.unit == "1" else f" {size.unit}"
    low, high = size.interval
    return f"{size.name} = {size.value:.3g}{unit} ({low:.3g} to {high:.3g})"


def rivals_of(diagnosis: Diagnosis, cause: Cause) -> list[Rival]:
    """Rivals of a cause, ties first, then those that explain most; they name its effect, with or without its joint."""
    names = (cause.effect, f"{cause.effect} on {cause.joint}")
    own = [rival for rival in diagnosis.rivals if rival.against in names]
    return sorted(own, key=lambda rival: (not rival.tied, -rival.held_out_gain))


def together(unjudged: Sequence[Unjudged]) -> list[tuple[str, str]]:
    """Effects with their joints, and the reason; those that share a reason stand together."""
    joints: dict[tuple[str, str], list[str]] = {}
    for one in unjudged:
        joints.setdefault((one.reason, one.effect), []).append(one.joint)
    reasons: dict[str, list[str]] = {}
    for (reason, effect), places in joints.items():
        where = ", ".join(place for place in places if place)
        reasons.setdefault(reason, []).append(effect.replace("_", " ") + (f" ({where})" if where else ""))
    return [("; ".join(effects), reason) for reason, effects in reasons.items()]
