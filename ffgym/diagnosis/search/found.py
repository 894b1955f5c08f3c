"""What a search finds: rounds of candidates that were fitted, and what was adopted."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from ffgym.core.types import Array
from ffgym.diagnosis.fit.fit import Fit
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.result import Rival
from ffgym.diagnosis.search.candidates import Candidates
from ffgym.diagnosis.search.ranking import Ranking


@dataclass(frozen=True, kw_only=True, eq=False)
class Tried:
    """A candidate, fitted."""

    fit: Fit
    left: Array
    """Energy left in each block by fits to others, both splits in mean, shape (B,)."""

    @property
    def hypothesis(self) -> Hypothesis:
        """The last one, that was tried."""
        return self.fit.hypotheses[-1]

    @property
    def total(self) -> float:
        """Energy left."""
        return float(self.left.sum())


@dataclass(frozen=True, kw_only=True, eq=False)
class Round:
    """One look at what is left: candidates by score, and those that were fitted, best first."""

    before: Tried
    ranking: Ranking
    tried: tuple[Tried, ...]
    adopted: bool
    alike: tuple[Rival, ...] = ()
    """Effects that are easily taken for what was adopted, by their scores."""

    def of(self, hypotheses: Iterable[Hypothesis]) -> Tried | None:
        """The first that was tried of some hypotheses, whatever values they came to have; None if none was."""
        known = tuple(hypotheses)
        return next((tried for tried in self.tried if tried.hypothesis.is_among(known)), None)


def found_in(rounds: Iterable[Round], hypothesis: Hypothesis) -> tuple[Round, Tried]:
    """The round in which a cause was found, and how it was tried there; of a wave that moved far, one of its effect."""
    tried = [(one, other) for one in rounds if one.adopted for other in one.tried]
    of_effect = [pair for pair in tried if pair[1].hypothesis.place == hypothesis.place]
    return next((pair for pair in of_effect if pair[1].hypothesis.repeats(hypothesis)), of_effect[0])


@dataclass(frozen=True, kw_only=True, eq=False)
class Found:
    """What a search found."""

    nominal: Tried
    candidates: Candidates
    """Of the first round; those of later ones take much memory, and nothing is asked of them."""
    final: Tried
    """With all causes that are sure, or with all if none is; the nominal model if they explain too little."""
    whole: Tried
    """With those causes too that cannot be told from a rival: what it leaves, neither of them explains."""
    rounds: tuple[Round, ...]
    rivals: tuple[Rival, ...]
    unsure: tuple[Hypothesis, ...]
    """Further causes that cannot be told from a rival, beside others that are sure; not in the final model."""
    rows: float
    """Energy of noise alone."""

    @property
    def without_causes(self) -> "Found":
        """The same search with nothing found."""
        return replace(self, final=self.nominal, whole=self.nominal, rivals=(), unsure=())
