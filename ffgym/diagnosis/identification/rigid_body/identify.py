"""Identification of a rigid arm: inertial parameters, rotors, friction and offsets from recordings of its motion."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.identification.rigid_body.base import base_parameters, condition_number
from ffgym.diagnosis.identification.rigid_body.fit import RigidBodyFit
from ffgym.diagnosis.identification.rigid_body.observation import Equations, Filtering, equations_of, torque_errors
from ffgym.diagnosis.identification.rigid_body.problem import LOOSE, Problem, TradeOff, choose_spread, problem_of
from ffgym.diagnosis.identification.rigid_body.terms import (
    BODIES,
    DEFAULT_TERMS,
    per_parameter,
    read_description,
    terms_named,
)
from ffgym.diagnosis.resampling import LEVEL, MOST_RESAMPLES
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription

EXCITED = 0.9
"""Share that the data must have in a friction term or offset, else it is dropped: with less, what is found is that of
another term, or of the description."""

NEAREST, FARTHEST = 1e-6, 1e3
"""Least and largest spread that can be asked for; chosen: masses are neither known to a millionth nor off by more than
a thousand times, and with either the equations are still solved to many digits."""

_FOLDS = 5
"""Parts of a single recording that are held out in turn."""

Progress = Callable[[float, float], None]
"""Called with the resamples done and their total."""


@dataclass(frozen=True, kw_only=True)
class RigidBodyOptions:
    """Terms that are identified, and the settings of the fit."""

    terms: tuple[str, ...] = DEFAULT_TERMS
    """Parts of the torque that are fitted; springs that are not stay as described."""
    filtering: Filtering = field(default_factory=Filtering)
    """How recordings become equations."""
    spread: float | None = None
    """How far masses and rotors may be from the description: a relative standard deviation. None chooses what predicts
    held-out parts of the recordings best."""
    resamples: int = 200
    """Bootstrap resamples for the intervals."""
    level: float = LEVEL
    """Probability of the intervals."""
    seed: int = 0
    """Of the resamples."""

    def __post_init__(self) -> None:
        terms_named(self.terms)
        if self.spread is not None:
            check_number("spread", self.spread, low=NEAREST, high=FARTHEST)
        check_whole("resamples", self.resamples, low=2, high=MOST_RESAMPLES)
        check_whole("seed", self.seed, low=0)


def identify_rigid_body(
    robot: RobotDescription,
    recordings: Sequence[Recording],
    options: RigidBodyOptions | None = None,
    progress: Progress | None = None,
) -> RigidBodyFit:
    r"""Fit a rigid arm to recordings, physically consistent, and near its description where they do not say.

    .. math::
        \min_x \sum_n \frac{1}{\sigma_n^2} \| u_n - W_n x \|^2 + \frac{1}{s^2} \| y(x) - y_0 \|^2
        \quad \text{with bodies that exist}

    for the motors n, whose error sigma is found by iteration, with parameters x and their coordinates y relative to the
    description (`ffgym.diagnosis.identification.rigid_body.coordinates`). The spread s is chosen by predicting each
    recording from the others, or each fifth of a single one from the rest.

    Intervals come from a bootstrap over blocks of rows, in which each resample also draws the description anew within
    the spread (randomize-then-optimize), so that they are as wide as the spread where the data are silent.

    Args:
        robot: geometry, gears, gravity, and masses, rotors and friction as far as they are known.
        recordings: of this robot, with `motor.position` and `motor.effort`.
        options: None takes the defaults.
        progress: called now and then during the bootstrap.

    Raises:
        FFGymError: if there is nothing to identify from, or recordings do not fit the robot.

    Reference:
        Gautier (1997) for the filters; Lee, Wensing, Park (2020), IEEE Trans. Robotics 36(3), 837-852, for the
        consistency and the metric; Bardsley et al. (2014), SIAM J. Scientific Computing 36(4), A1895, for the draws.
    """
    options = options or RigidBodyOptions()
    terms = terms_named(options.terms)
    equations = _bent(robot, recordings, options)
    whole = problem_of(equations)
    if options.spread is None:
        trade_off = choose_spread(whole, _folds(equations))
    else:
        trade_off = TradeOff(spreads=np.array([options.spread]), errors=np.array([np.nan]), chosen=options.spread)
    spread = trade_off.chosen
    kept = _find_excited(whole, spread)
    problem = whole.only(kept)
    every, described = np.ones(equations.blocks.n_blocks), read_description(robot, terms)

    # the best parameters, and the best of those that a parameter file can hold
    estimate = _complete(problem.solve(every, spread), problem, kept, described)
    held = kept & per_parameter(robot, terms, lambda term: bool(term.entries(robot)))
    without = whole.only(held)
    in_file = _complete(without.solve(every, spread), without, held, described)

    # intervals from resampled blocks, each near a description that is drawn within the spread
    rng, coordinates, found = np.random.default_rng(options.seed), problem.coordinates, []
    for i in range(options.resamples):
        reference = coordinates.reference + rng.normal(scale=coordinates.spreads(spread))
        found.append(problem.solve(equations.blocks.draw(rng), spread, reference))
        if progress is not None:
            progress(i + 1.0, float(options.resamples))

    shares = np.zeros(len(kept))
    shares[kept] = problem.shares(spread)
    base = base_parameters(robot, terms)
    return RigidBodyFit(
        robot=robot,
        terms=terms,
        filtering=options.filtering,
        segments=tuple(recording.header.segment for recording in recordings),
        described=described,
        estimate=estimate,
        in_file=in_file,
        resampled=_complete(np.array(found), problem, kept, described),
        level=options.level,
        shares=shares,
        fitted=kept,
        trade_off=trade_off,
        base=base,
        base_shares=whole.shares_of(base.combination, spread),
        condition=condition_number(equations.columns / whole.noise, equations.counts, base),
        errors=torque_errors(equations, estimate, in_file),
    )


def _complete(y: Array, problem: Problem, kept: BoolArray, described: Array) -> Array:
    """All parameters (..., K), of the coordinates `y` that are kept in a problem; the others stay as described."""
    values = np.broadcast_to(described, (*y.shape[:-1], len(described))).copy()
    values[..., kept] = problem.coordinates.parameters(y)
    return values


def _bent(robot: RobotDescription, recordings: Sequence[Recording], options: RigidBodyOptions) -> Equations:
    """Equations of an arm whose joints bend under the bodies that a first fit finds."""
    terms = terms_named(options.terms)
    first = equations_of(robot, recordings, terms, options.filtering)
    if robot.drive.is_rigid.all() or terms[0] is not BODIES:
        return first
    problem = problem_of(first)
    y = problem.solve(np.ones(first.blocks.n_blocks), options.spread or LOOSE)
    bodies = problem.coordinates.parameters(y)[: len(terms[0].labels(robot))]
    return equations_of(robot, recordings, terms, options.filtering, bodies)


def _folds(equations: Equations) -> IntArray:
    """Fold of each block: its recording, or its fifth of a single one."""
    recording = equations.blocks.stratum
    if recording.max() > 0:
        return recording
    n_blocks = equations.blocks.n_blocks
    if n_blocks < _FOLDS:
        raise FFGymError(
            f"The recording gives {n_blocks} blocks and {_FOLDS} are held out in turn: record "
            f"for longer, or say how far masses may be from the description, e.g. spread = 0.1."
        )
    return np.arange(n_blocks) * _FOLDS // n_blocks


def _find_excited(problem: Problem, spread: float) -> BoolArray:
    """Mark the coordinates that are fitted: friction and offsets that the motion does not tell from others are not.

    The last of those in doubt is dropped, then the rest is asked again.
    """
    kept = np.ones(problem.coordinates.n, dtype=np.bool_)
    while True:
        reduced = problem.only(kept)
        doubtful = ~reduced.coordinates.is_held & (reduced.shares(spread) < EXCITED)
        if not doubtful.any():
            return kept
        kept[np.flatnonzero(kept)[np.flatnonzero(doubtful)[-1]]] = False
