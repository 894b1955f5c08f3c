"""MuJoCo's interactive viewer, which runs beside the simulation and takes what is drawn from it."""

import os
import platform
import time
from collections.abc import Callable, Sequence
from typing import Any

import mujoco

from ffgym.envs.rendering.gl import has_display
from ffgym.envs.rendering.marks import Mark
from ffgym.errors import FFGymError

FRAME = 1 / 25
"""Time between pictures [s]."""
_WAY_OUT = "use render_mode='rgb_array', which needs no screen, or set DISPLAY (ssh -X, or xvfb-run)"


class Window:
    """The viewer; it opens when something is to be shown, and shows no more once it is closed by hand."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        check_screen()
        self._model, self._data = model, data
        self._viewer: Any = None
        self._shown = self._time = -1.0

    def show(
        self, now: float, pose: Callable[[], None], marks: Callable[[], Sequence[Mark]], text: tuple[str, str]
    ) -> None:
        """Show the state at time `now` [s] of an episode, if it is time for a picture; wait if it comes too early."""
        begins = now < self._time or self._viewer is None
        if not begins and now - self._time < FRAME:
            return
        if self._viewer is None:
            pose()
            self._viewer = _launch(self._model, self._data)
        if not self._viewer.is_running():
            return
        if not begins:
            time.sleep(max(0.0, self._shown + now - self._time - time.monotonic()))
        self._shown, self._time = time.monotonic(), now
        with self._viewer.lock():
            pose()
            scene = self._viewer.user_scn
            scene.ngeom = 0
            for mark in marks():
                mark.add_to(scene)
        corner = mujoco.mjtGridPos.mjGRID_BOTTOMLEFT
        self._viewer.set_texts((mujoco.mjtFontScale.mjFONTSCALE_150, corner, *text))
        self._viewer.sync()

    def close(self) -> None:
        """Close the window."""
        if self._viewer is not None:
            self._viewer.close()


def check_screen() -> None:
    """Check that a window can be opened.

    Raises:
        FFGymError: if not.
    """
    if platform.system() == "Linux" and not has_display(os.environ):
        raise FFGymError(f"render_mode='human' needs a screen, but DISPLAY is not set; {_WAY_OUT}.")
    try:
        import glfw
    except ImportError as error:
        raise FFGymError(f"render_mode='human' needs glfw ({error}); pip install glfw, or {_WAY_OUT}.") from error
    import warnings

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        works = glfw.init()
    if not works:
        reason = "; ".join(str(warning.message) for warning in caught) or "GLFW does not start"
        raise FFGymError(f"render_mode='human' cannot open a window: {reason}; {_WAY_OUT}.")


def _launch(model: mujoco.MjModel, data: mujoco.MjData) -> Any:
    import mujoco.viewer

    try:
        return mujoco.viewer.launch_passive(model, data, show_left_ui=False, show_right_ui=False)
    except RuntimeError as error:  # macOS
        raise FFGymError(f"render_mode='human': {error}; start the script with mjpython, or {_WAY_OUT}.") from error
