"""A mistake in wiring, with what speaks for it."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.logs.quality.wiring.hypothesis import Hypothesis
from ffgym.logs.quality.wiring.score import Channel, Lefts


@final
@dataclass(frozen=True, kw_only=True)
class Found:
    """A mistake with what speaks for it."""

    hypothesis: Hypothesis
    gain: float
    before: Lefts
    after: Lefts

    @property
    def worth(self) -> float:
        """Gain less what a simpler mistake may lack."""
        return self.gain - self.hypothesis.cost

    @property
    def telling(self) -> Channel:
        """The signal that it explains most."""
        return max(self.before, key=lambda key: np.log(self.before[key] / self.after.get(key, self.before[key])))
