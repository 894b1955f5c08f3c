"""What to record next where several causes explain a log alike."""

from collections.abc import Mapping, Sequence

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.calibration import Calibration
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.result import SeparatingMotion
from ffgym.diagnosis.search.found import Found
from ffgym.diagnosis.separation import separating_motion
from ffgym.robot import RigidArm
from ffgym.simulation.plant import Machine


def next_motion(
    found: Found, nominal: Machine, floor: Mapping[Channel, Array], calibration: Calibration
) -> SeparatingMotion | None:
    """The session that would tell the first tied causes apart; None if none are tied, or no session is sure to.

    Args:
        found: has the rivals as they were fitted, and says which of them are tied.
        nominal: the model that was diagnosed.
        floor: RMS of noise alone, (M, C) by channel.
        calibration: what is known of the nominal numbers.
    """
    for causes in _tied(found):
        known = nominal
        for other in found.final.fit.hypotheses:
            if other.place not in {cause.place for cause in causes}:
                known = other.on(known)
        noise = {channel: np.sqrt(np.mean(rms**2, axis=0)) for channel, rms in floor.items()}
        arm = RigidArm(nominal.robot)
        planned = separating_motion(arm, known, causes, noise, calibration=calibration)
        if planned is not None:
            return planned
    return None


def _tied(found: Found) -> list[Sequence[Hypothesis]]:
    """Causes, each with those that tie with it."""
    causes = (*found.final.fit.hypotheses, *found.unsure)
    groups: list[Sequence[Hypothesis]] = []
    for one in found.rounds:
        tried = one.of(causes) if one.adopted else None
        if tried is None:
            continue
        best = next(h for h in causes if tried.hypothesis.repeats(h))
        ties = {(r.effect, r.joint) for r in found.rivals if r.tied and r.against == best.label}
        others = [t.hypothesis for t in one.tried if (t.hypothesis.kind.name, t.hypothesis.joint) in ties]
        if others:
            groups.append((best, *others))
    return groups
