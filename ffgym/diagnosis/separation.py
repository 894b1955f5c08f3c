r"""Design of the session that tells rival causes apart soonest, and of how surely it would.

With the predictions of two causes d apart, each channel in units of its noise, the logarithm of the likelihood ratio
has the expectation

.. math:: \tfrac12 \min_x \left( \lVert d - A x \rVert^2 + x^T P x \right)

where A has what the wrong cause could change to look like the right one: calibration errors within their priors P and
bounds, and its own numbers, as far as they are open.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.computing import FAILED
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.problem import compute_exchange_changes, compute_tangents
from ffgym.diagnosis.log import Log, assemble_log
from ffgym.diagnosis.normal_equations import build_design_matrix
from ffgym.diagnosis.nuisance import ParameterPrior, list_nuisance_parameters
from ffgym.diagnosis.perturbation import Parts
from ffgym.diagnosis.replay import replay
from ffgym.diagnosis.resampling import cut_blocks
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.residual_rows import find_valid_rows
from ffgym.diagnosis.result import SeparatingMotion
from ffgym.diagnosis.search.rounds import SearchResult
from ffgym.diagnosis.sessions import SessionProposal, propose_sessions
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import solve_bounded
from ffgym.robot import RigidArm
from ffgym.simulation import SimulatedRig
from ffgym.simulation.plant import Climate, Machine
from ffgym.simulation.protocols import SessionMotion, plan_session, record


@dataclass(frozen=True, kw_only=True, eq=False)
class ForeseenSession:
    """Sums of two or more causes' predictions over planned motions, by motion."""

    gram: Array
    """Gram matrices of all columns: causes, nuisance parameters, numbers of the causes; shape (M, P, P)."""
    n_causes: int
    sigma: Array
    """Prior of each column beyond the causes, shape (P - H,)."""
    owner: Array
    """Cause of each of them, -1 for nuisance parameters, shape (P - H,)."""

    def ratio(self, motions: Sequence[int], right: int, wrong: int) -> float:
        """Compute the expected log-likelihood ratio of cause `right` to cause `wrong` from some motions."""
        gram = self.gram[list(motions)].sum(axis=0)
        apart = np.zeros(len(gram))
        apart[right], apart[wrong] = 1.0, -1.0
        free = self.n_causes + np.flatnonzero((self.owner == -1) | (self.owner == wrong))
        sigma = self.sigma[free - self.n_causes]
        scaled = gram[np.ix_(free, free)] * np.outer(sigma, sigma)
        pull = sigma * (gram @ apart)[free]
        bound = np.full(len(free), settings().prior.bound)
        x = solve_bounded(scaled, pull, np.ones(len(free)), -bound, bound)
        return float(0.5 * (apart @ gram @ apart - 2 * x @ pull + x @ scaled @ x + x @ x))


def foresee(
    log: Log,
    nominal: Machine,
    causes: Sequence[Hypothesis],
    noise: Mapping[Channel, Array],
    prior: ParameterPrior,
) -> ForeseenSession:
    """Foresee what causes would show along planned motions.

    Args:
        log: of the motions as the nominal machine makes them, without noise.
        nominal: the machine without the causes.
        causes: two or more.
        noise: RMS that noise gives each component of each channel, shape (C,).
        prior: what is known of the nominal numbers.
    """
    # columns: what each cause changes, nuisance parameters, and the numbers of the causes
    run = replay(log, nominal)
    shown: list[Parts] = list(compute_exchange_changes(run, [cause.on(nominal) for cause in causes]))
    nuisances = list_nuisance_parameters(run, prior)
    own = [
        (i, column)
        for i, cause in enumerate(causes)
        for column in compute_tangents(replace(run, machine=cause.on(nominal)), nominal, [cause])
    ]
    columns = [*shown, *(nuisance.column.parts for nuisance in nuisances), *(column for _, column in own)]
    # Gram matrices of weighted columns, by motion
    weights = {(c, k): np.full(len(log.names), 1 / x) for c, rms in noise.items() for k, x in enumerate(rms)}
    known = [{key: rows for key, rows in column.items() if key in weights} for column in columns]
    shape = (len(log.sampling.at), len(log.names), 1)
    blocks = cut_blocks(find_valid_rows(log), log.sampling.row_dt)
    equations = build_design_matrix(blocks, known, weights).form_equations({key: np.zeros(shape) for key in weights})
    by_motion = [equations.gram[blocks.motion == m].sum(axis=0) for m in range(len(log.names))]
    return ForeseenSession(
        gram=np.stack(by_motion),
        n_causes=len(causes),
        sigma=np.array([*(nuisance.sigma for nuisance in nuisances), *(settings().rivals.foreseen_width for _ in own)]),
        owner=np.array([*(-1 for _ in nuisances), *(i for i, _ in own)]),
    )


WARMING = Climate(rise=np.array([15.0]))
"""Assumed of a machine of unknown climate, to see what warming up would show: 15 K (Bittencourt 2010: 20 to 40
K over a day), within 20 min."""


