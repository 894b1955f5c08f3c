r"""How surely a motion would tell causes apart: the log-likelihood ratio that noise-limited data would give.

With the predictions of two causes d apart, each channel in units of its noise, the logarithm of the likelihood ratio
has the expectation

.. math:: \tfrac12 \min_x \left( \lVert d - A x \rVert^2 + x^T P x \right)

where A has what the wrong cause could change to look like the right one: calibration errors within their priors P and
bounds, and its own numbers, as far as they are open.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.calibration import BOUND, Calibration, doubts_of
from ffgym.diagnosis.evidence.solve import bounded
from ffgym.diagnosis.evidence.stack import blocks_of, stack_of
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.tangents import tangents
from ffgym.diagnosis.log import Log, log_of
from ffgym.diagnosis.measured import valid_rows
from ffgym.diagnosis.replay import replay
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.signatures.exchange import exchanged
from ffgym.diagnosis.signatures.parts import Parts
from ffgym.robot import RigidArm
from ffgym.simulation import SimulatedRig
from ffgym.simulation.plant import Machine
from ffgym.simulation.protocols import SessionMotion, record

_SAMPLE_DT = 0.004
"""Sample time of what is foreseen [s]; chosen: up to 25 Hz is enough to choose a motion by."""

_FREE = 1.0
"""Standard deviation of a cause's own numbers, in practical steps (a third of what is plausible for a size); chosen:
the logs that led to the causes know them better than that, but not in every regime."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Foreseen:
    """Sums of two or more causes' predictions over planned motions, by motion."""

    gram: Array
    """Of all columns: causes, calibration, numbers of the causes; shape (M, P, P)."""
    n_causes: int
    sigma: Array
    """Prior of each column beyond the causes, shape (P - H,)."""
    owner: Array
    """Cause of each of them, -1 for calibration, shape (P - H,)."""

    def ratio(self, motions: Sequence[int], right: int, wrong: int) -> float:
        """Expected log-likelihood ratio of cause `right` to cause `wrong`, if it is right, from some motions."""
        gram = self.gram[list(motions)].sum(axis=0)
        apart = np.zeros(len(gram))
        apart[right], apart[wrong] = 1.0, -1.0
        free = self.n_causes + np.flatnonzero((self.owner == -1) | (self.owner == wrong))
        sigma = self.sigma[free - self.n_causes]
        scaled = gram[np.ix_(free, free)] * np.outer(sigma, sigma)
        pull = sigma * (gram @ apart)[free]
        bound = np.full(len(free), BOUND)
        x = bounded(scaled, pull, np.ones(len(free)), -bound, bound)
        return float(0.5 * (apart @ gram @ apart - 2 * x @ pull + x @ scaled @ x + x @ x))


def planned_log(arm: RigidArm, nominal: Machine, motions: Sequence[SessionMotion], channels: Sequence[Channel]) -> Log:
    """Motions as the nominal machine makes them under its controller, without noise, with some channels."""
    rig = SimulatedRig(arm=arm, machine=nominal)
    log = log_of(arm.robot, list(record(motions, rig, record_dt=_SAMPLE_DT)))
    return replace(
        log,
        tool=log.tool if "tool" in channels else None,
        link=log.link if "link" in channels else None,
        feedback=log.feedback if "servo" in channels else None,
    )


def foresee(
    log: Log,
    nominal: Machine,
    causes: Sequence[Hypothesis],
    noise: Mapping[Channel, Array],
    calibration: Calibration,
) -> Foreseen:
    """What causes would show along planned motions.

    Args:
        log: of `planned_log`.
        nominal: the machine without the causes.
        causes: two or more.
        noise: RMS that noise gives each component of each channel, shape (C,).
        calibration: what is known of the nominal numbers.
    """
    run = replay(log, nominal)
    shown: list[Parts] = list(exchanged(run, [cause.on(nominal) for cause in causes]))
    doubts = doubts_of(run, calibration)
    own = [
        (i, column)
        for i, cause in enumerate(causes)
        for column in tangents(replace(run, machine=cause.on(nominal)), nominal, [cause])
    ]
    columns = [*shown, *(doubt.column.parts for doubt in doubts), *(column for _, column in own)]
    weights = {(c, k): np.full(len(log.names), 1 / x) for c, rms in noise.items() for k, x in enumerate(rms)}
    known = [{key: rows for key, rows in column.items() if key in weights} for column in columns]
    shape = (len(log.sampling.at), len(log.names), 1)
    blocks = blocks_of(valid_rows(log), log.sampling.row_dt)
    evidence = stack_of(blocks, known, weights).evidence({key: np.zeros(shape) for key in weights})
    by_motion = [evidence.gram[blocks.motion == m].sum(axis=0) for m in range(len(log.names))]
    return Foreseen(
        gram=np.stack(by_motion),
        n_causes=len(causes),
        sigma=np.array([*(doubt.sigma for doubt in doubts), *(_FREE for _ in own)]),
        owner=np.array([*(-1 for _ in doubts), *(i for i, _ in own)]),
    )
