"""A robot without a tool: all of it on the left, a gauge of one joint with the magnified error on the right."""

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from ffgym.core.types import Array, IntArray
from ffgym.envs.motion import Motion
from ffgym.envs.rendering.camera import Camera, Rendering
from ffgym.envs.rendering.canvas import Caption, Panel
from ffgym.envs.rendering.gauge import Dial, Gauge, Ruler
from ffgym.envs.rendering.paper import Ball, Curve, Mark, Sheet
from ffgym.envs.rendering.tool_view import REFERENCE, TRAIL
from ffgym.envs.rendering.view import View
from ffgym.recordings.metrics import magnification, magnified

if TYPE_CHECKING:
    from ffgym.envs.core import TrackingCore

RECENT = 0.6
"""How long the gauge looks back [s]."""
MAGNIFIED_SPEED = 100.0
"""Errors grow with the speed: the factor is chosen so that the axis' speed x factor is at most this [rad/s], or this
times half of a slide's range a second."""


class AxisView(View):
    """See `View`; a trail has reference and error of one joint, position - reference [rad or m], link side.

    The joint is the one that moves through the largest share of its range.
    """

    trail_width = 2
    azimuth, elevation, margin = -50.0, 35.0, 1.05

    def __init__(self, core: "TrackingCore", options: Rendering) -> None:
        super().__init__(core, options)
        self._factor: dict[int, float] = {}
        self._joint = np.zeros(core.n, dtype=np.int64)

    def begin(self, i: int, motion: Motion) -> None:
        """See base class."""
        super().begin(i, motion)
        kinematics = self.core.robot.kinematics
        self._joint[i] = j = int(np.argmax(np.ptp(motion.reference.q, axis=0) / np.ptp(kinematics.range, axis=1)))
        unit = float(np.ptp(kinematics.range[j])) / 2 if kinematics.is_sliding[j] else 1.0
        fastest = float(np.abs(motion.reference.dq[:, j]).max()) / unit
        self._factor[i] = magnification(MAGNIFIED_SPEED, max(fastest, 1e-3))

    def sample(self, ids: IntArray) -> Array:
        """Reference and error now, shape (B', 2)."""
        core, drive, rows = self.core, self.core.robot.drive, np.arange(len(ids))
        reference = drive.joint_angle(core.rows[ids, core.columns.position])
        away = drive.joint_angle(-core.signals.error[ids])
        return np.stack([reference[rows, self._joint[ids]], away[rows, self._joint[ids]]], axis=1)

    def magnify(self, i: int) -> float:
        """See base class."""
        return self._factor[i] if self.options.magnify is None else self.options.magnify

    def close_up(self, i: int, model: mujoco.MjModel, trail: Array) -> Camera:
        """See base class."""
        return self._gauge(i, model).camera

    def marks(self, i: int, model: mujoco.MjModel, trail: Array) -> list[Mark]:
        """See base class."""
        gauge = self._gauge(i, model)
        recent = trail[-int(RECENT / self.core.robot.servo.control_dt) :]
        age = np.linspace(1, 0, len(recent)) * len(recent) * self.core.robot.servo.control_dt / RECENT
        thick = 0.008 * gauge.radius
        reference = gauge.points(age, recent[:, 0])
        drawn = gauge.points(age, magnified(recent[:, 0], recent[:, 1], self.magnify(i)))
        return [
            *gauge.marks(),
            Curve(points=drawn, colour=TRAIL, width=3.5),
            Curve(points=reference, colour=REFERENCE, width=1.5),
            Curve(points=np.stack([gauge.foot(reference[-1]), reference[-1]]), colour=REFERENCE, width=3),
            Curve(points=np.stack([gauge.foot(drawn[-1]), drawn[-1]]), colour=TRAIL, width=3.5),
            Ball(centre=reference[-1], radius=2.2 * thick, colour=REFERENCE),
            Ball(centre=drawn[-1], radius=2.6 * thick, colour=TRAIL),
        ]

    def panels(self, i: int, model: mujoco.MjModel, trail: Array, split: float) -> list[Panel]:
        """See base class."""
        gauge = self._gauge(i, model)
        bottom = mujoco.mjtGridPos.mjGRID_BOTTOMLEFT
        values = f"{self.core.time[i]:.2f} s\n{gauge.text(trail[-1, 0], 1)}\n{gauge.text(trail[-1, 1], 3)}"
        name = f"{self.core.robot.joints[self._joint[i]]}\n" if self.core.robot.n_joints > 1 else ""
        left = [Caption(text=self.caption(i)), Caption(text=f"time\n{gauge.word}\nerror", values=values, corner=bottom)]
        right = [
            Caption(text=f"{name}blue: reference\nred: axis, error x {self.magnify(i):g}"),
            Caption(text=f"ticks {gauge.tick_text}, last {RECENT:g} s", corner=bottom),
        ]
        sheet = Sheet(camera=gauge.camera)
        return [
            Panel(left=0, right=split, camera=self.whole_robot(i, model), captions=left),
            self.sheet_panel(i, model, trail, split, sheet, right),
        ]

    def _gauge(self, i: int, model: mujoco.MjModel) -> Gauge:
        joint, kinematics = int(self._joint[i]), self.core.robot.kinematics
        whole = self.whole_robot(i, model)
        if kinematics.is_sliding[joint]:
            return Ruler(whole.centre, whole.radius, kinematics.range[joint])
        return Dial(whole.centre, whole.radius)
