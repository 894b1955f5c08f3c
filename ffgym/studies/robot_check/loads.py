"""What gravity, friction, inertia and the circle test ask of the motors."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths import SPEEDS
from ffgym.robot import RigidArm, RobotDescription, motor_torque
from ffgym.studies.circles import circle_references
from ffgym.studies.robot_check.shape import poses_in_range


@dataclass(frozen=True, kw_only=True, eq=False)
class Gravity:
    """Torque that holds the arm still, per joint, springs of the arm included; a sliding joint has N for N m."""

    places: dict[str, Array]
    """Link side [N m], shape (N,), by the name of the place."""
    worst: Array
    """Largest size over poses spread over the joint ranges, link side [N m], shape (N,)."""
    motor_worst: Array | None
    """The same, motor side [N m]; None where the gear ratios are not known."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Margin:
    """What is left of each motor's peak torque, motor side, shape (N,)."""

    peak: Array
    """[N m]."""
    gravity: Array
    """Largest holding torque over the joint ranges [N m]."""
    breakaway: Array
    """Torque that friction takes at the start of a motion [N m]."""
    friction_at_speed: Array
    """Friction at the speed limit of the joint, by the viscous line [N m]."""
    at_start: Array
    """Peak less gravity and breakaway, as a share of the peak; below 0, the joint cannot move everywhere."""
    at_speed: Array
    """Peak less gravity and friction at the speed limit, as a share of the peak."""
    acceleration: Array
    """What the rest at the start gives this joint alone at home [rad/s^2, m/s^2], link side; 0 if nothing is left."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Inertia:
    """Inertia that each motor turns at home, the other joints standing still, shape (N,)."""

    link: Array
    """Of the links, link side [kg m^2, kg]."""
    rotor: Array
    """Of the rotor, motor side [kg m^2]."""
    ratio: Array
    """Links over rotor, both on the motor side: above about 10, servos are hard to tune."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CircleUse:
    """Largest use along the circles at every position of the work area, without oscillation."""

    speed: float
    """Of the TCP [m/s]."""
    torque: Array | None = None
    """Share of the peak torque, shape (N,); None if the robot cannot follow."""
    joint_speed: Array | None = None
    """Share of the joint speed limits, shape (N,); None if the robot cannot follow."""
    problem: str = ""
    """Why it cannot follow."""


def gravity_of(robot: RobotDescription, places: dict[str, Array], *, with_gears: bool) -> Gravity:
    """Holding torque at joint positions by name, and its worst over the ranges; `with_gears` also at the motors."""
    arm = RigidArm(robot)
    everywhere = arm.holding_torque(poses_in_range(robot))
    return Gravity(
        places={name: arm.holding_torque(q[None])[0] for name, q in places.items()},
        worst=np.abs(everywhere).max(axis=0),
        motor_worst=np.abs(robot.drive.motor_torque(everywhere)).max(axis=0) if with_gears else None,
    )


def inertia_of(robot: RobotDescription, q: Array) -> Inertia:
    """Inertias at joint positions `q` (N,)."""
    link = np.diag(RigidArm(robot).mass_matrix(q[None])[0]).copy()
    rotor = robot.drive.rotor_inertia
    return Inertia(link=link, rotor=rotor, ratio=link / (robot.drive.gear_ratio**2 * rotor))


def margin_of(robot: RobotDescription, q: Array) -> Margin:
    """Torque margins of the motors; accelerations at joint positions `q` (N,)."""
    drive, friction = robot.drive, robot.friction
    gravity = gravity_of(robot, {}, with_gears=True).motor_worst
    assert gravity is not None
    at_speed = friction.steady_torque(np.abs(drive.gear_ratio) * robot.kinematics.max_speed)
    left = drive.peak_torque - gravity - friction.static
    turned = drive.rotor_inertia + inertia_of(robot, q).link / drive.gear_ratio**2
    return Margin(
        peak=drive.peak_torque,
        gravity=gravity,
        breakaway=friction.static,
        friction_at_speed=at_speed,
        at_start=left / drive.peak_torque,
        at_speed=(drive.peak_torque - gravity - at_speed) / drive.peak_torque,
        acceleration=np.maximum(left, 0.0) / turned / np.abs(drive.gear_ratio),
    )


def circle_use(robot: RobotDescription, speed: float = SPEEDS[1]) -> CircleUse:
    """Use along the circles of the thesis at a TCP speed [m/s]; up to 40 mm/s the robot of the thesis followed."""
    arm = RigidArm(robot)
    try:
        references = circle_references(arm, None, [speed]).values()
    except FFGymError as error:
        return CircleUse(speed=speed, problem=str(error))
    torques = [np.abs(motor_torque(arm, r.q, r.dq, r.ddq).total).max(axis=0) for r in references]
    speeds = [np.abs(r.dq).max(axis=0) for r in references]
    return CircleUse(
        speed=speed,
        torque=np.max(torques, axis=0) / robot.drive.peak_torque,
        joint_speed=np.max(speeds, axis=0) / robot.kinematics.max_speed,
    )
