"""Effects that are easily taken for a cause, where none came near enough to be fitted in its place.

A reader who expects one of them sees that it was looked at, and how much less it explains.
"""

from ffgym.diagnosis.fit.setting import Setting
from ffgym.diagnosis.result import Rival
from ffgym.diagnosis.search.candidates import Candidates
from ffgym.diagnosis.search.found import Round, Tried
from ffgym.diagnosis.search.ranking import Ranking
from ffgym.diagnosis.search.worth import removed_by


def lookalikes(
    setting: Setting, candidates: Candidates, ranking: Ranking, before: Tried, adopted: Tried
) -> tuple[Rival, ...]:
    """Rivals of a cause by the library's list of confusable effects, each with the best of its shapes.

    Args:
        setting: the log.
        candidates: that were ranked.
        ranking: their scores, on rows that were not used.
        before: the model without the cause.
        adopted: the model with it.
    """
    cause, scores = adopted.hypothesis, dict[tuple[str, str], float]()
    for i in ranking.order.tolist():  # the best shape of an effect comes first
        column = candidates.first(candidates.groups[i])
        if column.effect.code in (cause.kind.code, *cause.kind.confusable_with) and column.joint in ("", cause.joint):
            scores.setdefault((column.effect.name, column.joint), max(0.0, float(ranking.score[i])))
    own = scores.pop((cause.kind.name, cause.joint), 0.0)
    if own <= 0:
        return ()
    gain = removed_by(setting, before, adopted).of_excess
    return tuple(
        Rival(
            effect=effect,
            joint=joint,
            held_out_gain=gain * score / own,
            tied=False,
            against=cause.label,
            reason=f"explains {score / own:.0%} of what {cause.label} does, on rows that were not used",
        )
        for (effect, joint), score in scores.items()
    )


def without_rival(rounds: tuple[Round, ...], final: Tried, rivals: tuple[Rival, ...]) -> tuple[Rival, ...]:
    """Lookalikes of the causes that nothing was compared with.

    Args:
        rounds: in which the causes were found.
        final: the model with all of them.
        rivals: effects that were fitted in the place of a cause.
    """
    compared = {rival.against for rival in rivals}
    causes = {hypothesis.label for hypothesis in final.fit.hypotheses}
    names = {(hypothesis.kind.name, hypothesis.joint) for hypothesis in final.fit.hypotheses}
    return tuple(
        alike
        for one in rounds
        for alike in one.alike
        if alike.against in causes - compared and (alike.effect, alike.joint) not in names
    )
