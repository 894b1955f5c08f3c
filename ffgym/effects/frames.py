"""Frames, geometry and resolvers between the truth and its measurement (X1, X2, X4, M6)."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

import numpy as np
import scipy

from ffgym.core.types import Array
from ffgym.effects.effect import ResolverEffect, TrackerEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import ResolverError
from ffgym.effects.wave import Wave, cycles_per_turn, phase
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription


def with_tool_at(recording: Recording, seen: Callable[[Array], Array]) -> Recording:
    """The recording with `seen` of its tool positions [m] (T, 3) in their place; as it is, if it has none."""
    if not recording.has("tcp.position"):
        return recording
    position = seen(recording.vector("tcp.position"))
    columns = {f"tcp.position.{axis}": position[:, k] for k, axis in enumerate("xyz")}
    return Recording(columns=dict(recording.columns) | columns, header=recording.header)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ToolFrame(TrackerEffect):
    """The tracked point is off the TCP, by a vector that turns with the flange."""

    name = "tool_frame"
    code = "X1"
    title = "tool frame"
    equation = r"p_{meas} = p + R(q)\, r"
    side = "tool"
    signature = "tool: an offset that turns with the flange, at rest too"
    way_in = "recorded tool positions; environments see the true tool"
    confusable_with = ("T1", "X2", "X4")
    separating_motions = ("holds", "excitation")

    offset: Array = parameter(
        "r, in the axes of tool0",
        unit="m",
        low=-2e-3,
        high=2e-3,
        per="vector",
        source="chosen: millimetres, as tool frames are taught by hand",
    )

    def measured(self, recording: Recording, robot: RobotDescription) -> Recording:
        """See base class."""

        def seen(position: Array) -> Array:
            _, rotation = RigidArm(robot).tcp_pose(recording.joint_array("link.position"))
            return position + np.einsum("tij,j->ti", rotation, self.offset)

        return with_tool_at(recording, seen)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TrackerFrame(TrackerEffect):
    """Positions turned and shifted about the robot's base, and longer or shorter by a share."""

    name = "tracker_frame"
    code = "X2"
    title = "tracker frame and scale"
    equation = r"p_{meas} = (1 + s)\, R(\phi)\, p + t"
    side = "tool"
    signature = "tool: an affine function of its position, at rest too"
    way_in = "recorded tool positions; environments see the true tool"
    confusable_with = ("T1", "T7", "X1", "X4")
    separating_motions = ("holds", "excitation")

    shift: Array = parameter(
        "t", unit="m", low=-2e-3, high=2e-3, per="vector", source="chosen: millimetres, as frames are fitted to points"
    )
    turn: Array = parameter(
        "phi, rotation vector", unit="rad", low=-1e-3, high=1e-3, per="vector", source="chosen: a millimetre in a metre"
    )
    scale: Array = parameter(
        "s", unit="1", low=-1e-4, high=1e-4, minimum=-0.5, per="machine", source="chosen: some K of thermal expansion"
    )

    def measured(self, recording: Recording, robot: RobotDescription) -> Recording:
        """See base class."""
        turn = scipy.spatial.transform.Rotation.from_rotvec(self.turn.copy()).as_matrix()
        return with_tool_at(recording, lambda position: (1 + self.scale) * position @ turn.T + self.shift)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class JointZeros(TrackerEffect):
    """Geometry that shows in the tool position; forces are too little changed by it to be changed here."""

    name = "joint_zeros"
    code = "X4"
    title = "joint zeros and link lengths"
    equation = r"p_{meas} = p + p_{(1 + e) l}(q + q_0) - p_l(q)"
    side = "tool"
    signature = "tool: a function of the pose, at rest too; nothing in torque"
    way_in = "recorded tool positions; environments see the true tool"
    confusable_with = ("X1", "X2")
    separating_motions = ("holds", "excitation")

    zero: Array = parameter(
        "q_0, link side", unit="rad", low=-5e-4, high=5e-4, source="chosen: half a millimetre in a metre, uncalibrated"
    )
    stretch: Array = parameter(
        "e, of the vector from the joint before to this one",
        unit="1",
        low=-1e-3,
        high=1e-3,
        minimum=-0.5,
        source="chosen: a millimetre in a metre, uncalibrated",
    )

    def measured(self, recording: Recording, robot: RobotDescription) -> Recording:
        """See base class."""

        def seen(position: Array) -> Array:
            geometry = robot.kinematics
            longer = replace(geometry, position=geometry.position * (1 + self.stretch[:, None]))
            q = recording.joint_array("link.position")
            believed = RigidArm(robot).tcp_position(q)
            return position + RigidArm(replace(robot, kinematics=longer)).tcp_position(q + self.zero) - believed

        return with_tool_at(recording, seen)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ResolverRipple(Wave, ResolverEffect):
    """Periodic error of the measured motor angle, on which the servo acts."""

    name = "resolver_ripple"
    code = "M6"
    title = "periodic resolver error"
    equation = r"\theta_{meas} = \theta + A \sin(k \theta + \varphi)"
    side = "motor"
    signature = "torque: grows with the speed squared; tool: periodic, the same at any speed; servo error too"
    way_in = "added to what the servo compares with its set-points, and to the recorded motor angle"
    confusable_with = ("T5",)
    separating_motions = ("slow_triangles", "circles")
    patterns = (("periodic", "motor angle"),)

    amplitude: Array = parameter(
        "A, motor side",
        unit="rad",
        low=0.0,
        high=3e-3,
        minimum=0.0,
        source="1 to 10 arcmin, data sheets of resolvers",
    )
    cycles: Array = cycles_per_turn(1.0, 2.0, 2.0, "1: eccentricity; 2: unequal windings")
    phase: Array = phase()

    def error(self, motor_angle: Array, motor_speed: Array) -> ResolverError:
        """See base class."""
        slope = self.slope(self.amplitude, motor_angle)
        return ResolverError(angle=self.amplitude * self.wave(motor_angle), speed=slope * motor_speed)
