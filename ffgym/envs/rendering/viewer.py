"""MuJoCo's interactive viewer, which runs beside the simulation and draws its state."""

import atexit
import os
import platform
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.envs.rendering.canvas import FIELD_OF_VIEW, Panel, add_ball, rectangle
from ffgym.envs.rendering.gl import has_display, start_glfw

FRAME = 1 / 25
"""Time between pictures [s]."""
_WAY_OUT = "use render_mode='rgb_array', which needs no screen, or set DISPLAY (ssh -X, or xvfb-run)"


class ViewerWindow:
    """Window of the viewer; it opens at the first picture, and stays closed once it is closed by hand."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        check_screen()
        model.vis.global_.fovy = FIELD_OF_VIEW
        self._model, self._data = model, data
        self._viewer: Any = None
        self._threads: set[threading.Thread] = set()
        self._shown = self._time = -1.0

    def show(self, now: float, look: Callable[[], Sequence[Panel]]) -> None:
        """Show the state at time `now` [s] of an episode, if it is time for a picture; wait if it comes too early.

        Args:
            now: time in the episode [s].
            look: function that puts the model's data into the present state and returns panels: the robot, then plots.
        """
        begins = now < self._time or self._viewer is None
        if not begins and now - self._time < FRAME:
            return
        if self._viewer is None:
            self._open(look()[0].content)
        if not self._viewer.is_running():
            return
        if not begins:
            time.sleep(max(0.0, self._shown + now - self._time - time.monotonic()))
        # robot, captions and plots
        self._shown, self._time = time.monotonic(), now
        with self._viewer.lock():
            robot, *plots = look()
            self._viewer.user_scn.ngeom = 0
            if robot.ball is not None:
                add_ball(self._viewer.user_scn, robot.ball)
        self._viewer.set_texts([(mujoco.mjtFontScale.mjFONTSCALE_150, *caption) for caption in robot.captions])
        if (window := self._viewer.viewport) is not None:
            places = [rectangle(panel.place, window.width, window.height) for panel in plots]
            for place, panel in zip(places, plots, strict=True):
                if panel.to_scale:
                    panel.content.range[0] *= (place.width - 20) / (place.height - 75)  # without title and margins
            self._viewer.set_figures([(place, panel.content) for place, panel in zip(places, plots, strict=True)])
        self._viewer.sync()

    def close(self) -> None:
        """Close the window, and wait until its threads have let go of it; otherwise Python crashes at exit."""
        if self._viewer is not None:
            self._viewer.close()
            for thread in self._threads:
                thread.join(timeout=5.0)
            atexit.unregister(self.close)

    def _open(self, camera: Any) -> None:
        import mujoco.viewer

        others = set(threading.enumerate())
        try:
            viewer = mujoco.viewer.launch_passive(self._model, self._data, show_left_ui=False, show_right_ui=False)
        except RuntimeError as error:  # macOS
            raise FFGymError(f"render_mode='human': {error}; start the script with mjpython, or {_WAY_OUT}.") from error
        self._viewer, self._threads = viewer, set(threading.enumerate()) - others
        atexit.register(self.close)
        right = np.array([-np.sin(np.deg2rad(camera.azimuth)), np.cos(np.deg2rad(camera.azimuth)), 0.0])
        with viewer.lock():  # plots cover the right half, so that the camera looks past the robot
            viewer.cam.lookat[:] = camera.lookat - 0.25 * camera.distance * right
            viewer.cam.distance, viewer.cam.azimuth = 1.2 * camera.distance, camera.azimuth
            viewer.cam.elevation = camera.elevation


def check_screen() -> None:
    """Check that a window can be opened."""
    if platform.system() == "Linux" and not has_display(os.environ):
        raise FFGymError(f"render_mode='human' needs a screen, but DISPLAY is not set; {_WAY_OUT}.")
    try:
        start_glfw()
    except ImportError as error:
        raise FFGymError(f"render_mode='human' cannot open a window: {error}; {_WAY_OUT}.") from error
