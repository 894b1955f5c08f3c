"""Programs of a trial: the motion that a controller is to carry out, as it is without any correction."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from ffgym.core.types import Array, BoolArray
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.robot import RigidArm
from ffgym.robot.description import log_header

_FAMILIES = {"reference.position": "motor_q", "reference.velocity": "motor_dq", "reference.acceleration": "motor_ddq"}
"""Columns of a program, and what of a reference they hold."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrialProgram:
    """One motion at one speed and place, in which runs with and without the correction are compared.

    What a run is measured against is this program, not what the controller was told: a correction changes that.
    """

    recording: Recording
    """Set-points of the program, motor side, the tool path of a rigid arm where the robot has a tool, and phases."""

    @property
    def name(self) -> str:
        """Name of the motion."""
        return self.recording.header.segment

    @property
    def duration(self) -> float:
        """Time of one pass [s]."""
        return float(self.recording.t[-1])

    @cached_property
    def joints(self) -> Array:
        """Set-points behind the gearbox [rad or m], shape (T, N)."""
        return self.recording.header.joint_side(self.recording.joint_array("reference.position"))

    @property
    def scored(self) -> BoolArray:
        """Rows that count, shape (T,)."""
        return find_scored_rows(self.recording)

    @property
    def speed(self) -> float | None:
        """Mean speed of the tool where it counts [m/s]; None for a robot without tool."""
        if not self.recording.has("tcp_reference.position"):
            return None
        way = np.linalg.norm(np.diff(self.recording.vector("tcp_reference.position"), axis=0), axis=1)
        return float(way[self.scored[1:]].mean() / self.recording.dt)

    @property
    def place(self) -> Array | None:
        """Mean position of the tool where it counts [m], shape (3,); None for a robot without tool."""
        if not self.recording.has("tcp_reference.position"):
            return None
        return np.asarray(self.recording.vector("tcp_reference.position")[self.scored].mean(axis=0))

    def tool_path(self, t: Array) -> Array:
        """Compute the tool path of the program at times [s] (T,), shape (T, 3) [m]."""
        return np.asarray(self._tool_curve(t))

    @cached_property
    def _tool_curve(self) -> "scipy.interpolate.CubicSpline":
        return scipy.interpolate.CubicSpline(self.recording.t, self.recording.vector("tcp_reference.position"))

    @property
    def is_closed(self) -> bool:
        """True if the program ends where it begins, so that laps can follow each other."""
        q = self.joints
        return bool(np.abs(q[-1] - q[0]).max() < 1e-3 * np.ptp(q, axis=0).max())

    def make_reference(self, arm: RigidArm, laps: int = 1) -> Reference:
        """Make the reference of a run for a simulation: the program, several times over."""
        recording, n = self.recording, len(self.recording)
        motor = [recording.joint_array(family) for family in _FAMILIES]
        q, dq, ddq = (np.tile(recording.header.joint_side(values), (laps, 1)) for values in motor)
        phases = [
            replace(phase, start=phase.start + lap * n * recording.dt, end=phase.end + lap * n * recording.dt)
            for lap in range(laps)
            for phase in recording.header.phases
        ]
        t = np.arange(laps * n, dtype=np.float64) * arm.robot.servo.control_dt
        return Reference(name=self.name, robot=arm.robot, t=t, q=q, dq=dq, ddq=ddq, phases=tuple(phases))


def find_scored_rows(recording: Recording) -> BoolArray:
    """Find the rows of a program, or of a pass of it, that count, shape (T,).

    Circles if there are any, as leads are no part of the test; else all in motion.
    """
    circles = recording.mask(kind="circle")
    return circles if circles.any() else ~recording.mask(kind="standstill")


def make_program(arm: RigidArm, reference: Reference) -> TrialProgram:
    """Make the program of a motion; its recording can be looked at as any other."""
    robot = arm.robot
    columns = {"timestamp": reference.t}
    for family, name in _FAMILIES.items():
        values = getattr(reference, name)
        columns |= {f"{family}.{joint}": values[:, j] for j, joint in enumerate(robot.joints)}
    if robot.tool is not None:
        tool = arm.tcp_position(reference.q)
        columns |= {f"tcp_reference.position.{axis}": tool[:, k] for k, axis in enumerate("xyz")}
    header = replace(log_header(robot, reference.name), position_side="motor", phases=reference.phases)
    return TrialProgram(recording=Recording(columns, header))
