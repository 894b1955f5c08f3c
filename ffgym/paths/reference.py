"""The reference a drive gets: joint motion sampled at the control step, checked against the robot's limits."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.paths import CartesianPath, JointPath
from ffgym.recordings import Phase
from ffgym.robot import RigidArm, RobotDescription, solve_path
from ffgym.robot.inverse_kinematics import joint_rates


@dataclass(frozen=True, kw_only=True, eq=False)
class Reference:
    """Joint motion sampled at the control step, link side."""

    name: str
    robot: RobotDescription
    t: Array
    """Times [s], every `control_dt` from 0, shape (T,)."""
    q: Array
    """[rad], shape (T, N)."""
    dq: Array
    """[rad/s], shape (T, N)."""
    ddq: Array
    """[rad/s^2], shape (T, N)."""
    phases: tuple[Phase, ...]

    def __post_init__(self) -> None:
        for name in ("q", "dq", "ddq"):
            check_shape(f"reference {name}", getattr(self, name), (len(self.t), self.robot.n_joints))
        _check_step(self)
        _check_limits(self)

    @property
    def motor_q(self) -> Array:
        """Motor angle [rad], shape (T, N)."""
        return self.robot.drive.motor_angle(self.q)

    @property
    def motor_dq(self) -> Array:
        """Motor speed [rad/s], shape (T, N)."""
        return self.robot.drive.motor_angle(self.dq)

    @property
    def motor_ddq(self) -> Array:
        """Motor acceleration [rad/s^2], shape (T, N)."""
        return self.robot.drive.motor_angle(self.ddq)

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return float(self.t[-1])


def cartesian_reference(
    arm: RigidArm, path: CartesianPath, rotation: Array | None = None, *, seed: Array | None = None
) -> Reference:
    """Joint reference whose rigid arm follows a TCP path.

    Args:
        arm: the robot.
        path: the motion, sampled at the robot's control step; if it says how the tool turns, the arm follows that too.
        rotation: orientation of tool0 in the world for a path that says none, shape (3, 3); None takes the work area's,
            and leaves the orientation free where that has none.
        seed: joint positions near the branch that is wanted [rad or m], shape (N,); None takes the work area's home.

    Raises:
        FFGymError: if the path is unreachable, near a singularity, or beyond a joint or speed limit.
    """
    area = arm.robot.work_area
    if path.rotation is not None:
        if rotation is not None:
            raise FFGymError(f"Path {path.name!r} says how the tool turns; rotation must be None.")
        rotation = path.rotation
    elif rotation is None and area is not None:
        rotation = area.tool_rotation
    seed = _seed(arm, seed)
    q = solve_path(arm, path.position, rotation, seed)
    dq, ddq = joint_rates(arm, q, seed, *_twists(path, free=rotation is None))
    return Reference(name=path.name, robot=arm.robot, t=path.t, q=q, dq=dq, ddq=ddq, phases=path.phases)


def _seed(arm: RigidArm, seed: Array | None) -> Array:
    """Joint positions (N,) where the inverse kinematics begins."""
    if seed is not None:
        return seed
    if arm.robot.work_area is None:
        raise FFGymError(f"Robot {arm.robot.name!r} has no work area; give its motions in joint space, or a seed.")
    return arm.robot.work_area.home


def _twists(path: CartesianPath, *, free: bool) -> tuple[Array, Array]:
    """Velocity and acceleration of the tool, (T, 6) each, or (T, 3) if its orientation is `free`."""
    if free:
        return path.velocity, path.acceleration
    still = np.zeros_like(path.velocity)
    spin = still if path.angular_velocity is None else path.angular_velocity
    change = still if path.angular_acceleration is None else path.angular_acceleration
    return np.hstack([path.velocity, spin]), np.hstack([path.acceleration, change])


def joint_reference(robot: RobotDescription, path: JointPath) -> Reference:
    """Reference for a motion that is given in joint space.

    Raises:
        FFGymError: if it has another number of joints, or is beyond a joint or speed limit.
    """
    return Reference(name=path.name, robot=robot, t=path.t, q=path.q, dq=path.dq, ddq=path.ddq, phases=path.phases)


def _check_step(reference: Reference) -> None:
    dt = reference.robot.servo.control_dt
    if len(reference.t) < 2 or np.abs(np.diff(reference.t) - dt).max() > 1e-9:
        raise FFGymError(
            f"Reference {reference.name!r} must be sampled every control_dt = {dt} s; pass dt={dt} to the path."
        )


def _check_limits(reference: Reference) -> None:
    kinematics, joints = reference.robot.kinematics, reference.robot.joints
    beyond = np.argwhere(kinematics.beyond_limits(reference.q))
    if beyond.size:
        row, j = (int(i) for i in beyond[0])
        raise FFGymError(
            f"Reference {reference.name!r}: joint {joints[j]} is at {reference.q[row, j]:.3f} {kinematics.units[j]} at "
            f"{reference.t[row]:.3f} s, must be within {np.round(kinematics.range[j], 3).tolist()} "
            f"{kinematics.units[j]}."
        )
    ratio = np.abs(reference.dq) / kinematics.max_speed
    row, j = (int(i) for i in np.unravel_index(np.argmax(ratio), ratio.shape))
    if ratio[row, j] > 1:
        raise FFGymError(
            f"Reference {reference.name!r}: joint {joints[j]} moves at {reference.dq[row, j]:.3f} "
            f"{kinematics.units[j]}/s at {reference.t[row]:.3f} s, must stay below {kinematics.max_speed[j]:.3f} "
            f"{kinematics.units[j]}/s. Slow the motion down."
        )
