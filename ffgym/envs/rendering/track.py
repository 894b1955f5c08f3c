"""Tracks of an episode for its pictures: the path, and the deviation of the robot from it."""

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.envs.motion import EpisodeMotion
from ffgym.envs.rendering.canvas import BLUE, RED, plot
from ffgym.recordings.metrics import magnification, magnify, round_down

if TYPE_CHECKING:
    from ffgym.envs.core import TrackingCore

PALE_BLUE, PALE_RED = (0.62, 0.70, 0.85), (0.95, 0.70, 0.68)
"""Circles other than the present one, and their trails."""
GREY = (0.4, 0.4, 0.4)
HUES = {
    "blue": (0.0, 0.45, 0.7),
    "orange": (0.84, 0.37, 0.0),
    "green": (0.0, 0.62, 0.45),
    "pink": (0.8, 0.47, 0.65),
    "yellow": (0.9, 0.62, 0.0),
    "sky": (0.34, 0.71, 0.91),
}
"""Colours of joints, those of Okabe and Ito; a seventh joint has the first one's."""
RECENT = 1.0
"""Time span [s] of plots over time, and of a path without circles before and after now."""
FREE_RADIUS = 0.03
"""Half the side of the close-up of a path without circles [m]."""
CLOSE_UP = 1.75
"""Half the side of the close-up of circles, in radii of the largest."""
TYPICAL_LAG = 0.006
"""The error of the uncompensated robot, RMS, is 4 to 8 ms times its speed; it is drawn as a TYPICAL_SHARE of half
the close-up of a path, or of the range of a joint's motion."""
TYPICAL_SHARE = 1 / 6


