"""Off-screen pictures: panels side by side, each a MuJoCo scene with lines and text of ours."""

import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from ffgym.envs.rendering.camera import Camera
from ffgym.envs.rendering.gl import open_context
from ffgym.envs.rendering.paper import Mark

USUAL_SIZE = (960, 540)
"""At which lines have the width that they say [pixel]."""
SHADOW_PIXELS = 2048
"""Side of the shadows' texture; software OpenGL spends most of its time on it."""
MAX_GEOMS = 6000
"""Of a scene; marks that do not fit are left out, the oldest ones of a list last."""


@dataclass(frozen=True, kw_only=True)
class Caption:
    """Text in a corner of a panel."""

    text: str
    corner: mujoco.mjtGridPos = mujoco.mjtGridPos.mjGRID_TOPLEFT
    values: str = ""
    """A second column."""


@dataclass(frozen=True, kw_only=True)
class Panel:
    """A part of a picture."""

    left: float
    """Of the picture's width."""
    right: float
    camera: Camera
    marks: Sequence[Mark] = ()
    captions: Sequence[Caption] = ()
    robot: bool = True
    """With the robot in its surroundings; False shows marks only."""


class Canvas:
    """Draws one model with one OpenGL context, which lives as long as this."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        self._model, self._width, self._height = model, width, height
        model.vis.quality.shadowsize = SHADOW_PIXELS
        model.vis.global_.offwidth, model.vis.global_.offheight = width, height
        font = mujoco.mjtFontScale.mjFONTSCALE_100 if height < 800 else mujoco.mjtFontScale.mjFONTSCALE_150
        self._gl, self._mjr = open_context(model, width, height, font)
        self._scene = mujoco.MjvScene(model, maxgeom=MAX_GEOMS)
        self._option = mujoco.MjvOption()
        self.close = weakref.finalize(self, _free, self._gl, self._mjr)

    def picture(self, data: mujoco.MjData, panels: Sequence[Panel]) -> NDArray[np.uint8]:
        """Picture of the panels, shape (height, width, 3)."""
        pixels = np.empty((self._height, self._width, 3), dtype=np.uint8)
        with self._gl.as_current():
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._mjr)
            for panel in panels:
                self._draw(data, panel)
            whole = mujoco.MjrRect(0, 0, self._width, self._height)
            mujoco.mjr_readPixels(pixels, None, whole, self._mjr)
        return pixels[::-1].copy()

    def _draw(self, data: mujoco.MjData, panel: Panel) -> None:
        left, right = round(panel.left * self._width), round(panel.right * self._width)
        place = mujoco.MjrRect(left, 0, right - left, self._height)
        self._compose(data, panel)
        panel.camera.aim(self._scene, place.width / place.height)
        mujoco.mjr_render(place, self._scene, self._mjr)
        for caption in panel.captions:
            font = mujoco.mjtFont.mjFONT_NORMAL
            mujoco.mjr_overlay(font, caption.corner, place, caption.text, caption.values, self._mjr)

    def _compose(self, data: mujoco.MjData, panel: Panel) -> None:
        scene, option = self._scene, self._option
        option.geomgroup[:] = panel.robot
        option.sitegroup[:] = False
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(self._model, data, option, None, mujoco.MjvCamera(), everything, scene)
        scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = panel.robot
        scene.flags[mujoco.mjtRndFlag.mjRND_SKYBOX] = panel.robot
        scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
        scale = min(self._width / USUAL_SIZE[0], self._height / USUAL_SIZE[1])
        for mark in panel.marks:
            mark.add_to(scene, scale)


def _free(gl: Any, mjr: mujoco.MjrContext) -> None:
    """Free what the driver holds, while its context is there."""
    with gl.as_current():
        mjr.free()
    gl.free()
