"""Off-screen pictures by MuJoCo's own renderer: a robot seen by cameras, and plots, side by side."""

import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from ffgym.core.types import Array
from ffgym.envs.rendering.gl import open_context

FIELD_OF_VIEW = 30.0
"""Full vertical angle of the cameras [deg]."""
SHADOW_PIXELS = 2048
"""Side of the shadows' texture; software OpenGL spends most of its time on it."""
MAX_GEOMS = 6000
"""Room for the geoms of a scene."""
MAX_POINTS = 200
"""Largest number of points of a line; MuJoCo draws shorter pieces with gaps."""
RED = (0.85, 0.08, 0.15)
"""Colour of the robot's motion; blue is its reference."""
BLUE = (0.10, 0.25, 0.55)


@dataclass(frozen=True, kw_only=True)
class Panel:
    """A part of a picture: the robot as a camera sees it, or a plot."""

    place: tuple[float, float, float, float]
    """Left, bottom, width and height, as shares of the picture's."""
    content: mujoco.MjvCamera | mujoco.MjvFigure
    to_scale: bool = False
    """True for a plot of a square about 0 with one scale on both axes."""
    ball: Array | None = None
    """Point [m] (3,) that a ball marks in the scene."""
    captions: Sequence[tuple[mujoco.mjtGridPos, str, str]] = ()
    """Texts in corners: corner, text, and a second column."""


class Canvas:
    """Canvas that draws one model with one OpenGL context, which lives as long as this."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        self._model, self._width, self._height = model, width, height
        model.vis.quality.shadowsize = SHADOW_PIXELS
        model.vis.global_.fovy = FIELD_OF_VIEW
        model.vis.global_.offwidth, model.vis.global_.offheight = width, height
        font = mujoco.mjtFontScale.mjFONTSCALE_100 if height < 800 else mujoco.mjtFontScale.mjFONTSCALE_150
        self._gl, self._mjr = open_context(model, width, height, font)
        self._scene = mujoco.MjvScene(model, maxgeom=MAX_GEOMS)
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:], self._option.sitegroup[:] = True, False
        self.close = weakref.finalize(self, _free, self._gl, self._mjr)

    def picture(self, data: mujoco.MjData, panels: Sequence[Panel]) -> NDArray[np.uint8]:
        """Draw the panels to a picture (height, width, 3)."""
        pixels = np.empty((self._height, self._width, 3), dtype=np.uint8)
        with self._gl.as_current():
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._mjr)
            for panel in panels:
                self._draw(data, panel)
            mujoco.mjr_readPixels(pixels, None, mujoco.MjrRect(0, 0, self._width, self._height), self._mjr)
        return pixels[::-1].copy()

    def _draw(self, data: mujoco.MjData, panel: Panel) -> None:
        place, content = rectangle(panel.place, self._width, self._height), panel.content
        if isinstance(content, mujoco.MjvFigure):
            mujoco.mjr_figure(place, content, self._mjr)
            if panel.to_scale:  # how large the axes are is known once they are drawn
                content.range[0] *= max(np.ptp(content.xaxispixel), 1) / max(np.ptp(content.yaxispixel), 1)
                mujoco.mjr_figure(place, content, self._mjr)
        else:
            every = mujoco.mjtCatBit.mjCAT_ALL.value
            mujoco.mjv_updateScene(self._model, data, self._option, None, content, every, self._scene)
            self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
            if panel.ball is not None:
                add_ball(self._scene, panel.ball)
            mujoco.mjr_render(place, self._scene, self._mjr)
        for corner, text, values in panel.captions:
            mujoco.mjr_overlay(mujoco.mjtFont.mjFONT_NORMAL, corner, place, text, values, self._mjr)


def rectangle(place: tuple[float, float, float, float], width: int, height: int) -> mujoco.MjrRect:
    """Return the pixels of a `Panel.place` in a picture; neighbours meet without a gap."""
    left, bottom = round(place[0] * width), round(place[1] * height)
    right, top = round((place[0] + place[2]) * width), round((place[1] + place[3]) * height)
    return mujoco.MjrRect(left, bottom, right - left, top - bottom)


def add_ball(scene: mujoco.MjvScene, centre: Array) -> None:
    """Append a red ball of 3 cm to a scene, where there is room."""
    if scene.ngeom < scene.maxgeom:
        sphere, size = mujoco.mjtGeom.mjGEOM_SPHERE, np.full(3, 0.03)
        mujoco.mjv_initGeom(scene.geoms[scene.ngeom], sphere, size, centre, np.eye(3).ravel(), np.array([*RED, 0.7]))
        scene.ngeom += 1


def camera_on(model: mujoco.MjModel, data: mujoco.MjData, azimuth: float, elevation: float) -> mujoco.MjvCamera:
    """Place a camera that shows all of a robot in a panel about as wide as high, from angles [deg] as in MuJoCo."""
    parts = np.flatnonzero(model.geom_bodyid > 0)
    points, sizes = data.geom_xpos[parts], model.geom_rbound[parts, None]
    if not len(parts):  # a robot without looks
        points, sizes = data.xpos[1:], np.full((model.nbody - 1, 1), 0.1)
    low, high = (points - sizes).min(axis=0), (points + sizes).max(axis=0)
    camera = mujoco.MjvCamera()
    camera.lookat[:] = (low + high) / 2
    camera.distance = np.linalg.norm(high - low) / 2 / np.sin(np.deg2rad(FIELD_OF_VIEW / 2))
    camera.azimuth, camera.elevation = azimuth, elevation
    return camera


def plot(
    lines: Sequence[tuple[Array, tuple[float, float, float]]],
    span: Array,
    *,
    title: str,
    xlabel: str,
    ticks: bool = True,
) -> mujoco.MjvFigure:
    """Plot lines by MuJoCo, dark on white.

    Args:
        lines: points (T, 2) and colour of each line, at most 100; the first is drawn above the rest.
        span: lowest and highest value of both axes, shape (2, 2); MuJoCo rounds those of the second one outwards.
        title: text above the plot.
        xlabel: text below it.
        ticks: True for numbers on both axes.
    """
    figure = mujoco.MjvFigure()
    figure.title, figure.xlabel, figure.xformat, figure.yformat = title, xlabel, "%.3g", "%.4g"
    figure.figurergba[:], figure.panergba[:], figure.gridrgb[:], figure.textrgb[:] = 1.0, 1.0, 0.85, 0.1
    figure.flg_extend, figure.flg_legend, figure.flg_ticklabel[:], figure.gridsize[:] = 0, 0, ticks, (5, 5)
    figure.range[:] = span
    for k, (points, colour) in enumerate(lines):
        shown = np.vstack([points[:: 1 + len(points) // MAX_POINTS], points[-1:]])
        figure.linedata[k, : shown.size], figure.linepnt[k], figure.linergb[k] = shown.ravel(), len(shown), colour
    return figure


def _free(gl: Any, mjr: mujoco.MjrContext) -> None:
    """Free the memory of the driver, while its context is there."""
    with gl.as_current():
        mjr.free()
    gl.free()
