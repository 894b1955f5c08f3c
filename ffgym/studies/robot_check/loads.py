"""Loads of the motors by gravity, friction and inertia, and stability of the servos."""

from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.robot import RigidArm, RobotDescription
from ffgym.studies.robot_check.poles import servo_poles
from ffgym.studies.robot_check.shape import poses_in_range

_STABLE = 1 + 1e-7
"""Growth in a step that counts as none: finite differences are no better; at 0.25 ms it doubles in half an hour."""
_HIGHEST_MARGIN = 100.0
"""End of the search for the gain margin: a loop with more is far from any limit."""
_SEARCH_STEPS = 12
"""Halvings of the search on a logarithmic scale: log(100) / 2^12 is 0.1 %."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Gravity:
    """Torque that holds the arm still, per joint, springs of the arm included; a sliding joint has N for N m."""

    places: dict[str, Array]
    """Torque by the name of the pose, link side [N m], shape (N,)."""
    worst: Array
    """Largest size over poses spread over the joint ranges, link side [N m], shape (N,)."""
    motor_worst: Array | None
    """Largest size, motor side [N m]; None if the gear ratios are not known."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Margin:
    """Margin of each motor's peak torque, motor side, shape (N,)."""

    peak: Array
    """Peak torque [N m]."""
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
    """Acceleration of this joint alone at home by the rest at the start [rad/s^2, m/s^2], link side; 0 without rest."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Inertia:
    """Inertia that each motor turns at home, the other joints standing still, shape (N,)."""

    link: Array
    """Inertia of the links, link side [kg m^2, kg]."""
    rotor: Array
    """Inertia of the rotor, motor side [kg m^2]."""
    ratio: Array
    """Links over rotor, both on the motor side: above about 10, servos are hard to tune."""


def compute_gravity(robot: RobotDescription, places: dict[str, Array], *, with_gears: bool) -> Gravity:
    """Compute the holding torque at positions by name, and its worst over the ranges; `with_gears` also at motors."""
    arm = RigidArm(robot)
    everywhere = arm.holding_torque(poses_in_range(robot))
    return Gravity(
        places={name: arm.holding_torque(q[None])[0] for name, q in places.items()},
        worst=np.abs(everywhere).max(axis=0),
        motor_worst=np.abs(robot.drive.motor_torque(everywhere)).max(axis=0) if with_gears else None,
    )


def compute_inertia(robot: RobotDescription, q: Array) -> Inertia:
    """Compute the inertias at joint positions `q` (N,)."""
    link = np.diag(RigidArm(robot).mass_matrix(q[None])[0]).copy()
    rotor = robot.drive.rotor_inertia
    return Inertia(link=link, rotor=rotor, ratio=link / (robot.drive.gear_ratio**2 * rotor))


def compute_margin(robot: RobotDescription, q: Array) -> Margin:
    """Compute torque margins of the motors, with accelerations at joint positions `q` (N,)."""
    drive, friction = robot.drive, robot.friction
    gravity = compute_gravity(robot, {}, with_gears=True).motor_worst
    assert gravity is not None
    at_speed = friction.steady_torque(np.abs(drive.gear_ratio) * robot.kinematics.max_speed)
    left = drive.peak_torque - gravity - friction.static
    turned = drive.rotor_inertia + compute_inertia(robot, q).link / drive.gear_ratio**2
    return Margin(
        peak=drive.peak_torque,
        gravity=gravity,
        breakaway=friction.static,
        friction_at_speed=at_speed,
        at_start=left / drive.peak_torque,
        at_speed=(drive.peak_torque - gravity - at_speed) / drive.peak_torque,
        acceleration=np.maximum(left, 0.0) / turned / np.abs(drive.gear_ratio),
    )


@dataclass(frozen=True, kw_only=True)
class ServoLoop:
    """Small motions about rest, all joints together, of the very simulation, linear and without friction."""

    place: str
    stable: bool
    gain_margin: float | None = None
    """Factor on all gains at which the loop becomes unstable; None if it is beyond 100, or the loop is unstable."""
    frequency: float = 0.0
    """Frequency of the least damped oscillation [Hz]."""
    damping: float = 1.0
    """Damping ratio of that oscillation; 1 where nothing oscillates."""
    problem: str = ""
    """Reason why the robot does not rest there."""


def servo_loop(robot: RobotDescription, place: str, q: Array) -> ServoLoop:
    """Analyse the servo loop of the robot at rest at joint positions `q` (N,), link side."""
    try:
        poles = servo_poles(robot, q)
    except FFGymError as error:
        return ServoLoop(place=place, stable=False, problem=str(error))
    stable = bool(np.abs(poles).max() < _STABLE)
    swinging = np.log(poles[poles.imag > 0]) / robot.physics_dt
    ratios = -swinging.real / np.abs(swinging)
    worst = int(np.argmin(ratios)) if swinging.size else None
    return ServoLoop(
        place=place,
        stable=stable,
        gain_margin=_gain_margin(robot, q) if stable else None,
        frequency=0.0 if worst is None else float(np.abs(swinging[worst]) / (2 * np.pi)),
        damping=1.0 if worst is None else float(ratios[worst]),
    )


def _gain_margin(robot: RobotDescription, q: Array) -> float | None:
    """Find the factor on all servo gains at which the loop becomes unstable."""
    servo = robot.servo

    def is_stable(factor: float) -> bool:
        gains = {name: factor * getattr(servo, name) for name in ("position_gain", "velocity_gain", "integral_gain")}
        return bool(np.abs(servo_poles(replace(robot, servo=replace(servo, **gains)), q)).max() < _STABLE)

    if is_stable(_HIGHEST_MARGIN):
        return None
    low, high = 0.0, np.log(_HIGHEST_MARGIN)
    for _ in range(_SEARCH_STEPS):
        middle = (low + high) / 2
        low, high = (middle, high) if is_stable(np.exp(middle)) else (low, middle)
    return float(np.exp(low))
