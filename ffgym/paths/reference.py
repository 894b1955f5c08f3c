"""The reference a drive gets: joint motion sampled at the control step, checked against the robot's limits."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError, check_class, check_shape
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
        check_class("robot of a reference", self.robot, RobotDescription, "load_robot makes one")
        check_shape("reference t", self.t, (None,))
        for name in ("q", "dq", "ddq"):
            check_shape(f"reference {name}", getattr(self, name), (len(self.t), self.robot.n_joints))
        dt = self.robot.servo.control_dt
        if len(self.t) < 2 or np.abs(np.diff(self.t) - dt).max() > 1e-9:
            raise FFGymError(
                f"Reference {self.name!r} must be sampled every control_dt = {dt} s; pass dt={dt} to the path."
            )
        self._check_limits()

    def _check_limits(self) -> None:
        kinematics, joints = self.robot.kinematics, self.robot.joints
        beyond = np.argwhere(kinematics.beyond_limits(self.q))
        if beyond.size:
            row, j = (int(i) for i in beyond[0])
            raise FFGymError(
                f"Reference {self.name!r}: joint {joints[j]} is at {self.q[row, j]:.3f} {kinematics.units[j]} at "
                f"{self.t[row]:.3f} s, must be within {np.round(kinematics.range[j], 3).tolist()} "
                f"{kinematics.units[j]}."
            )
        ratio = np.abs(self.dq) / kinematics.max_speed
        row, j = (int(i) for i in np.unravel_index(np.argmax(ratio), ratio.shape))
        if ratio[row, j] > 1:
            raise FFGymError(
                f"Reference {self.name!r}: joint {joints[j]} moves at {self.dq[row, j]:.3f} {kinematics.units[j]}/s "
                f"at {self.t[row]:.3f} s, must stay below {kinematics.max_speed[j]:.3f} {kinematics.units[j]}/s. "
                f"Slow the motion down."
            )

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
    check_class("arm", arm, RigidArm, "RigidArm(robot) makes one of a description")
    check_class("path", path, CartesianPath, "circle_test makes one")
    area = arm.robot.work_area
    if path.rotation is not None:
        if rotation is not None:
            raise FFGymError(f"Path {path.name!r} says how the tool turns; rotation must be None.")
        rotation = path.rotation
    elif rotation is None and area is not None:
        rotation = area.tool_rotation
    if seed is None:
        if area is None:
            raise FFGymError(f"Robot {arm.robot.name!r} has no work area; give its motions in joint space, or a seed.")
        seed = area.home
    q = solve_path(arm, path.position, rotation, seed)
    twist, change = path.velocity, path.acceleration
    if rotation is not None:  # velocity and acceleration of the whole tool, which may turn
        still = np.zeros_like(path.velocity)
        twist = np.hstack([twist, still if path.angular_velocity is None else path.angular_velocity])
        change = np.hstack([change, still if path.angular_acceleration is None else path.angular_acceleration])
    dq, ddq = joint_rates(arm, q, seed, twist, change)
    return Reference(name=path.name, robot=arm.robot, t=path.t, q=q, dq=dq, ddq=ddq, phases=path.phases)


def joint_reference(robot: RobotDescription, path: JointPath) -> Reference:
    """Reference for a motion that is given in joint space.

    Raises:
        FFGymError: if it has another number of joints, or is beyond a joint or speed limit.
    """
    check_class("path", path, JointPath, "joint_sine makes one")
    return Reference(name=path.name, robot=robot, t=path.t, q=path.q, dq=path.dq, ddq=path.ddq, phases=path.phases)
