"""A robot with a tool: all of it on the left, its path and the magnified error on the right."""

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from ffgym.core.types import Array, IntArray
from ffgym.envs.motion import Motion
from ffgym.envs.rendering.camera import Camera, Rendering
from ffgym.envs.rendering.canvas import Caption, Panel
from ffgym.envs.rendering.paper import Ball, Colour, Curve, GridSheet, Mark, spaced
from ffgym.envs.rendering.tool_path import ToolPath
from ffgym.envs.rendering.view import View
from ffgym.recordings.metrics import magnified

if TYPE_CHECKING:
    from ffgym.envs.core import TrackingCore

REFERENCE: Colour = (0.10, 0.25, 0.55, 1.0)
PALE_REFERENCE: Colour = (0.62, 0.70, 0.85, 1.0)
"""Circles other than the present one."""
TRAIL: Colour = (0.85, 0.08, 0.15, 1.0)
PALE_TRAIL: Colour = (0.95, 0.70, 0.68, 1.0)
"""Trails of the circles before the present one."""


class ToolView(View):
    """See `View`; a trail has the nearest point of the path and the deviation from it [m]."""

    trail_width = 6

    def __init__(self, core: "TrackingCore", options: Rendering) -> None:
        super().__init__(core, options)
        self._centre, self._normal = np.zeros((core.n, 3)), np.zeros((core.n, 3))
        self._paths: dict[int, ToolPath] = {}

    def begin(self, i: int, motion: Motion) -> None:
        """See base class."""
        super().begin(i, motion)
        self._centre[i], self._normal[i] = motion.plane
        self._paths[i] = ToolPath.of(motion)

    def sample(self, ids: IntArray) -> Array:
        """Nearest points and deviations now, shape (B', 6); the deviation is as long as the path error.

        On a circle in its plane; elsewhere across the direction of motion, all of TCP - reference at rest. What the TCP
        lags behind along the path is no deviation and is not magnified.
        """
        core, at = self.core, self.core.columns
        assert core.signals.tcp is not None  # the robot has a tool
        rows = core.rows[ids]
        tcp = core.signals.tcp[ids] - core.tcp_offset[ids]
        arm = tcp - self._centre[ids]
        flat = arm - (arm * self._normal[ids]).sum(axis=1, keepdims=True) * self._normal[ids]
        distance = np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-12)
        radius = rows[:, [at.radius]]
        along = rows[:, at.tangent]
        behind = ((tcp - rows[:, at.tcp]) * along).sum(axis=1, keepdims=True)
        nearest = np.where(
            radius > 0,
            self._centre[ids] + flat * radius / distance,
            rows[:, at.tcp] + behind * along + 0.5 * behind**2 * rows[:, at.bend],
        )
        deviation = np.where(radius > 0, flat * (1 - radius / distance), tcp - nearest)
        return np.concatenate([nearest, deviation], axis=1)

    def magnify(self, i: int) -> float:
        """See base class."""
        return self._paths[i].magnify if self.options.magnify is None else self.options.magnify

    def close_up(self, i: int, model: mujoco.MjModel, trail: Array) -> Camera:
        """See base class."""
        return self._paths[i].camera(trail[-1, :3])

    def marks(self, i: int, model: mujoco.MjModel, trail: Array) -> list[Mark]:
        """See base class."""
        path = self._paths[i]
        toward = 0.02 * path.radius * path.camera(trail[-1, :3]).backward  # what comes later is drawn above
        drawn = magnified(trail[:, :3], trail[:, 3:], self.magnify(i)) + 3 * toward
        now, error = trail[-1, :3] + 3 * toward, drawn[-1]
        past, present = path.seen(len(trail))
        step = 0.01 * path.radius
        return [
            *(Curve(points=spaced(drawn[piece], step), colour=PALE_TRAIL, width=2) for piece in past),
            *(
                Curve(points=spaced(path.points[piece] + toward, step), colour=PALE_REFERENCE, width=1.5)
                for piece in path.rounds
            ),
            Curve(points=spaced(path.points[path.ahead(len(trail))] + 2 * toward, step), colour=REFERENCE, width=3),
            Curve(points=spaced(drawn[present], step), colour=TRAIL, width=3.5),
            Curve(points=np.stack([now, error]), colour=TRAIL, width=1.5),
            Ball(centre=now, radius=0.028 * path.radius, colour=REFERENCE),
            Ball(centre=error, radius=0.036 * path.radius, colour=TRAIL),
        ]

    def panels(self, i: int, model: mujoco.MjModel, trail: Array, split: float) -> list[Panel]:
        """See base class."""
        path = self._paths[i]
        camera = self.close_up(i, model, trail)
        sheet = GridSheet(camera=camera)
        error = 1e3 * float(np.linalg.norm(trail[-1, 3:]))
        loupe = Ball(centre=trail[-1, :3], radius=0.03, colour=(*TRAIL[:3], 0.7))
        bottom = mujoco.mjtGridPos.mjGRID_BOTTOMLEFT
        speed = 1e3 * path.speed[len(trail) - 1]
        values = f"{self.core.time[i]:.2f} s\n{speed:.0f} mm/s\n{error:.3f} mm"
        return [
            Panel(
                left=0,
                right=split,
                camera=self.whole_robot(i, model),
                marks=[loupe],
                captions=[
                    Caption(text=self.caption(i)),
                    Caption(text="time\nspeed\npath error", values=values, corner=bottom),
                ],
            ),
            self.sheet_panel(
                i,
                model,
                trail,
                split,
                sheet,
                [
                    Caption(text=f"blue: path\nred: TCP, error x {self.magnify(i):g}"),
                    Caption(text=f"grid {sheet.step * 1e3:g} mm", corner=bottom),
                ],
            ),
        ]
