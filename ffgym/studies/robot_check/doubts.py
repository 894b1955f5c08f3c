"""Plausibility of the numbers of a description: valid but doubtful ones are mostly slips of unit, side or frame."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.robot import RigidArm, RobotDescription, RobotDraft, resonances
from ffgym.studies.robot_check.loads import compute_inertia, compute_margin
from ffgym.studies.robot_check.shape import rest_position, skeleton

Found = Iterable[tuple[float, dict[str, Any]]]
"""Checked numbers, and the words of the sentence about each, e.g. the joint."""


@dataclass(frozen=True, kw_only=True)
class Question:
    """Question of plausibility about one number of the robot, or one per joint or body."""

    needs: tuple[str, ...]
    """Capability that the description must have (`ffgym.robot.CAPABILITIES`), and entries that are needed beside it."""
    measure: Callable[[RobotDescription], Found]
    doubt: str
    """Sentence about a number outside the limits, which begins with the entry and has places for `value` and words."""
    low: float = -np.inf
    high: float = np.inf


def list_doubts(draft: RobotDraft) -> list[str]:
    """List sentences about doubtful numbers, each beginning with the entry."""
    return [
        question.doubt.format(value=value, low=question.low, high=question.high, **words)
        for question in QUESTIONS
        if draft.can(*question.needs)  # skipped if the description lacks the numbers for it
        for value, words in question.measure(draft.description_for(*question.needs))
        if value < question.low or value > question.high
    ]


def _per_joint(robot: RobotDescription, values: Array, **words: Array) -> Found:
    for j, joint in enumerate(robot.joints):
        yield float(values[j]), {"joint": joint, **{name: float(each[j]) for name, each in words.items()}}


def _over_longest_link(robot: RobotDescription, sizes: dict[str, float]) -> Found:
    """Divide sizes [m] by the length of the longest link: from joint to joint, or from the last one to the TCP."""
    steps = [*robot.kinematics.position[1:]]
    if robot.tool is not None:
        steps.append(robot.tool.position + robot.tool.rotation @ robot.tool.tcp)
    longest = max((float(np.linalg.norm(step)) for step in steps), default=0.0)
    for name, size in sizes.items():
        if longest > 0:  # one joint without tool has no length
            yield size / longest, {"name": name, "size": size, "longest": longest}


def _ellipsoids(robot: RobotDescription) -> list[tuple[str, float, float]]:
    """Compute name, mass [kg] and largest half axis of the inertia ellipsoid [m] of each body."""
    bones = skeleton(robot, np.clip(0.0, *robot.kinematics.range.T))
    return list(zip(bones.bodies, bones.mass.tolist(), bones.half_axes.max(axis=1).tolist(), strict=True))


def _densities(robot: RobotDescription) -> Found:
    """Compute least densities of bodies, as of a ball around the inertia ellipsoid [kg/m^3]."""
    for body, mass, half_axis in _ellipsoids(robot):
        volume = max(4 / 3 * np.pi * half_axis**3, 1e-300)
        yield mass / volume, {"body": body, "mass": mass, "size_mm": 2e3 * half_axis}


def _rates(robot: RobotDescription) -> Found:
    """Compute the fastest oscillation, and the damping of the rotors, as radians in one physics step."""
    free = resonances(RigidArm(robot), rest_position(robot), "free")
    rates = {f"the resonance of {f:.0f} Hz with the motors free": 2 * np.pi * f for f in free[-1:]}
    drive, friction = robot.drive, robot.friction
    damping = (friction.bristle_damping + friction.viscous + robot.servo.velocity_gain) / drive.rotor_inertia
    bristle = np.sqrt(friction.bristle_stiffness / drive.rotor_inertia)
    rates[f"what friction and servo damp the rotor of {robot.joints[int(damping.argmax())]} by"] = float(damping.max())
    rates[f"the rotor of {robot.joints[int(bristle.argmax())]} on its bristles"] = float(bristle.max())
    for what, rate in rates.items():
        yield rate * robot.physics_dt, {"what": what, "dt": robot.physics_dt, "enough": _STEP / rate}


def _margin(numerator: str) -> Callable[[RobotDescription], Found]:
    """Return a measure of a torque over the peak torque."""

    def measure(robot: RobotDescription) -> Found:
        margin = compute_margin(robot, rest_position(robot))
        torque = getattr(margin, numerator)
        return _per_joint(robot, torque / margin.peak, torque=torque, peak=margin.peak)

    return measure


_STEP = 1.0
"""Largest rate x physics step: one radian of an oscillation; at 2 the integration explodes."""

QUESTIONS = (
    Question(  # beyond it the centre of mass lies outside any usual link
        needs=("link_torque",),
        measure=lambda robot: _over_longest_link(
            robot, dict(zip(robot.links, np.linalg.norm(robot.bodies.com, axis=1).tolist(), strict=True))
        ),
        high=1.5,
        doubt="links.com: the centre of mass of {name} is {size:.3g} m from its joint, while the longest link "
        "has {longest:.3g} m. Is it in the link frame, and in m?",
    ),
    Question(  # a thin rod has 1.3 of its own length
        needs=("link_torque",),
        measure=lambda robot: _over_longest_link(robot, {body: 2 * half for body, _, half in _ellipsoids(robot)}),
        high=4.0,
        doubt="links.inertia: mass and inertia of {name} belong to a body of {size:.3g} m, while the longest link has "
        "{longest:.3g} m. Is the inertia about the centre of mass, and in kg m^2?",
    ),
    Question(  # gold and tungsten have 19.3e3
        needs=("link_torque",),
        measure=_densities,
        high=20e3,
        doubt="links.inertia: {mass:.3g} kg of {body} would fit into {size_mm:.3g} mm only if denser than gold. Is the "
        "inertia in kg m^2?",
    ),
    Question(  # with room for rounding; none at all is a robot in space
        needs=("link_torque",),
        measure=lambda robot: [(float(np.linalg.norm(robot.gravity)), {})] if np.any(robot.gravity) else [],
        low=9.7,
        high=9.9,
        doubt="simulation.gravity is {value:.4g} m/s^2, on the ground it is 9.81.",
    ),
    Question(  # built robots have 0.03 to 20; a rotor in kg cm^2 is off by 1e4
        needs=("motor_torque",),
        measure=lambda robot: _per_joint(
            robot, compute_inertia(robot, rest_position(robot)).ratio, rotor=robot.drive.rotor_inertia
        ),
        low=1e-3,
        high=1e3,
        doubt="drive.rotor_inertia of {joint}: the links weigh {value:.3g} times as much on the motor as the rotor of "
        "{rotor:.3g} kg m^2. Was it given in kg cm^2 (1e-4 kg m^2), or the gear ratio the wrong way round?",
    ),
    Question(  # 14 000 turns a minute; degrees taken for radians give 57 times as much
        needs=("kinematics", "drive.gear_ratio", "kinematics.max_speed"),
        measure=lambda robot: _per_joint(robot, np.abs(robot.drive.gear_ratio) * robot.kinematics.max_speed),
        high=1500.0,
        doubt="kinematics.max_speed of {joint}: its motor would turn at {value:.0f} rad/s. Is the speed in its unit, "
        "deg/s or rad/s, and the gear ratio right?",
    ),
    Question(  # a lower one is a pendulum rather than an arm, a higher one no metal structure of an arm
        needs=("locked_resonances",),
        measure=lambda robot: [(f, {}) for f in resonances(RigidArm(robot), rest_position(robot))],
        low=1.0,
        high=1000.0,
        doubt="drive.joint_stiffness gives a resonance of {value:.3g} Hz with the motors held; arms have {low:g} to "
        "{high:g} Hz. Is it in N m/rad, link side? A joint that does not bend has inf.",
    ),
    Question(  # published robots have 1e-4 to 1.3e-3
        needs=("locked_resonances", "drive.joint_damping"),
        measure=lambda robot: _per_joint(robot, robot.drive.joint_damping / robot.drive.joint_stiffness),
        high=1e-2,
        doubt="drive.joint_damping of {joint} is {value:.2g} s x stiffness; robots have 1e-4 to 1e-3 s.",
    ),
    Question(  # robots lose 2 to 10 %
        needs=("torque_margin",),
        measure=_margin("breakaway"),
        high=0.5,
        doubt="friction.static of {joint}, {torque:.3g} N m, is {value:.0%} of drive.peak_torque, {peak:.3g} N m. Are "
        "both on the motor side?",
    ),
    Question(  # by the viscous line, which overstates it: the built-in robots have up to 1.5
        needs=("torque_margin",),
        measure=_margin("friction_at_speed"),
        high=2.0,
        doubt="friction.viscous of {joint} takes {value:.0%} of drive.peak_torque at the speed limit. Is it a "
        "simulator's number, or on the other side of the gearbox?",
    ),
    Question(
        needs=("torque_margin",),
        measure=_margin("gravity"),
        high=1.0,
        doubt="drive.peak_torque of {joint}, {peak:.3g} N m, cannot hold gravity, {torque:.3g} N m on the motor in the "
        "worst pose of its range. Are both on the motor side, is a counterbalance missing ([springs])?",
    ),
    Question(  # motor angle over which bristles bend before they slip; motors with gears have 1e-3 to 2e-2
        needs=("lugre_dynamic",),
        measure=lambda robot: _per_joint(robot, robot.friction.coulomb / robot.friction.bristle_stiffness),
        low=1e-4,
        high=0.1,
        doubt="friction.bristle_stiffness of {joint}: it slips after {value:.2g} rad of the motor; motors with gears "
        "have 1e-3 to 2e-2 rad. Is it on the motor side?",
    ),
    Question(
        needs=("simulation",),
        measure=_rates,
        high=_STEP,
        doubt="simulation.physics_dt = {dt:g} s is long for {what}: {enough:.2g} s or less follows it.",
    ),
)
"""All questions, each with the reason for its limits."""
