"""The choice of the motion that tells rival causes apart, soonest."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.diagnosis.calibration import Calibration
from ffgym.diagnosis.failures import FAILED
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.result import SeparatingMotion
from ffgym.diagnosis.separation.expected import Foreseen, foresee, planned_log
from ffgym.diagnosis.separation.proposals import Proposal, proposals
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation.plant import Climate, Machine
from ffgym.simulation.protocols import SessionMotion, plan_session

SURE = 20.0
"""Log-likelihood ratio that a session should give; chosen: three times the logarithm of the number of effects and
joints, so that half of the session still decides."""

LONGEST = 90.0
"""Longest motions of a session together [s]: those of the first recording of a machine."""

WARMING = Climate(rise=np.array([15.0]))
"""Assumed of a machine whose climate nobody knows, to see what warming up would show: 15 K (Bittencourt 2010: 20 to 40
K over a day), within 20 min."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Planned:
    """A proposal as motions of a robot."""

    proposal: Proposal
    motions: list[SessionMotion]

    @property
    def lasts(self) -> float:
        """From the first start to the last end [s]."""
        return float(self.motions[-1].end - self.motions[0].start)


def separating_motion(
    arm: RigidArm,
    nominal: Machine,
    causes: Sequence[Hypothesis],
    noise: Mapping[Channel, Array],
    *,
    calibration: Calibration | None = None,
) -> SeparatingMotion | None:
    """The session that tells causes apart with the largest log-likelihood ratio per second; None if none can.

    Sessions that the effects themselves advise are tried first, all others only if none of those is sure enough. The
    ratio is that of the two causes that are hardest to tell apart, whichever of them is right.

    Args:
        arm: of the nominal robot.
        nominal: the machine without the causes, with all that is already known of it.
        causes: two or more, as fitted.
        noise: RMS that noise gives each component of each channel that will be recorded, shape (C,).
        calibration: what is known of the nominal numbers.

    Raises:
        FFGymError: if there are fewer than two causes.
    """
    if len(causes) < 2:
        raise FFGymError(f"It takes two causes to tell apart, got {[cause.label for cause in causes]}.")
    if nominal.climate is None:
        nominal = replace(nominal, climate=WARMING)
    every = proposals(arm.robot, _joints(causes, arm.robot))
    advised = [p for p in every if p.is_advised([cause.kind for cause in causes])]
    for some in (advised, [p for p in every if p not in advised]):
        planned = _planned(arm, some)
        if planned and (found := _best(arm, nominal, planned, causes, noise, calibration or Calibration())) is not None:
            return found
    return None


def _joints(causes: Sequence[Hypothesis], robot: RobotDescription) -> list[str]:
    """Joints that causes act on or come from; none is all, for a cause of the machine as a whole."""
    if any(not cause.joint for cause in causes):
        return []
    sources = {robot.joints[cause.source] for cause in causes if cause.source is not None}
    return [joint for joint in robot.joints if joint in sources | {cause.joint for cause in causes}]


def _planned(arm: RigidArm, some: Sequence[Proposal]) -> list[_Planned]:
    """Proposals that the robot can make, that do not take too long, and of which one motion can check another."""
    found = []
    for proposal in some:
        try:
            motions = plan_session(arm, proposal.protocols())
        except FFGymError:
            continue  # its ranges, speeds or torques do not allow this one; there are others
        if len(motions) > 1 and sum(motion.reference.duration for motion in motions) <= LONGEST:
            found.append(_Planned(proposal=proposal, motions=motions))
    return found


def _best(
    arm: RigidArm,
    nominal: Machine,
    planned: Sequence[_Planned],
    causes: Sequence[Hypothesis],
    noise: Mapping[Channel, Array],
    calibration: Calibration,
) -> SeparatingMotion | None:
    """The fastest of the sessions that are sure; None if none is."""
    motions = [_named(p, motion) for p in planned for motion in p.motions]
    try:
        foreseen = foresee(planned_log(arm, nominal, motions, list(noise)), nominal, causes, noise, calibration)
    except FAILED:
        return None  # a machine that cannot be simulated in these motions says nothing of them
    sure, first = [], 0
    for p in planned:
        own = range(first, first + len(p.motions))
        first += len(p.motions)
        ratio, pair = _hardest(foreseen, own, len(causes))
        if ratio >= SURE:
            sure.append((ratio / p.lasts, p.proposal, pair))
    if not sure:
        return None
    rate, proposal, (a, b) = max(sure, key=lambda one: one[0])
    return SeparatingMotion(
        between=(causes[a].label, causes[b].label), protocol=proposal.name, toml=proposal.toml(), expected=rate
    )


def _named(planned: _Planned, motion: SessionMotion) -> SessionMotion:
    """A motion whose name differs from those of other sessions."""
    name = f"{planned.proposal.name}.{motion.reference.name}"
    return replace(motion, reference=replace(motion.reference, name=name))


def _hardest(foreseen: Foreseen, motions: Sequence[int], n_causes: int) -> tuple[float, tuple[int, int]]:
    """Smallest ratio between any two causes, whichever is right, and which two these are."""
    pairs = combinations(range(n_causes), 2)
    return min((min(foreseen.ratio(motions, a, b), foreseen.ratio(motions, b, a)), (a, b)) for a, b in pairs)
