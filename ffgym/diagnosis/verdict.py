"""The verdict and its sentence: how much causes explain, what ties with them, and what is left."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from ffgym.diagnosis.fit.fit import Fit, Loudness, compute_explained, find_touched
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.problem import FitProblem
from ffgym.diagnosis.held_out_share import compute_held_out_share, find_loudest, name_place
from ffgym.diagnosis.result import Cause, Level, Pattern, Rival, UnjudgedEffect, Verdict
from ffgym.diagnosis.search.rivals import select_tied
from ffgym.diagnosis.search.rounds import SearchResult, find_adoption
from ffgym.diagnosis.search.significance import compute_explained_by_newest, find_shapes_at_limit
from ffgym.diagnosis.settings import settings
from ffgym.effects import EFFECTS
from ffgym.robot import RobotDescription


@dataclass(frozen=True, kw_only=True, eq=False)
class ReasonedVerdict:
    """Verdict with its reasons in numbers."""

    verdict: Verdict
    gains: tuple[float, ...]
    """Share of the energy above the noise that each cause explains on held-out rows."""
    explained: float
    """Share of the energy above the noise that all causes explain together."""
    shapes_at_limit: tuple[str, ...]
    """Shapes at the end of their plausible range, such as 'time of dwell_stiction on j5': they may stand for something
    else."""


def judge(problem: FitProblem, found: SearchResult, loud_before: Loudness, loud_after: Loudness) -> ReasonedVerdict:
    """Judge the result of a search.

    Args:
        problem: the log.
        found: by the search.
        loud_before: energy of the nominal residual over that of noise, by component.
        loud_after: the same with the causes.
    """
    # energy above noise that all causes explain together
    where = find_touched(problem, list(found.final.fit.columns))
    share = compute_explained(loud_before, loud_after, where).of_excess if where else 0.0
    # share that each cause removed of the energy above the noise that was there when it was found
    then = [find_adoption(found.rounds, hypothesis) for hypothesis in found.final.fit.hypotheses]
    gains = tuple(compute_explained_by_newest(problem, one.before, tried).of_excess for one, tried in then)
    # loudest component, and shapes that are not plausible
    worst = max(value - problem.inexact(key) for key, value in loud_after.items())
    shapes_at_limit = name_shapes_at_limit(problem, found.final.fit)
    verdict: Verdict
    if not found.final.fit.hypotheses:
        verdict = "unknown" if worst > settings().significance.quiet else "none"
    elif select_tied(found.final.fit.hypotheses, found.rivals):
        verdict = "ambiguous"
    elif (
        _is_explained(loud_before, loud_after)
        and min(gains) >= settings().verdict.each
        and not (shapes_at_limit or found.unsure)
    ):
        verdict = "named"
    else:
        verdict = "partly"
    return ReasonedVerdict(verdict=verdict, gains=gains, explained=float(share), shapes_at_limit=shapes_at_limit)


def _is_explained(before: Loudness, after: Loudness) -> bool:
    """Tell whether every component is quiet or mostly explained by the causes."""
    return all(
        after[key] <= settings().significance.quiet
        or before[key] - after[key] >= settings().verdict.named * (before[key] - 1.0)
        for key in after
    )


def name_shapes_at_limit(problem: FitProblem, fit: Fit) -> tuple[str, ...]:
    """Name shapes that the fit has moved to the end of their plausible range, such as 'time of cogging on j1'."""
    return tuple(f"{name} of {hypothesis.label}" for hypothesis, name in find_shapes_at_limit(problem, fit))


_UNSEEN_ARM = "the log has neither a tracked tool position nor encoders behind the gearbox"


def list_blind_rivals(
    causes: Sequence[Hypothesis], not_judgeable: Sequence[UnjudgedEffect], *, sees_arm: bool = True
) -> tuple[Rival, ...]:
    """List rivals that the log cannot show.

    Similar effects that vary over a session with a quantity that it lacks, and those that torque does not tell from
    effects of the arm, where nothing `sees_arm`.
    """
    unseen = [(kind, one.reason) for one in not_judgeable if (kind := EFFECTS[one.effect]).varies_with]
    pairs = [
        (cause, kind, reason)
        for cause in causes
        for kind, reason in unseen
        if cause.kind.varies_with and kind.code in cause.kind.confusable_with
    ]
    for cause in () if sees_arm else causes:
        pairs += [(cause, kind, _UNSEEN_ARM) for kind in EFFECTS.values() if kind.code in cause.kind.alike_in_torque]
    return tuple(
        Rival(
            effect=kind.name,
            joint=cause.joint,
            held_out_gain=0.0,
            tied=True,
            against=cause.label,
            reason=f"cannot be judged: {reason}; a log that shows it tells both apart",
        )
        for cause, kind, reason in pairs
    )


def weaken_for_blind_rivals(judged: ReasonedVerdict, rivals: Sequence[Rival]) -> ReasonedVerdict:
    """Weaken a verdict that has such rivals: no cause that has one is named without reserve."""
    return replace(judged, verdict="ambiguous") if rivals and judged.verdict == "named" else judged


def select_reported(judged: ReasonedVerdict, rivals: Sequence[Rival]) -> Sequence[Rival]:
    """Select rivals that are reported: all for a verdict with causes and reserve, none for others."""
    return rivals if judged.verdict in ("ambiguous", "partly") else ()


def describe_explained(judged: ReasonedVerdict, causes: Sequence[Cause], levels: Sequence[Level], motions: int) -> str:
    """Describe the share of the misfit that causes explain, and the data on which they do.

    The data are what was left out of the fit: motions in turn, or halves of a single one; all rows if nothing was.
    """
    held_out = compute_held_out_share(levels, [cause.joint for cause in causes])
    if held_out is None:
        return f"{100 * min(judged.explained, 1.0):.0f} % of the misfit, on the rows that were fitted"
    data = "motions" if motions > 1 else "the half of the log"
    return f"{100 * held_out.share:.0f} % of the misfit in {held_out.place}, on {data} left out of the fit"


def write_sentence(
    judged: ReasonedVerdict,
    causes: Sequence[Cause],
    rivals: Sequence[Rival],
    patterns: Sequence[Pattern],
    robot: RobotDescription,
    share: str,
    levels: Sequence[Level],
) -> str:
    """Write the verdict in one sentence; `share` says how much of the misfit the causes explain, and on which data."""
    # parts of the sentence
    tied = [rival for rival in rivals if rival.tied]
    instead = [rival for rival in tied if rival.against in {cause.label for cause in causes}]
    left = "; ".join(_select_strongest(patterns))
    # each effect on its joint once, however many waves it has
    counts = Counter(f"{cause.title} {('of ' + cause.joint if cause.joint else '')}".strip() for cause in causes)
    named = ", and ".join(name if n == 1 else f"{name} in {n} waves" for name, n in counts.items())
    # rivals that these motions cannot tell from the causes
    others = _join_names(tied)
    # the sentence of each verdict
    if judged.verdict == "none":
        return f"These motions do not falsify the model of {robot.name}: what is left is noise and calibration."
    if judged.verdict == "unknown":
        what = left or "nothing that was looked for"
        return f"Something is there that no effect of the library explains; what is left depends on: {what}."
    if judged.verdict == "ambiguous":
        return f"Consistent with {named}; but {others} would explain these motions as well."
    if judged.verdict == "partly":
        loudest = find_loudest(levels)
        place = f" in {name_place([loudest])}" if loudest else ""
        more = f"; what is left depends on: {left}" if left else f", and something is left{place}"
        # reason for the rest: a shape at its limit, a rival beyond the causes, or a pattern
        if judged.shapes_at_limit:
            more = (
                f", and {judged.shapes_at_limit[0]} is at the end of what is plausible: it may stand for something else"
            )
        elif beyond := [rival for rival in tied if rival not in instead]:
            then = f"; what is left then depends on: {left}" if left else ""
            more = f"; beyond that, {_join_names(beyond)} would explain more{then}"
        besides = f" (these logs cannot tell it from {_join_names(instead)})" if instead else ""
        return f"Partly explained by {named}{besides}: {share}{more}."
    explain = "explains" if len(counts) == 1 else "explain"
    return f"Consistent with {named}, which {explain} {share}."


def _select_strongest(patterns: Sequence[Pattern]) -> list[str]:
    """Select the strongest pattern of each of the first few components, and those that explain as much."""
    limits = settings().verdict
    first: dict[tuple[str, str], Pattern] = {}
    for pattern in patterns:
        first.setdefault((pattern.channel, pattern.component), pattern)
    chosen = list(first.values())[: limits.patterns]
    return [
        pattern.message
        for best in chosen
        for pattern in patterns
        if (pattern.channel, pattern.component) == (best.channel, best.component)
        and (pattern is best or pattern.share > limits.as_much * best.share)
    ]


def _join_names(rivals: Sequence[Rival]) -> str:
    """Join the names of effects, each on its joint once."""
    effects = [(rival.effect.replace("_", " "), rival.joint) for rival in rivals]
    return " or ".join(dict.fromkeys(f"{effect} of {joint}" if joint else effect for effect, joint in effects))
