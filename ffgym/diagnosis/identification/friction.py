"""Identification of LuGre friction: all joints from one set of recordings, thesis 6.1, and how well it holds."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.control import DynamicLuGreExact
from ffgym.core.errors import FFGymError, check_choice, check_class, check_number, check_whole
from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.identification.arm_share import NAME as ARM_SHARE
from ffgym.diagnosis.identification.arm_share import describe_arm_share
from ffgym.diagnosis.identification.bristle_fit import NAMES
from ffgym.diagnosis.identification.friction_data import FrictionTorque, ModelError
from ffgym.diagnosis.identification.joint_friction import JointFriction, identify_joint
from ffgym.diagnosis.identification.parameter_file import entry_of, make_fitted_quantity
from ffgym.diagnosis.resampling import LEVEL, RESAMPLES
from ffgym.diagnosis.settings import settings
from ffgym.robot import RobotDescription
from ffgym.robot.friction import LuGreParameters
from ffgym.robot.reading.quantity import Quantity


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
        lugre = {name: values[:, i] for i, name in enumerate(NAMES)}
        return LuGreParameters(**lugre, arm_share=self.arm_share)

    @property
    def arm_share(self) -> Array:
        """Share of friction behind the elasticity from now on [1], shape (N,)."""
        described = entry_of(self.prior, ARM_SHARE)
        found = [joint.arm for joint in self.joints]
        return np.array([old if arm is None else arm.estimate.value for old, arm in zip(described, found, strict=True)])

    @property
    def robot(self) -> RobotDescription:
        """The robot with its friction from now on."""
        return replace(self.prior, friction=self.friction)

    @property
    def model_error(self) -> ModelError:
        """Errors of the model of the arm that reversals showed; 0 for joints without any."""
        return ModelError(
            inertia=np.array([joint.inertia_error for joint in self.joints]),
            links=np.array([joint.link_error for joint in self.joints]),
            springs=np.array([joint.spring_error for joint in self.joints]),
            offset=np.array([joint.offset for joint in self.joints]),
        )


def identify_friction(
    torques: Sequence[FrictionTorque],
    *,
    joints: Sequence[str] | None = None,
    stribeck_velocity: Mapping[str, float] | None = None,
    stiffness_spread: float | None = None,
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
        stiffness_spread: relative standard deviation of the joint stiffness that the description has, which is in the
            interval of the share of friction behind it; None is that of its interval there, or 30 %.
        seed: of random starts and resamples.
        n_resamples: resamples behind the intervals.
        level: probability of the intervals.
        progress: called with joints done and their number.

    Raises:
        FFGymError: if there are no recordings, or a joint is unknown.
    """
    if not torques:
        raise FFGymError("There are no recordings to identify friction from.")
    for torque in torques:
        check_class("torque", torque, FrictionTorque, "friction_torques makes them of recordings")
    robot = torques[0].signals.robot
    wanted = [check_choice("joint", joint, robot.joints) for joint in (joints or robot.joints)]
    given = stribeck_velocity or {}
    if stiffness_spread is not None:
        check_number("stiffness_spread", stiffness_spread, low=0.0, high=1.0)
    for joint, velocity in given.items():
        check_choice("joint", joint, robot.joints)
        check_number(f"stribeck_velocity of {joint}", velocity, unit="rad/s", low=0.0, open_low=True)
    # a generator for each joint, so that one does not depend on which others are asked for
    found = []
    generators = np.random.default_rng(check_whole("seed", seed, low=0)).spawn(robot.n_joints)
    for j, (name, rng) in enumerate(zip(robot.joints, generators, strict=True)):
        if progress is not None:
            progress(j, robot.n_joints)
        own = torques if name in wanted else []
        found.append(
            identify_joint(
                own,
                robot,
                j,
                rng,
                stribeck_velocity=given.get(name),
                stiffness_spread=stiffness_spread,
                n_resamples=n_resamples,
                level=level,
            )
        )
    segments = tuple(torque.signals.segment for torque in torques)
    return FrictionIdentification(prior=robot, joints=tuple(found), segments=segments, level=level)


