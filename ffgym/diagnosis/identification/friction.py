"""Identification of LuGre friction: all joints of a robot from one set of recordings, thesis 6.1."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array
from ffgym.diagnosis.identification.bristle_fit import NAMES
from ffgym.diagnosis.identification.friction_data import FrictionTorque
from ffgym.diagnosis.identification.joint_friction import FitOptions, JointFriction, identify_joint
from ffgym.diagnosis.identification.resampling import LEVEL, RESAMPLES
from ffgym.robot import RobotDescription
from ffgym.robot.friction import LuGreParameters


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
        options = FitOptions(stribeck_velocity=given.get(name), n_resamples=n_resamples, level=level)
        found.append(identify_joint(own, robot, j, options, rng))
    segments = tuple(torque.signals.segment for torque in torques)
    return FrictionIdentification(prior=robot, joints=tuple(found), segments=segments, level=level)