class Track(ABC):
    """Track of sub-environment `i` of an engine through one episode, one row per control step."""

    def __init__(self, core: "TrackingCore", i: int, motion: EpisodeMotion, magnify: float) -> None:
        self.core, self.i, self.motion = core, i, motion
        asked = core.settings.rendering.magnify
        self.magnify = magnify if asked is None else asked
        """Factor on the error that is drawn."""
        self._rows: list[Array] = []
        self._recent = round(RECENT / core.robot.servo.control_dt)

    def add(self) -> None:
        """Add the present state."""
        self._rows.append(np.concatenate([self.sample(), self.core.signals.error[self.i]]))

    @property
    def trail(self) -> Array:
        """Samples, and the error of each motor [rad], shape (T, W + N)."""
        return np.array(self._rows)

    def motor_errors(self) -> mujoco.MjvFigure:
        """Plot the motors' errors over the recent time."""
        errors = 1e3 * self.trail[:, -self.core.robot.n_joints :]
        limit = 0.999 / round_down(1 / max(float(np.abs(errors).max()), 1e-3))  # grows in steps: films stand still
        t, last = self._ages(len(errors)), errors[-self._recent :]
        hues = list(HUES.items()) * (1 + last.shape[1] // len(HUES))
        lines = [(np.stack([t, column], axis=1), hue) for column, (_, hue) in zip(last.T, hues, strict=False)]
        names = ", ".join(f"{joint} {word}" for joint, (word, _) in zip(self.core.robot.joints, hues, strict=False))
        span = np.array([[-RECENT, 0.0], [-limit, limit]])
        return plot(lines, span, title="errors of the motors [mrad] over time [s]", xlabel=names)

    def _ages(self, length: int) -> Array:
        """Compute times [s] of the recent samples of `length`, 0 is now."""
        return np.arange(1 - min(length, self._recent), 1, dtype=np.float64) * self.core.robot.servo.control_dt

    @abstractmethod
    def sample(self) -> Array:
        """Compute the nearest point of the path and the deviation from it now, shape (W,)."""

    @abstractmethod
    def close_up(self) -> mujoco.MjvFigure:
        """Plot the path, and the trail with its error magnified."""

    @abstractmethod
    def values(self) -> tuple[str, str]:
        """Return names and numbers of the present state, in lines."""

    @property
    def ball(self) -> Array | None:
        """Point of the robot that the close-up shows [m], (3,)."""
        return None


class ToolTrack(Track):
    """Path of a tool; sampled are the nearest point of the path and the deviation from it [m]."""

    def __init__(self, core: "TrackingCore", i: int, motion: EpisodeMotion) -> None:
        at, rows = motion.columns, motion.rows(0)
        self._points = points = rows[:, at.tcp]
        self._centre, self._normal = motion.plane
        self._has_circles = bool(np.any(self._normal))
        self._circle = np.cumsum(np.diff(rows[:, at.circle], prepend=-1.0) > 0).clip(min=1)  # counts on at lead-ins
        self._on_circle = rows[:, at.radius] > 0
        self._speed = np.linalg.norm(np.gradient(points, motion.reference.t, axis=0), axis=1)
        far = float(np.linalg.norm(points - self._centre, axis=1).max())
        self._radius = CLOSE_UP * far if self._has_circles else FREE_RADIUS
        typical = TYPICAL_LAG * max(float(self._speed.max()), 1e-3)
        super().__init__(core, i, motion, magnification(TYPICAL_SHARE * self._radius, typical))

    def sample(self) -> Array:
        """Compute nearest point and deviation, shape (6,); the deviation is as long as the path error.

        It lies in the plane of a circle; elsewhere across the direction of motion, all of TCP - reference at rest. The
        lag of the TCP along the path is no deviation and is not magnified.
        """
        core, at = self.core, self.core.columns
        assert core.signals.tcp is not None  # the robot has a tool
        row, tcp = core.rows[self.i], core.signals.tcp[self.i] - core.tcp_offset[self.i]
        if row[at.radius] > 0:
            arm = tcp - self._centre
            flat = arm - (arm @ self._normal) * self._normal
            share = row[at.radius] / max(float(np.linalg.norm(flat)), 1e-12)
            return np.concatenate([self._centre + flat * share, flat * (1 - share)])
        behind = (tcp - row[at.anchor]) @ row[at.axis]
        nearest = row[at.anchor] + behind * row[at.axis] + 0.5 * behind**2 * row[at.bend]
        return np.concatenate([nearest, tcp - nearest])

    def close_up(self) -> mujoco.MjvFigure:
        """Plot path and trail in the plane of the circles, or obliquely from above along with the tool."""
        trail, length = self.trail, len(self._rows)
        drawn = magnify(trail[:, :3], trail[:, 3:6], self.magnify)
        lines = [(np.stack([trail[-1, :3], drawn[-1]]), RED)]
        if self._has_circles:
            present = self._circle == self._circle[length - 1]
            start = int(np.argmax(present))
            lines += [(drawn[start:], RED), (self._points[present], BLUE)]
            lines += [(drawn[run], PALE_RED) for run in find_runs(self._on_circle[:start])]
            lines += [(self._points[run], PALE_BLUE) for run in find_runs(self._on_circle)]
        else:
            lines += [(drawn[-self._recent :], RED)]
            lines += [(self._points[max(0, length - self._recent) : length + self._recent], BLUE)]
        middle, axes = self._centre if self._has_circles else trail[-1, :3], self._axes()
        half, bar = self._radius, round_down(0.5 * self._radius)
        seen = [((points - middle) @ axes.T / half, colour) for points, colour in lines]
        scale = np.array([[-0.95, -0.95], [-0.95 + bar / half, -0.95]])
        title, square = f"blue: path, red: TCP, error x {self.magnify:g}", np.array([[-1.0, 1.0], [-1.0, 1.0]])
        return plot([(scale, GREY), *seen], square, title=title, xlabel=f"bar: {1e3 * bar:g} mm", ticks=False)

    def _axes(self) -> Array:
        """Compute unit vectors that point right and up in the close-up, shape (2, 3)."""
        toward = self._normal if self._has_circles else np.array([0.41, -0.71, 0.57])
        toward = toward if toward[2] >= 0 else -toward
        right = np.array([-toward[1], toward[0], 0.0])
        length = np.linalg.norm(right)
        right = right / length if length > 0.05 else np.array([1.0, 0.0, 0.0])  # seen from above, x points right
        return np.stack([right, np.cross(toward / np.linalg.norm(toward), right)])

    def values(self) -> tuple[str, str]:
        """Return time, speed and path error."""
        row, speed = self._rows[-1], 1e3 * self._speed[len(self._rows) - 1]
        error = 1e3 * float(np.linalg.norm(row[3:6]))
        return "time\nspeed\npath error", f"{self.core.time[self.i]:.2f} s\n{speed:.0f} mm/s\n{error:.3f} mm"

    @property
    def ball(self) -> Array:
        """Nearest point of the path [m], (3,)."""
        return self._rows[-1][:3]


class JointTrack(Track):
    """The joint of a robot without a tool that moves through the largest share of its range.

    Sampled are its reference and error, position - reference [rad or m], link side.
    """

    def __init__(self, core: "TrackingCore", i: int, motion: EpisodeMotion) -> None:
        kinematics, q = core.robot.kinematics, motion.reference.q
        self._joint = j = int(np.argmax(np.ptp(q, axis=0) / np.ptp(kinematics.range, axis=1)))
        self._slides = bool(kinematics.is_sliding[j])
        self._unit, self._per_unit = ("mm", 1e3) if self._slides else ("deg", float(np.rad2deg(1.0)))
        self._span = np.array([q[:, j].min(), q[:, j].max()])
        typical = TYPICAL_LAG * float(np.abs(motion.reference.dq[:, j]).max())
        super().__init__(core, i, motion, magnification(TYPICAL_SHARE * float(np.ptp(self._span)), typical))

    def sample(self) -> Array:
        """Return reference and error of the joint, shape (2,)."""
        core, drive, j = self.core, self.core.robot.drive, self._joint
        reference = drive.joint_angle(core.rows[self.i, core.columns.position])
        return np.array([reference[j], drive.joint_angle(-core.signals.error[self.i])[j]])

    def close_up(self) -> mujoco.MjvFigure:
        """Plot reference and joint over the recent time."""
        trail = self._per_unit * self.trail[-self._recent :, :2]
        drawn, t = magnify(trail[:, 0], trail[:, 1], self.magnify), self._ages(len(self._rows))
        low, high = self._per_unit * self._span
        room = max(0.25 * (high - low), 1e-6)
        lines = [(np.stack([t, drawn], axis=1), RED), (np.stack([t, trail[:, 0]], axis=1), BLUE)]
        title = f"{self.core.robot.joints[self._joint]} [{self._unit}] over time [s]"
        words = f"blue: reference, red: joint, error x {self.magnify:g}"
        return plot(lines, np.array([[-RECENT, 0.0], [low - room, high + room]]), title=title, xlabel=words)

    def values(self) -> tuple[str, str]:
        """Return time, position and error."""
        position, error = self._per_unit * self._rows[-1][:2]
        word = "position" if self._slides else "angle"
        time = f"{self.core.time[self.i]:.2f} s"
        return f"time\n{word}\nerror", f"{time}\n{position:.1f} {self._unit}\n{error:.3f} {self._unit}"


def find_runs(chosen: BoolArray) -> list[slice]:
    """Find runs of True without a gap; each with the sample after it, which closes a circle."""
    edges = np.flatnonzero(np.diff(chosen.astype(np.int8), prepend=0, append=0))
    return [slice(int(start), int(end) + 1) for start, end in zip(edges[::2], edges[1::2], strict=True)]