@dataclass(frozen=True, kw_only=True)
class Validation:
    """Error that parameters leave of one joint's friction torque in one record, motor side."""

    segment: str
    joint: str
    rms_friction: float
    """Of the friction torque about its mean [N m]."""
    rms_error: float
    """Of friction torque minus model [N m]."""

    @property
    def share(self) -> float:
        """Share of the variance that the model explains; negative if it is worse than a constant."""
        return 1 - (self.rms_error / self.rms_friction) ** 2


def predict_friction(friction: LuGreParameters, torque: FrictionTorque) -> Array:
    """Predict the friction of a LuGre model along measured speeds, filtered alike [N m], (T, N), thesis (6.16)."""
    law = DynamicLuGreExact(friction, n_substeps=1)
    signals = torque.signals
    return signals.low_pass(law.along(signals.motor_dq, signals.dt), signals.dt)


def validate(
    friction: LuGreParameters, torques: Sequence[FrictionTorque], model_error: ModelError | None = None
) -> list[Validation]:
    """Errors of friction parameters, record by record, for the joints that move in each.

    Args:
        friction: parameters of all joints.
        torques: friction along recordings.
        model_error: what was found about the model of the arm, for old and new parameters alike; None is none.
    """
    travel, rest = settings().friction.forgetting_travel, settings().patterns.rest
    found = []
    for torque in torques:
        measured = torque.friction - (0.0 if model_error is None else model_error.torque(torque))
        error = measured - predict_friction(friction, torque)
        # rows from where bristles have forgotten how they began; at rest they never do
        way = np.cumsum(np.abs(torque.signals.motor_dq), axis=0) * torque.signals.dt
        forgotten = way > travel * friction.static / friction.bristle_stiffness
        for j, joint in enumerate(torque.signals.robot.joints):
            scored = torque.counts(j) & forgotten[:, j]
            if scored.any() and np.abs(torque.signals.motor_dq[scored, j]).max() > rest:
                found.append(
                    Validation(
                        segment=torque.signals.segment,
                        joint=joint,
                        rms_friction=float(measured[scored, j].std()),
                        rms_error=rms(error[scored, j]),
                    )
                )
    return found


_NAMED = 6
"""Logs that a source names."""


def friction_quantities(identification: FrictionIdentification) -> Mapping[str, Quantity]:
    """Entries [friction.*] for a parameter file: numbers, intervals, what they rest on, and what was before.

    Joints for which the data do not tell an entry keep its number and its origin; an entry that no joint tells is left
    out, and stays what the description says.
    """
    robot, segments = identification.prior, identification.segments
    more = f" and {len(segments) - _NAMED} more logs" if len(segments) > _NAMED else ""
    source = f"ffgym identify from {', '.join(segments[:_NAMED])}{more}; {identification.level:.0%} intervals"
    entries = {}
    # LuGre parameters, and the share of them behind the elasticity
    unasked = [describe_arm_share(robot, j, "not excited", "rigid or not asked for") for j in range(robot.n_joints)]
    shares = [
        other if joint.arm is None else joint.arm.estimate
        for joint, other in zip(identification.joints, unasked, strict=True)
    ]
    for column in [*zip(*(joint.estimates for joint in identification.joints), strict=True), shares]:
        # new numbers were found, given by the caller, or moved to fit what was found
        is_new = [own.is_identified or own.value != own.prior for own in column]
        if not any(is_new):
            continue
        path = column[0].name
        before = robot.quantities[path].origin if path in robot.quantities else ("chosen",)
        kept = before * len(column) if len(before) == 1 else before
        others = [f"{own.joint}: {own.status}, {own.reason}" for own in column if not own.is_identified]
        entries[path] = make_fitted_quantity(
            robot,
            path,
            np.array([own.value for own in column]),
            "; ".join([source, *others]),
            tuple("fitted" if new else old for new, old in zip(is_new, kept, strict=True)),
            np.array([[own.low, own.high] for own in column]),
        )
    return entries
