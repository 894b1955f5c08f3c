r"""All numbers of a description fitted to recordings together, for a machine that is far from it in many.

A diagnosis looks for some few causes, and takes the numbers of its model as nearly right. Where none was identified,
all are wrong at once, each hides the others, and none alone explains much. So all that a description has per joint is
fitted first: friction, rotors, masses of links, springs, by replaying the machine as in a diagnosis (Gauss-Newton on
torque, tool and link angles together), near the description where recordings do not say. What such a model leaves is
what a diagnosis may ask about.

Beside them, torque offsets and the place of the tool in each motion are free: errors of the kinematics are nearly
constant while an arm stays about one place, and shall not bend its springs. Each component of each motion counts in
units of what the fit leaves there, found by iteration: unlike noise alone, that knows where the model lacks something.
At first only slow changes are compared: where motors move as measured a wrong spring swings at its own frequency, and
slopes lead to the right one only from near.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.fit.descent import Slope, Steps, descend
from ffgym.diagnosis.fit.fit import Fit, Trial, add_tangents, evaluate, replay_hypotheses
from ffgym.diagnosis.fit.hypothesis import Hypothesis, move_hypotheses
from ffgym.diagnosis.fit.problem import FitProblem
from ffgym.diagnosis.log import Log, assemble_log
from ffgym.diagnosis.nuisance import LinkMass
from ffgym.diagnosis.perturbation import Parts
from ffgym.diagnosis.replay import replay
from ffgym.diagnosis.resampling import cut_blocks
from ffgym.diagnosis.residual_rows import find_counting_rows, find_valid_rows
from ffgym.diagnosis.sensitivity import compute_sensitivities
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import solve_bounded
from ffgym.effects import Effect, NativeEffect
from ffgym.effects.drive.offset import TorqueOffset
from ffgym.effects.effect import Side
from ffgym.effects.friction.coulomb import CoulombLevel
from ffgym.effects.friction.presliding import PreslidingStiffness
from ffgym.effects.friction.viscous import ViscousLevel
from ffgym.effects.load.rotor_inertia import RotorInertia
from ffgym.effects.parameters import parameter
from ffgym.effects.transmission.stiffness import JointStiffness
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Machine


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Breakaway(NativeEffect):
    r"""Another Stribeck curve that never falls below the Coulomb torque; a number to be fitted, no effect to be named.

    .. math:: f_s - f_c \to (1 + a) (f_s - f_c), \quad v_s \to (1 + b)\, v_s

    As an effect to be named the peak counts in Coulomb torques, and a step of many numbers at once would leave what a
    description can say.
    """

    name: ClassVar[str] = "breakaway"
    side: ClassVar[Side] = "motor"
    needs_friction: ClassVar[bool] = True

    level: Array = parameter("a", unit="1", low=-0.6, high=1.5, minimum=-0.95, source="chosen: as bristles")
    velocity: Array = parameter("b", unit="1", low=-0.5, high=1.0, minimum=-0.95, source="as of the Stribeck peak")

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """Return the robot with another peak and another Stribeck velocity."""
        friction = robot.friction
        static = friction.coulomb + (1 + self.level) * (friction.static - friction.coulomb)
        velocity = friction.stribeck_velocity * (1 + self.velocity)
        return replace(robot, friction=replace(friction, static=static, stribeck_velocity=velocity))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ShareOnArm(NativeEffect):
    r"""Another share of the friction behind the elasticity; a number to be fitted, no effect to be named.

    .. math:: \ln\frac{s}{1 - s} \to \ln\frac{s}{1 - s} + a

    As an effect to be named more friction can only move onto the arm; here it may move back, and some of it stays on
    both sides. A joint whose friction is described on one side alone keeps it there.
    """

    name: ClassVar[str] = "share_on_arm"
    side: ClassVar[Side] = "link"
    needs_elasticity: ClassVar[bool] = True
    needs_friction: ClassVar[bool] = True

    shift: Array = parameter("a", unit="1", low=-1.0, high=1.0, source="chosen: a half becomes a quarter to three")

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """Return the robot with another part of its friction on the arm."""
        share, factor = robot.arm_share, np.exp(self.shift)
        return robot.with_arm_share(share * factor / (1 - share + share * factor))


NUMBERS: tuple[type[Effect], ...] = (
    CoulombLevel,
    ViscousLevel,
    Breakaway,
    PreslidingStiffness,
    ShareOnArm,
    RotorInertia,
    LinkMass,
    JointStiffness,
)
"""Numbers that are fitted on every joint that has them, as shares of those of the description. Springs keep their
damping ratio: recordings tell it only at resonance."""


def _precision() -> float:
    """Precision of the distance of each number from the description, in practical steps, before any recording."""
    return (settings().screening.step / settings().estimator.spread) ** 2


def _distance(numbers: Iterable[Hypothesis]) -> Array:
    """Compute the distance of all numbers from the description, in practical steps."""
    found = []
    for number in numbers:
        known = number.kind.parameters()
        found += [(free.value - known[free.name].neutral) / free.step for free in number.list_free()]
    return np.array(found)


def _with_numbers(robot: RobotDescription, numbers: Iterable[Hypothesis]) -> RobotDescription:
    """The description with other numbers."""
    for number in numbers:
        effect = number.effect(robot)
        assert isinstance(effect, NativeEffect)
        robot = effect.in_description(robot)
    return robot


CUTOFFS = (5.0, settings().sampling.cutoff)
"""Low-passes of what is compared, one after the other [Hz]: below the resonances of industrial robots, as for rigid
bodies (`ffgym.diagnosis.identification.rigid_body`), then as in a diagnosis."""


def tune(machine: Machine, recordings: Sequence[Recording]) -> Machine:
    """The machine with numbers that predict recordings best.

    Args:
        machine: to begin with; its effects stay as they are.
        recordings: of its motions, as for a diagnosis.

    Raises:
        FFGymError: if recordings do not fit the robot.
    """
    robot = machine.physical
    log = replace(assemble_log(robot, recordings), feedback=None)  # the servo knows nothing of these numbers
    # all numbers as the description has them
    numbers: tuple[Hypothesis, ...] = ()
    for kind in NUMBERS:
        neutral = {name: np.array(p.neutral) for name, p in kind.parameters().items()}
        for j in np.flatnonzero(_which_joints_have(kind, robot)):
            numbers += (Hypothesis(kind=kind, joint=robot.joints[j], source=None, values=neutral),)
    for cutoff in CUTOFFS:
        sampling = replace(log.sampling, cutoff=min(cutoff, log.sampling.cutoff))
        problem = _pose_problem(replace(log, sampling=sampling), machine)
        for _ in range(settings().estimator.passes):
            numbers = _fit_numbers(_weigh(problem, numbers), numbers)
    return replace(machine, robot=_with_numbers(machine.robot, numbers))


def _which_joints_have(kind: type[Effect], robot: RobotDescription) -> BoolArray:
    """Tell which joints of a robot have a number, shape (N,)."""
    if kind is ShareOnArm:
        return (robot.arm_share > 0) & (robot.arm_share < 1)
    return ~robot.drive.is_rigid if kind.needs_elasticity else np.ones(robot.n_joints, dtype=np.bool_)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Numbers(Slope[Trial]):
    """Numbers of the description in practical steps, held near it where recordings do not say."""

    problem: FitProblem

    def cost(self, point: Trial) -> float:
        return point.left + _precision() * float(np.sum(_distance(point.hypotheses) ** 2))

    def step(self, point: Trial, reach: float) -> Array:
        assert isinstance(point, Fit)
        off, n, priors = _distance(point.hypotheses), point.n_nuisances, point.priors
        precision = np.concatenate([priors.precision[:n], np.full(len(off), _precision())])
        pull = point.equations.moment.sum(axis=0)[:, 0] - np.concatenate([np.zeros(n), _precision() * off])
        low = np.concatenate([priors.low[:n], np.maximum(priors.low[n:], -reach)])
        high = np.concatenate([priors.high[:n], np.minimum(priors.high[n:], reach)])
        return solve_bounded(point.equations.gram.sum(axis=0), pull, precision, low, high)[n:]

    def move(self, point: Trial, step: Array) -> Trial | None:
        return replay_hypotheses(self.problem, move_hypotheses(point.hypotheses, step))

    def renew(self, point: Trial, *, is_last: bool) -> Trial:
        return point if is_last else add_tangents(self.problem, point, None)


def _fit_numbers(problem: FitProblem, numbers: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
    """Fit numbers by Gauss-Newton steps from the given ones."""
    limits = settings().estimator
    steps = Steps(most=limits.tuning_steps, reach=limits.reach, least_reach=limits.least_reach, gain=limits.gain)
    found = descend(_Numbers(problem=problem), evaluate(problem, numbers), steps)
    assert found is not None
    return found.hypotheses


def _pose_problem(log: Log, machine: Machine) -> FitProblem:
    """Pose the problem that all fits to a log share; all rows that count are alike at first."""
    run, valid = replay(log, machine), find_valid_rows(log)
    # free beside the numbers, per standard deviation: torque offsets, and places of the tool
    coulomb, beside = dict(zip(run.robot.joints, run.robot.friction.coulomb, strict=True)), list[Parts]()
    for column in compute_sensitivities(run, [TorqueOffset], {}):
        beside.append(
            {
                key: rows * settings().estimator.tuned_offset * coulomb[column.joint]
                for key, rows in column.parts.items()
            }
        )
    # place of the tool in each motion, along each axis
    for motion in np.eye(valid.shape[1]) if log.tool is not None else ():
        beside += [
            {("tool", axis): np.broadcast_to(settings().estimator.tuned_place * motion, valid.shape)}
            for axis in range(3)
        ]
    return FitProblem(
        log=log,
        nominal=machine,
        blocks=cut_blocks(valid, log.sampling.row_dt),
        weights={key: rows.astype(np.float64) for key, rows in find_counting_rows(log).items()},
        nuisance_columns=beside,
        nuisances=(),
        like=run,
        bias=dict.fromkeys(("torque", "tool", "link"), np.zeros(1)),
    )


def _weigh(problem: FitProblem, numbers: Sequence[Hypothesis]) -> FitProblem:
    """Weigh each component of each motion in units of what numbers leave there; of the tool about its mean.

    What a model lacks goes on for a while, so that all rows of a block count as much as one.
    """
    machine = replace(problem.nominal, robot=_with_numbers(problem.nominal.robot, numbers))
    residual = evaluate(replace(problem, nominal=machine), ()).residual
    counting, alike = find_counting_rows(problem.log), settings().blocks.length / problem.log.sampling.row_dt
    weights = {}
    for (channel, c), rows in counting.items():
        rest, count = residual[channel][:, :, c], np.maximum(rows.sum(axis=0), 1)
        mean = np.sum(rest * rows, axis=0) / count if channel == "tool" else 0.0
        square = np.sum(((rest - mean) * rows) ** 2, axis=0) / count
        weights[channel, c] = rows / np.sqrt(alike * np.where(square > 0, square, np.inf))
    return replace(problem, weights=weights)