def design_separating_motion(
    arm: RigidArm,
    nominal: Machine,
    causes: Sequence[Hypothesis],
    noise: Mapping[Channel, Array],
    *,
    prior: ParameterPrior | None = None,
) -> SeparatingMotion | None:
    """Design the session that tells causes apart with the largest log-likelihood ratio per second; None if none can.

    Sessions that the effects themselves advise are tried first, all others only if none of those is sure enough. The
    ratio is that of the two causes that are hardest to tell apart, whichever of them is right.

    Args:
        arm: of the nominal robot.
        nominal: the machine without the causes, with all that is already known of it.
        causes: two or more, as fitted.
        noise: RMS that noise gives each component of each channel that will be recorded, shape (C,).
        prior: what is known of the nominal numbers.

    Raises:
        FFGymError: if there are fewer than two causes.
    """
    if len(causes) < 2:
        raise FFGymError(f"It takes two causes to tell apart, got {[cause.label for cause in causes]}.")
    if nominal.climate is None:
        nominal = replace(nominal, climate=WARMING)
    # joints that causes act on or come from; all for a cause of the machine as a whole
    joints = {cause.joint for cause in causes} | {
        arm.robot.joints[cause.source] for cause in causes if cause.source is not None
    }
    # sessions that the effects advise first, then all others
    every = propose_sessions(
        arm.robot, [] if "" in joints else [joint for joint in arm.robot.joints if joint in joints]
    )
    advised = [p for p in every if p.is_advised([cause.kind for cause in causes])]
    for some in (advised, [p for p in every if p not in advised]):
        planned = _plan(arm, some)
        if (
            planned
            and (found := _choose_best(arm, nominal, planned, causes, noise, prior or ParameterPrior())) is not None
        ):
            return found
    return None


def _plan(arm: RigidArm, some: Sequence[SessionProposal]) -> list[tuple[SessionProposal, list[SessionMotion]]]:
    """Plan the proposals that the robot can make in the time allowed, and of which one motion can check another."""
    found = []
    for proposal in some:
        try:
            motions = plan_session(arm, proposal.protocols())
        except FFGymError:
            continue  # its ranges, speeds or torques do not allow this one; there are others
        if (
            len(motions) > 1
            and sum(motion.reference.duration for motion in motions) <= settings().rivals.longest_session
        ):
            found.append((proposal, motions))
    return found


def _choose_best(
    arm: RigidArm,
    nominal: Machine,
    planned: Sequence[tuple[SessionProposal, list[SessionMotion]]],
    causes: Sequence[Hypothesis],
    noise: Mapping[Channel, Array],
    prior: ParameterPrior,
) -> SeparatingMotion | None:
    """Choose the fastest of the sessions that are sure; None if none is."""
    # names of motions must differ from those of other sessions
    limits = settings().rivals
    motions = [
        replace(motion, reference=replace(motion.reference, name=f"{proposal.name}.{motion.reference.name}"))
        for proposal, own in planned
        for motion in own
    ]
    # simulate all sessions as one log of the nominal machine
    try:
        rig = SimulatedRig(arm=arm, machine=nominal)
        log = assemble_log(arm.robot, list(record(motions, rig, record_dt=limits.foreseen_dt)))
        unseen: dict[str, Any] = {
            name: None
            for channel, name in (("tool", "tool"), ("link", "link"), ("servo", "feedback"))
            if channel not in noise
        }
        foreseen = foresee(replace(log, **unseen), nominal, causes, noise, prior)
    except FAILED:
        return None  # a machine that cannot be simulated in these motions says nothing of them
    # keep sessions that tell the hardest pair of causes apart; take the fastest
    sure, first = [], 0
    for proposal, session in planned:
        own = range(first, first + len(session))
        first += len(session)
        # the smallest ratio between any two causes, whichever is right
        ratio, pair = min(
            (min(foreseen.ratio(own, a, b), foreseen.ratio(own, b, a)), (a, b))
            for a, b in combinations(range(len(causes)), 2)
        )
        if ratio >= limits.log_ratio:
            lasts = float(session[-1].end - session[0].start)  # from the first start to the last end
            sure.append((ratio / lasts, proposal, pair))
    if not sure:
        return None
    rate, proposal, (a, b) = max(sure, key=lambda one: one[0])
    return SeparatingMotion(
        between=(causes[a].label, causes[b].label), protocol=proposal.name, toml=proposal.toml(), expected=rate
    )


def propose_next_motion(
    found: SearchResult, nominal: Machine, floor: Mapping[Channel, Array], prior: ParameterPrior
) -> SeparatingMotion | None:
    """Propose the session that would tell the first tied causes apart; None without ties, or if no session is sure to.

    Args:
        found: has the rivals as they were fitted, and says which of them are tied.
        nominal: the model that was diagnosed.
        floor: RMS of noise alone, (M, C) by channel.
        prior: what is known of the nominal numbers.
    """
    for causes in _list_tied(found):
        known = nominal
        for other in found.final.fit.hypotheses:
            if other.key not in {cause.key for cause in causes}:
                known = other.on(known)
        noise = {channel: rms(level, 0) for channel, level in floor.items()}
        arm = RigidArm(nominal.robot)
        planned = design_separating_motion(arm, known, causes, noise, prior=prior)
        if planned is not None:
            return planned
    return None


def _list_tied(found: SearchResult) -> list[Sequence[Hypothesis]]:
    """List causes, each with those that tie with it."""
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
