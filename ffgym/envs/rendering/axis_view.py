"""A robot with one axis and no tool: motor and load on the left, a dial with the magnified error on the right."""

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from ffgym.envs.motion import Motion
from ffgym.envs.rendering.camera import Camera
from ffgym.envs.rendering.canvas import Caption, Panel
from ffgym.envs.rendering.marks import Ball, Curve, Mark
from ffgym.envs.rendering.options import Rendering
from ffgym.envs.rendering.paper import GREY, Sheet, round_down
from ffgym.envs.rendering.tool_view import REFERENCE, TRAIL
from ffgym.envs.rendering.view import View
from ffgym.types import Array, IntArray

if TYPE_CHECKING:
    from ffgym.envs.core import TrackingCore

RECENT = 0.6
"""How long the dial looks back [s]."""
MAGNIFIED_SPEED = 100.0
"""Errors grow with the speed: the factor is chosen so that the axis' speed x factor is at most this [rad/s]."""
TICK = np.deg2rad(15.0)


class AxisView(View):
    """See `View`; a trail has reference and error of the first joint, position - reference [rad], link side."""

    trail_width = 2
    azimuth, elevation, margin = -50.0, 35.0, 1.05

    def __init__(self, core: "TrackingCore", options: Rendering) -> None:
        super().__init__(core, options)
        self._factor: dict[int, float] = {}

    def begin(self, i: int, motion: Motion) -> None:
        """See base class."""
        super().begin(i, motion)
        fastest = float(np.abs(motion.reference.dq[:, 0]).max())
        self._factor[i] = max(1.0, round_down(MAGNIFIED_SPEED / max(fastest, 1e-3)))

    def sample(self, ids: IntArray) -> Array:
        """Reference and error now, shape (B', 2)."""
        core, gear = self.core, self.core.robot.drive.gear_ratio[0]
        reference = core.rows[ids, core.columns.position.start]
        return np.stack([reference, -core.signals.error[ids, 0]], axis=1) / gear

    def magnify(self, i: int) -> float:
        """See base class."""
        return self._factor[i] if self.options.magnify is None else self.options.magnify

    def close_up(self, i: int, model: mujoco.MjModel, trail: Array) -> Camera:
        """See base class."""
        dial = _Dial(model, self.whole_robot(i, model).radius)
        return Camera.along(dial.normal, dial.centre, 1.2 * dial.radius)

    def marks(self, i: int, model: mujoco.MjModel, trail: Array) -> list[Mark]:
        """See base class."""
        dial = _Dial(model, self.whole_robot(i, model).radius)
        recent = trail[-int(RECENT / self.core.robot.servo.control_dt) :]
        age = np.linspace(1, 0, len(recent)) * len(recent) * self.core.robot.servo.control_dt / RECENT
        out = dial.radius * (1 - 0.6 * age)
        angle = recent[:, 0] + self.magnify(i) * recent[:, 1]
        thick = 0.008 * dial.radius
        reference, drawn = dial.points(out, recent[:, 0]), dial.points(out, angle)
        return [
            *dial.marks(),
            Curve(points=drawn, colour=TRAIL, width=3.5),
            Curve(points=reference, colour=REFERENCE, width=1.5),
            Curve(points=np.stack([dial.centre, reference[-1]]), colour=REFERENCE, width=3),
            Curve(points=np.stack([dial.centre, drawn[-1]]), colour=TRAIL, width=3.5),
            Ball(centre=reference[-1], radius=2.2 * thick, colour=REFERENCE),
            Ball(centre=drawn[-1], radius=2.6 * thick, colour=TRAIL),
        ]

    def panels(self, i: int, model: mujoco.MjModel, trail: Array, split: float) -> list[Panel]:
        """See base class."""
        camera = self.close_up(i, model, trail)
        bottom = mujoco.mjtGridPos.mjGRID_BOTTOMLEFT
        values = f"{self.core.time[i]:.2f} s\n{np.rad2deg(trail[-1, 0]):.1f} deg\n{np.rad2deg(trail[-1, 1]):.3f} deg"
        left = [Caption(text=self.caption(i)), Caption(text="time\nangle\nerror", values=values, corner=bottom)]
        right = [
            Caption(text=f"blue: reference\nred: axis, error x {self.magnify(i):g}"),
            Caption(text=f"ticks {np.rad2deg(TICK):g} deg, last {RECENT:g} s", corner=bottom),
        ]
        sheet = Sheet(camera=camera)
        return [
            Panel(left=0, right=split, camera=self.whole_robot(i, model), captions=left),
            self.sheet_panel(i, model, trail, split, sheet, right),
        ]


class _Dial:
    """A dial around the first axis of a robot, in front of all its parts."""

    def __init__(self, model: mujoco.MjModel, radius: float) -> None:
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        self.normal: Array = data.xaxis[0].copy()
        self.radius = radius
        self.centre: Array = data.xanchor[0] + 0.5 * radius * self.normal
        self._zero = data.xmat[model.jnt_bodyid[0]].reshape(3, 3)[:, 0].copy()
        self._zero -= (self._zero @ self.normal) * self.normal
        self._quarter = np.cross(self.normal, self._zero)

    def points(self, radius: Array, angle: Array) -> Array:
        """Points (T, 3) at radii [m] and angles [rad] (T,)."""
        flat = np.cos(angle)[:, None] * self._zero + np.sin(angle)[:, None] * self._quarter
        return self.centre + radius[:, None] * flat

    def marks(self) -> list[Mark]:
        """Rim and ticks."""
        around = np.linspace(0, 2 * np.pi, 181)
        marks: list[Mark] = [Curve(points=self.points(np.full(181, self.radius), around), colour=GREY, width=2)]
        for k in range(round(2 * np.pi / TICK)):
            ends = self.points(self.radius * np.array([0.94 if k % 6 else 0.86, 1.0]), np.full(2, k * TICK))
            marks.append(Curve(points=ends, colour=GREY, width=2))
        return marks
