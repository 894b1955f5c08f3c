"""What is named where rivals tie with causes."""

from collections.abc import Sequence

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.result import Rival, label_of
from ffgym.diagnosis.search.found import Round, found_in
from ffgym.diagnosis.search.rivals import ALIKE_TEXT


def tied_among(hypotheses: Sequence[Hypothesis], rivals: Sequence[Rival]) -> list[Hypothesis]:
    """Hypotheses that a rival cannot be told from."""
    against = {rival.against for rival in rivals if rival.tied}
    return [hypothesis for hypothesis in hypotheses if hypothesis.label in against]


def as_rivals(unsure: Sequence[Hypothesis], rivals: Sequence[Rival], rounds: Sequence[Round]) -> tuple[Rival, ...]:
    """Causes that were dropped because a rival cannot be told from them, as rivals of that one."""
    gains = {rival.against: rival for rival in rivals if rival.tied}
    return tuple(
        Rival(
            effect=one.kind.name,
            joint=one.joint,
            held_out_gain=_gain(one, rounds),
            tied=True,
            against=label_of(gains[one.label].effect, gains[one.label].joint),
            reason=ALIKE_TEXT,
        )
        for one in unsure
    )


def _gain(hypothesis: Hypothesis, rounds: Sequence[Round]) -> float:
    """Share of the energy that a cause removed in the round in which it was found."""
    one, tried = found_in(rounds, hypothesis)
    return 1.0 - tried.total / one.before.total
