"""Identification of LuGre friction: all joints of a robot from one set of recordings, thesis 6.1."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.errors import FFGymError, check_choice
from ffgym.friction import LuGreParameters
from ffgym.identification.bootstrap import LEVEL, RESAMPLES
from ffgym.identification.bristle_fit import INERTIA_ERROR, NAMES, BristleFit, fit_bristles
from ffgym.identification.estimate import Estimate
from ffgym.identification.friction_estimates import dynamic_estimates, static_estimates
from ffgym.identification.friction_torque import FrictionTorque
from ffgym.identification.reversals import reverses
from ffgym.identification.sliding_data import sliding_data
from ffgym.identification.steady import steady_friction
from ffgym.identification.stribeck_fit import MIN_RUNS, StribeckFit, fit_stribeck
from ffgym.robot import RobotDescription
from ffgym.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class JointFriction:
    """What was found about one joint."""

    joint: str
    estimates: tuple[Estimate, ...]
    """In the order of NAMES."""
    stribeck: StribeckFit | None
    """Fit to constant speeds; None if there were too few."""
    bristles: BristleFit | None
    """Fit to reversals; None if there were none."""
    notes: tuple[str, ...] = ()
    """What the user should know."""

    @property
    def inertia_error(self) -> float:
        """Share of the model's inertial torque that was missing, 0 if that is not known."""
        return 0.0 if self.bristles is None else self.bristles.inertia_error

    @property
    def offset(self) -> float:
        """Mean torque in reversals that nothing explains [N m], 0 if that is not known."""
        return 0.0 if self.bristles is None else self.bristles.offset


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionIdentification:
    """LuGre parameters of all joints, and what they rest on."""

    prior: RobotDescription
    """The robot as it was described before."""
    joints: tuple[JointFriction, ...]
    segments: tuple[str, ...]
    """Recordings that were used."""
    level: float
    """Probability of the intervals."""

    @property
    def friction(self) -> LuGreParameters:
        """Friction from now on: what was identified, and what was known before for the rest."""
        values = np.array([[estimate.value for estimate in joint.estimates] for joint in self.joints])
        return LuGreParameters(**{name: values[:, i] for i, name in enumerate(NAMES)})

    @property
    def robot(self) -> RobotDescription:
        """The robot with its friction from now on."""
        return replace(self.prior, friction=self.friction)

    @property
    def inertia_error(self) -> Array:
        """Share of the model's inertial torque that was missing, shape (N,)."""
        return np.array([joint.inertia_error for joint in self.joints])

    @property
    def offset(self) -> Array:
        """Mean torque in reversals that nothing explains [N m], shape (N,)."""
        return np.array([joint.offset for joint in self.joints])


def identify_friction(
    torques: Sequence[FrictionTorque],
    *,
    joints: Sequence[str] | None = None,
    stribeck_velocity: Mapping[str, float] | None = None,
    seed: int = 0,
    n_resamples: int = RESAMPLES,
    level: float = LEVEL,
    progress: Callable[[float, float], None] | None = None,
) -> FrictionIdentification:
    """Identify the friction of a robot's joints.

    Steady friction is taken wherever a joint runs at constant speed, bristles are identified from records in which it
    reverses. What the motions do not excite keeps its value, and says so.

    Args:
        torques: friction along recordings of one robot.
        joints: names of the joints to identify; None is all.
        stribeck_velocity: v_s [rad/s] of joints where it is to be kept as given; the others' is estimated.
        seed: of random starts and resamples.
        n_resamples: resamples behind the intervals.
        level: probability of the intervals.
        progress: called with joints done and their number.

    Raises:
        FFGymError: if there are no recordings, or a joint is unknown.
    """
    if not torques:
        raise FFGymError("There are no recordings to identify friction from.")
    robot = torques[0].signals.robot
    wanted = [check_choice("joint", joint, robot.joints) for joint in (joints or robot.joints)]
    given = stribeck_velocity or {}
    for joint in given:
        check_choice("joint", joint, robot.joints)
    found = []
    generators = np.random.default_rng(seed).spawn(robot.n_joints)
    for j, (name, rng) in enumerate(zip(robot.joints, generators, strict=True)):
        if progress is not None:
            progress(j, robot.n_joints)
        own = torques if name in wanted else []
        found.append(_joint(own, robot, j, given.get(name), rng, n_resamples, level))
    segments = tuple(torque.signals.segment for torque in torques)
    return FrictionIdentification(prior=robot, joints=tuple(found), segments=segments, level=level)


def _joint(
    torques: Sequence[FrictionTorque],
    robot: RobotDescription,
    joint: int,
    given: float | None,
    rng: np.random.Generator,
    n_resamples: int,
    level: float,
) -> JointFriction:
    """Both fits of one joint, and what is to be said about each parameter."""
    prior = np.array([getattr(robot.friction, name)[joint] for name in NAMES])
    steady = steady_friction(torques, joint)
    stribeck = None
    if steady.n_runs >= MIN_RUNS:
        usual = float(prior[3])
        stribeck = fit_stribeck(steady, rng, stribeck_velocity=given, usual_velocity=usual, n_resamples=n_resamples)
    reversing = [torque for torque in torques if reverses(torque, joint)]
    static = static_estimates(robot.joints[joint], prior, stribeck, given=given, level=level)
    bristles = None
    if reversing:
        data = sliding_data(reversing, joint, robot.friction)
        bristles = fit_bristles(data, *_static_spread(static, stribeck, n_resamples), rng)
    return JointFriction(
        joint=robot.joints[joint],
        estimates=(*static, *dynamic_estimates(robot.joints[joint], prior, bristles, level=level)),
        stribeck=stribeck,
        bristles=bristles,
        notes=tuple(_notes(stribeck, bristles)),
    )


def _static_spread(static: Sequence[Estimate], stribeck: StribeckFit | None, n_resamples: int) -> tuple[Array, Array]:
    """Static parameters to go on with, shape (4,), and resamples of those that were identified, shape (B, 4)."""
    values = np.array([estimate.value for estimate in static])
    spread = np.tile(values, (n_resamples, 1))
    for i, estimate in enumerate(static):
        if stribeck is not None and estimate.is_identified:
            spread[:, i] = stribeck.resampled[:, i]
    return values, spread


def _notes(stribeck: StribeckFit | None, bristles: BristleFit | None) -> Iterator[str]:
    """What the fits found that the LuGre model does not have, or could not tell."""
    if stribeck is not None:
        if not stribeck.both_directions:
            yield "it ran in one direction only: an error of gravity or an offset counts as friction"
        low, high = np.quantile(stribeck.resampled[:, 4:], [0.05, 0.95], axis=0)
        if low[0] > 0 or high[0] < 0:
            yield f"both directions differ by an offset of {stribeck.offset:.3g} N m, which is not in the model"
        if low[1] > 0 or high[1] < 0:
            yield f"viscous friction differs between directions by +-{abs(stribeck.asymmetry):.3g} N m s/rad"
    if bristles is not None and abs(bristles.inertia_error) >= INERTIA_ERROR:
        yield "the inertia of the model is wrong by more than 10 %, so sigma_0 and sigma_1 are not to be trusted"
