"""Numbers of drives, friction and step that are valid but hardly true, or hardly useful."""

from collections.abc import Iterator

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.robot import RigidArm, RobotDescription, resonances
from ffgym.studies.robot_check.loads import inertia_of, margin_of
from ffgym.studies.robot_check.places import rest_place

_INERTIA_RATIO = (1e-3, 1e3)
"""Link over rotor inertia at the motor. Built robots have 0.03 to 20; a rotor in kg cm^2 is off by 1e4."""
_FASTEST_MOTOR = 1500.0
"""Motor speed [rad/s], 14 000 turns a minute; degrees taken for radians give 57 times as much."""
_RESONANCE_HZ = (1.0, 1000.0)
"""A lower one is a pendulum rather than an arm, a higher one no metal structure of an arm."""
_STEP = 1.0
"""Largest rate x physics step: one radian of an oscillation; at 2 the integration explodes."""
_SLOWEST_DAMPING = 1e-2
"""Joint damping over stiffness [s]; published robots have 1e-4 to 1.3e-3."""
_PRESLIDING = (1e-4, 0.1)
"""Motor angle over which bristles bend before they slip [rad]; motors with gears have 1e-3 to 2e-2."""
_MUCH_FRICTION = 0.5
"""Share of the peak torque that friction may take at the start; robots lose 2 to 10 %."""
_MUCH_FRICTION_AT_SPEED = 2.0
"""The same at the speed limit by the viscous line, which overstates it: the built-in robots have up to 1.5."""


def odd_rotors(robot: RobotDescription) -> Iterator[str]:
    """Rotor inertias that do not fit the links, and gears that do not fit the speeds."""
    ratio = inertia_of(robot, _rest(robot)).ratio
    for j in np.flatnonzero((ratio < _INERTIA_RATIO[0]) | (ratio > _INERTIA_RATIO[1])):
        yield (
            f"drive.rotor_inertia of {robot.joints[j]}: the links weigh {ratio[j]:.3g} times as much on the motor as "
            f"the rotor of {robot.drive.rotor_inertia[j]:.3g} kg m^2. Was it given in kg cm^2 (1e-4 kg m^2), or the "
            f"gear ratio the wrong way round?"
        )


def fast_motors(robot: RobotDescription) -> Iterator[str]:
    """Motors that would turn faster than motors do."""
    speed = np.abs(robot.drive.gear_ratio) * robot.kinematics.max_speed
    for j in np.flatnonzero(speed > _FASTEST_MOTOR):
        yield (
            f"kinematics.max_speed of {robot.joints[j]}: its motor would turn at {speed[j]:.0f} rad/s. Is the speed in "
            f"its unit, deg/s or rad/s, and the gear ratio right?"
        )


def odd_resonances(robot: RobotDescription) -> Iterator[str]:
    """Resonances that no arm has."""
    low, high = _RESONANCE_HZ
    for f in resonances(RigidArm(robot), _rest(robot)):
        if not low <= f <= high:
            yield (
                f"drive.joint_stiffness gives a resonance of {f:.3g} Hz with the motors held; arms have {low:g} to "
                f"{high:g} Hz. Is it in N m/rad, link side? A joint that does not bend has inf."
            )


def long_step(robot: RobotDescription) -> Iterator[str]:
    """A physics step that is too long for the fastest oscillation, or for what damps the rotors."""
    free = resonances(RigidArm(robot), _rest(robot), "free")
    rates = {f"the resonance of {f:.0f} Hz with the motors free": 2 * np.pi * f for f in free[-1:]}
    drive, friction = robot.drive, robot.friction
    damping = (friction.bristle_damping + friction.viscous + robot.servo.velocity_gain) / drive.rotor_inertia
    bristle = np.sqrt(friction.bristle_stiffness / drive.rotor_inertia)
    rates[f"what friction and servo damp the rotor of {robot.joints[int(damping.argmax())]} by"] = float(damping.max())
    rates[f"the rotor of {robot.joints[int(bristle.argmax())]} on its bristles"] = float(bristle.max())
    for what, rate in rates.items():
        if rate * robot.physics_dt > _STEP:
            yield (
                f"simulation.physics_dt = {robot.physics_dt:g} s is long for {what}: {_STEP / rate:.2g} s or less "
                f"follows it."
            )


def slow_damping(robot: RobotDescription) -> Iterator[str]:
    """Joint damping that is out of proportion to the stiffness."""
    drive = robot.drive
    for j in np.flatnonzero(drive.joint_damping / drive.joint_stiffness > _SLOWEST_DAMPING):
        yield (
            f"drive.joint_damping of {robot.joints[j]} is {drive.joint_damping[j] / drive.joint_stiffness[j]:.2g} s x "
            f"stiffness; robots have 1e-4 to 1e-3 s."
        )


def odd_bristles(robot: RobotDescription) -> Iterator[str]:
    """Presliding displacements that no motor has."""
    presliding = robot.friction.coulomb / robot.friction.bristle_stiffness
    for j in np.flatnonzero((presliding < _PRESLIDING[0]) | (presliding > _PRESLIDING[1])):
        yield (
            f"friction.bristle_stiffness of {robot.joints[j]}: it slips after {presliding[j]:.2g} rad of the motor; "
            f"motors with gears have 1e-3 to 2e-2 rad. Is it on the motor side?"
        )


def weak_motors(robot: RobotDescription) -> Iterator[str]:
    """Motors that friction and gravity use up."""
    margin = margin_of(robot, _rest(robot))
    for j, joint in _named(robot, margin.breakaway > _MUCH_FRICTION * margin.peak):
        yield (
            f"friction.static of {joint}, {margin.breakaway[j]:.3g} N m, is {margin.breakaway[j] / margin.peak[j]:.0%} "
            f"of drive.peak_torque, {margin.peak[j]:.3g} N m. Are both on the motor side?"
        )
    for j, joint in _named(robot, margin.friction_at_speed > _MUCH_FRICTION_AT_SPEED * margin.peak):
        yield (
            f"friction.viscous of {joint} takes {margin.friction_at_speed[j] / margin.peak[j]:.0%} of "
            f"drive.peak_torque at the speed limit. Is it a simulator's number, or on the other side of the gearbox?"
        )
    for j, joint in _named(robot, margin.gravity > margin.peak):
        yield (
            f"drive.peak_torque of {joint}, {margin.peak[j]:.3g} N m, cannot hold gravity, {margin.gravity[j]:.3g} N m "
            f"on the motor in the worst pose of its range. Are both on the motor side, is a counterbalance missing "
            f"([springs])?"
        )


def _named(robot: RobotDescription, flags: BoolArray) -> Iterator[tuple[int, str]]:
    return ((int(j), robot.joints[j]) for j in np.flatnonzero(flags))


def _rest(robot: RobotDescription) -> Array:
    q = rest_place(robot).q
    assert q is not None
    return q
