"""Robot of a protocol: limits of its motors and joints, motions within them, poses that load it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array, BoolArray
from ffgym.paths import JointPath, Reference, joint_reference
from ffgym.paths.motions.part import resting_position
from ffgym.robot import RigidArm, RobotDescription, motor_torque

FASTEST = 0.8
"""Largest share of a joint's speed limit that a protocol uses; chosen: some is left for the feedback."""


TOOL_NEARBY = 0.6
"""Travel of the tool in large motions from its rest, as a share of its distance from the base there; chosen: the
loads of a shoulder then differ by a quarter of its torque, and the arm does not fold."""

TOOL_DROP = 0.3
"""Largest descent of the tool, in the same unit; chosen: the tools of the built-in robots stay above the floor."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ProtocolStage:
    """Robot of a protocol, with quantities of motors turned into those of joints."""

    arm: RigidArm

    @property
    def robot(self) -> RobotDescription:
        """Description of the robot."""
        return self.arm.robot

    @property
    def dt(self) -> float:
        """Sample time of references [s]."""
        return self.robot.servo.control_dt

    @property
    def rest(self) -> Array:
        """Joint positions (N,) about which protocols move: home, or as near to zero as can be."""
        return resting_position(self.robot)

    @property
    def span(self) -> Array:
        """Width of the joints' ranges, link side [rad or m], shape (N,)."""
        return np.diff(self.robot.kinematics.range, axis=1)[:, 0]

    @property
    def presliding(self) -> Array:
        """Motor angle over which bristles bend before they slip, f_s / sigma_0 [rad], shape (N,)."""
        friction = self.robot.friction
        return friction.static / friction.bristle_stiffness

    def select_joints(self, joints: Sequence[str]) -> tuple[int, ...]:
        """Return indices of the joints with these names, in the order of the robot; without names all.

        Raises:
            FFGymError: if the robot has no such joint.
        """
        for name in joints:
            check_choice("joint", name, self.robot.joints)
        return tuple(j for j, name in enumerate(self.robot.joints) if not joints or name in joints)

    def only(self, joints: Sequence[int], values: Array | float) -> Array:
        """Return `values` for some joints, zero for the others, shape (N,)."""
        kept = np.zeros(self.robot.n_joints)
        kept[list(joints)] = np.broadcast_to(values, kept.shape)[list(joints)]
        return kept

    def joint_side(self, motor: Array | float) -> Array:
        """Convert a way or speed of each motor [rad] to one of its own joint, shape (N,), without direction."""
        way: Array = motor / np.abs(self.robot.drive.gear_ratio)
        return way

    @property
    def motor_speed(self) -> Array:
        """Speed of each motor at the largest speed that a protocol uses [rad/s], shape (N,)."""
        speed: Array = FASTEST * self.robot.kinematics.max_speed * np.abs(self.robot.drive.gear_ratio)
        return speed

    def keeps_tool_near(self, q: Array) -> BoolArray:
        """Tell if the tool, if any, is near its place at rest, for joint positions (T, N); shape (T,)."""
        if self.robot.tool is None:
            return np.ones(len(q), dtype=np.bool_)
        tip, rest = self.arm.tcp_position(q), self.arm.tcp_position(self.rest[None])
        unit, pull = np.linalg.norm(rest), np.linalg.norm(self.robot.gravity)
        down = np.divide(self.robot.gravity, pull, out=np.zeros(3), where=pull > 0)
        near: BoolArray = np.linalg.norm(tip - rest, axis=1) <= TOOL_NEARBY * unit
        return near & ((tip - rest) @ down <= TOOL_DROP * unit)

    def about(self, pose: Array, way: Array) -> Array:
        """Find joint positions nearest to `pose` (N,) from which every joint can go `way` (N,) to either side.

        Raises:
            FFGymError: if the range of a joint is too small.
        """
        low, high = self.robot.kinematics.range.T
        narrow = np.flatnonzero(2 * way > high - low)
        if narrow.size:
            j = int(narrow[0])
            unit = self.robot.kinematics.units[j]
            raise FFGymError(
                f"joint {self.robot.joints[j]} would go {2 * way[j]:.4g} {unit}, more than its range of "
                f"{high[j] - low[j]:.4g} {unit}. Ask for less, or leave the joint out."
            )
        return np.clip(pose, low + way, high - way)


MOST_TORQUE = 0.9
"""Largest share of peak torque that a rigid arm may take on a motion; chosen: the rest is for feedback and what the
description does not know."""

LARGE_TORQUE = 0.5
"""Share of peak torque up to which motions are enlarged that want to be large; chosen: half is left for a payload."""

_COARSE = 0.01
"""Time between the instants at which torques are examined [s]; chosen: those of planned motions change within 0.1 s."""

_CLOSE = 0.004
"""Tolerance of the size of a motion."""


def torque_use(arm: RigidArm, reference: Reference) -> float:
    """Compute the largest share of peak torque that a rigid arm takes on a motion, friction included."""
    every = _stride(reference)
    return _use(arm, reference.q[::every], reference.dq[::every], reference.ddq[::every])


def _stride(motion: Reference | JointPath) -> int:
    """Samples from one instant that is examined to the next."""
    return max(1, round(_COARSE / float(motion.t[1])))


