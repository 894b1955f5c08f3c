"""MuJoCo's interactive viewer, which runs beside the simulation and takes what is drawn from it."""

import atexit
import os
import platform
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.envs.rendering.camera import FIELD_OF_VIEW, Camera
from ffgym.envs.rendering.gl import has_display, start_glfw
from ffgym.envs.rendering.paper import Mark

FRAME = 1 / 25
"""Time between pictures [s]."""
_WAY_OUT = "use render_mode='rgb_array', which needs no screen, or set DISPLAY (ssh -X, or xvfb-run)"


class Sight(NamedTuple):
    """What to show."""

    camera: Camera
    """Shows all of the robot."""
    marks: Sequence[Mark]
    text: str


class Window:
    """The viewer; it opens when something is to be shown, and shows no more once it is closed by hand."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        check_screen()
        model.vis.global_.fovy = np.rad2deg(FIELD_OF_VIEW)
        self._model, self._data = model, data
        self._viewer: Any = None
        self._threads: set[threading.Thread] = set()
        self._shown = self._time = -1.0

    def show(self, now: float, look: Callable[[], Sight]) -> None:
        """Show the state at time `now` [s] of an episode, if it is time for a picture; wait if it comes too early.

        Args:
            now: time in the episode [s].
            look: puts the model's data into the present state and returns what else is to be seen.
        """
        begins = now < self._time or self._viewer is None
        if not begins and now - self._time < FRAME:
            return
        if self._viewer is None:
            self._open(look())
        if not self._viewer.is_running():
            return
        if not begins:
            time.sleep(max(0.0, self._shown + now - self._time - time.monotonic()))
        self._shown, self._time = time.monotonic(), now
        with self._viewer.lock():
            sight = look()
            scene = self._viewer.user_scn
            scene.ngeom = 0
            for mark in sight.marks:
                mark.add_to(scene)
        corner = mujoco.mjtGridPos.mjGRID_TOPLEFT
        self._viewer.set_texts((mujoco.mjtFontScale.mjFONTSCALE_150, corner, sight.text, ""))
        self._viewer.sync()

    def close(self) -> None:
        """Close the window, and wait until its threads have let go of it; otherwise Python crashes at exit."""
        if self._viewer is not None:
            self._viewer.close()
            for thread in self._threads:
                thread.join(timeout=5.0)
            atexit.unregister(self.close)

    def _open(self, sight: Sight) -> None:
        others = set(threading.enumerate())
        self._viewer = _launch(self._model, self._data)
        self._threads = set(threading.enumerate()) - others
        atexit.register(self.close)
        camera = sight.camera
        with self._viewer.lock():
            self._viewer.cam.lookat[:] = camera.centre + 0.7 * camera.radius * camera.right  # the board is on the right
            self._viewer.cam.distance = 1.5 * camera.distance
            self._viewer.cam.azimuth, self._viewer.cam.elevation = camera.azimuth + 180, -camera.elevation


def check_screen() -> None:
    """Check that a window can be opened.

    Raises:
        FFGymError: if not.
    """
    if platform.system() == "Linux" and not has_display(os.environ):
        raise FFGymError(f"render_mode='human' needs a screen, but DISPLAY is not set; {_WAY_OUT}.")
    try:
        start_glfw()
    except ImportError as error:
        raise FFGymError(f"render_mode='human' cannot open a window: {error}; {_WAY_OUT}.") from error


def _launch(model: mujoco.MjModel, data: mujoco.MjData) -> Any:
    import mujoco.viewer

    try:
        return mujoco.viewer.launch_passive(model, data, show_left_ui=False, show_right_ui=False)
    except RuntimeError as error:  # macOS
        raise FFGymError(f"render_mode='human': {error}; start the script with mjpython, or {_WAY_OUT}.") from error
