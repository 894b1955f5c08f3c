"""Rivals that a log cannot rule out, as it lacks what they vary with: without a temperature, a drift is a drift."""

from collections.abc import Sequence
from dataclasses import replace

from ffgym.diagnosis.answer.verdict import Judged
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.result import Rival, Unjudged
from ffgym.effects import EFFECTS


def blind_rivals(causes: Sequence[Hypothesis], not_judgeable: Sequence[Unjudged]) -> tuple[Rival, ...]:
    """Of causes that vary over a session, the effects that vary with what the log does not show and look alike."""
    unseen = [(kind, one.reason) for one in not_judgeable if (kind := EFFECTS[one.effect]).varies_with]
    return tuple(
        Rival(
            effect=kind.name,
            joint=cause.joint,
            held_out_gain=0.0,
            tied=True,
            against=cause.label,
            reason=f"cannot be judged: {reason}; a log that shows it tells both apart",
        )
        for cause in causes
        for kind, reason in unseen
        if cause.kind.varies_with and kind.code in cause.kind.confusable_with
    )


def beside_blind(judged: Judged, rivals: Sequence[Rival]) -> Judged:
    """The verdict where there are such rivals: nothing that has one is named without reserve."""
    return replace(judged, verdict="ambiguous") if rivals and judged.verdict == "named" else judged


def told(judged: Judged, rivals: Sequence[Rival]) -> Sequence[Rival]:
    """Those of such rivals that belong to a verdict: of one that names causes, all."""
    return rivals if judged.verdict in ("ambiguous", "partly") else ()