def _use(arm: RigidArm, q: Array, dq: Array, ddq: Array) -> float:
    torque = motor_torque(arm, q, dq, ddq).total
    return float(np.max(np.abs(torque) / arm.robot.drive.peak_torque))


def check_torque(arm: RigidArm, reference: Reference) -> None:
    """Check that the drives can give the torque of a motion."""
    use = torque_use(arm, reference)
    if use > MOST_TORQUE:
        raise FFGymError(
            f"motion {reference.name!r} takes {use:.0%} of the peak torque of a drive, must be at most "
            f"{MOST_TORQUE:.0%}. Ask for less speed or way, or check the description with ffgym robot check."
        )


def shrunk(stage: ProtocolStage, path: JointPath) -> Reference:
    """A motion, made smaller about where it starts until it keeps the tool near and takes at most LARGE_TORQUE."""
    arm = stage.arm
    every = _stride(path)
    way, dq, ddq = path.q[::every] - path.q[0], path.dq[::every], path.ddq[::every]

    def fits(size: float) -> bool:
        q = path.q[0] + size * way
        return bool(stage.keeps_tool_near(q).all()) and _use(arm, q, size * dq, size * ddq) <= LARGE_TORQUE

    low, high = 0.0, 1.0
    if fits(high):
        low = high
    while high - low > _CLOSE:
        middle = (low + high) / 2
        low, high = (middle, high) if fits(middle) else (low, middle)
    if low == 0.0:
        raise FFGymError(
            f"no motion, however small, takes at most {LARGE_TORQUE:.0%} of the drives' peak torque and keeps the tool "
            f"near where it rests. Choose another home, or check the description with ffgym robot check."
        )
    q = path.q[0] + low * (path.q - path.q[0])
    return joint_reference(arm.robot, replace(path, q=q, dq=low * path.dq, ddq=low * path.ddq))


NEARBY = 0.15
"""Distance of poses from the rest position, as a share of each joint's range to either side; chosen: the arm stays in
the part of its space where its home is. Obstacles around the robot are not known."""

_CANDIDATES = 512
"""Poses examined; chosen: in six dimensions more of them widen the spread of loads by a few percent only."""

LEAST_SPREAD = 0.01
"""Spread of a motor's load over nearby poses, as a share of peak torque, below which gravity does not load it."""


def nearby_poses(stage: ProtocolStage, way: Array) -> Array:
    """Poses spread evenly around the rest position, which comes first, shape (P, N).

    Every joint can go `way` (N,) to either side, the tool is near where it rests, and the drives hold the arm with at
    most half of their torque.

    Raises:
        FFGymError: if the drives cannot do so even in the rest position.
    """
    robot = stage.robot
    about = stage.about(stage.rest, way)
    unit = scipy.stats.qmc.Halton(d=robot.n_joints, scramble=False).random(_CANDIDATES)
    low, high = robot.kinematics.range.T
    around = np.clip(about + (2 * unit - 1) * NEARBY * stage.span, low + way, high - way)
    poses = np.vstack([about, around])
    light = np.all(np.abs(_loads(stage, poses)) <= LARGE_TORQUE, axis=1)
    if not light[0]:
        raise FFGymError(
            f"holding the arm in its rest position takes more than {LARGE_TORQUE:.0%} of a drive's torque."
        )
    return poses[light & stage.keeps_tool_near(poses)]


def load_ladder(stage: ProtocolStage, joint: int, count: int, way: Array) -> Array:
    """Up to `count` poses in which one motor carries evenly spread loads, shape (P, N).

    A motor that gravity cannot load gets one.
    """
    poses = nearby_poses(stage, way)
    load = _loads(stage, poses)[:, joint]
    if count == 1 or np.ptp(load) < LEAST_SPREAD:
        return poses[:1]
    wanted = np.linspace(load.min(), load.max(), count)
    nearest = np.abs(load - wanted[:, None]).argmin(axis=1)
    chosen: Array = poses[list(dict.fromkeys(nearest.tolist()))]
    return chosen


def spread_poses(stage: ProtocolStage, count: int, way: Array) -> Array:
    """Up to `count` poses as far from each other as can be, in loads of all motors and positions; shape (P, N).

    Each one is, of the candidates, the farthest from those chosen before.
    """
    poses = nearby_poses(stage, way)
    features = np.hstack([_in_spans(_loads(stage, poses)), _in_spans(poses)])
    chosen = [0]
    while len(chosen) < min(count, len(poses)):
        away = np.linalg.norm(features[:, None] - features[chosen], axis=2).min(axis=1)
        chosen.append(int(away.argmax()))
    return poses[chosen]


def _loads(stage: ProtocolStage, poses: Array) -> Array:
    """Compute the torque of each motor that holds the arm, as a share of its peak torque, shape (P, N)."""
    drive = stage.robot.drive
    load: Array = drive.motor_torque(stage.arm.holding_torque(poses)) / drive.peak_torque
    return load


def _in_spans(values: Array) -> Array:
    """Columns in units of their spread; those without spread are zero."""
    spread = np.ptp(values, axis=0)
    return np.divide(values, spread, out=np.zeros_like(values), where=spread > 1e-9 * np.abs(values).max())
