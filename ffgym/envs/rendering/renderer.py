"""Pictures of an engine's episodes: the whole robot, its path with the error magnified, the errors of its motors."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.core.types import IntArray
from ffgym.envs.rendering.canvas import Canvas, Panel, camera_on
from ffgym.envs.rendering.track import JointTrack, ToolTrack, Track
from ffgym.envs.rendering.viewer import ViewerWindow
from ffgym.robot import ModelOptions

if TYPE_CHECKING:
    from ffgym.envs.core import TrackingCore

LARGEST = 4096
"""Largest width and height [pixel]; software OpenGL draws no larger ones."""
ROBOT, CLOSE_UP, ERRORS = (0.0, 0.0, 0.5, 1.0), (0.5, 0.35, 0.5, 0.65), (0.5, 0.0, 0.5, 0.35)
"""Places in the picture: left, bottom, width, height."""


@dataclass(frozen=True, kw_only=True)
class Rendering:
    """Size, title and magnification of the pictures of episodes."""

    magnify: float | None = None
    """Factor on the error that is drawn; defaults to a round one that suits the motion, the same for every agent."""
    width: int = 960
    """Width of a picture [pixel]."""
    height: int = 540
    """Height of a picture [pixel]."""
    title: str = ""
    """First line of the text, e.g. the agent's name."""

    def __post_init__(self) -> None:
        if self.magnify is not None:
            check_number("magnify", self.magnify, low=0.0, high=1e6, open_low=True)
        check_whole("width", self.width, unit="pixel", low=64, high=LARGEST)
        check_whole("height", self.height, unit="pixel", low=64, high=LARGEST)


def check_render_mode(mode: str | None, num_envs: int) -> str | None:
    """Return a render mode if it is None or one that can show `num_envs` robots.

    Raises:
        FFGymError: if it is unknown, or cannot show so many.
    """
    if mode is None:
        return None
    check_choice("render_mode", mode, ("human", "rgb_array"))
    if mode == "human" and num_envs != 1:
        raise FFGymError(
            f"render_mode='human' shows one robot, num_envs = {num_envs}; use gym.make, or render_mode='rgb_array'."
        )
    return mode


class EpisodeRenderer:
    """Renderer of an engine's robots, which it follows at every control step without changing them.

    Args:
        core: the engine, with settings of pictures.
        render_mode: 'rgb_array' or 'human'.

    Raises:
        FFGymError: if this machine has no OpenGL, or no screen in mode 'human'.
    """

    def __init__(self, core: "TrackingCore", render_mode: str) -> None:
        self._core, options = core, core.settings.rendering
        self._model = core.plant.machines[0].spec(ModelOptions(looks=True)).compile()  # with the joints of its effects
        self._data = mujoco.MjData(self._model)
        self._tracks: dict[int, Track] = {}
        self._cameras: dict[int, mujoco.MjvCamera] = {}
        self._canvas, self._window = None, None
        if render_mode == "human":
            self._window = ViewerWindow(self._model, self._data)
        else:
            self._canvas = Canvas(self._model, options.width, options.height)
        core.observers.append(self)

    def begin(self, ids: IntArray) -> None:
        """Begin episodes of sub-environments `ids` with empty tracks, and a camera on all of the robot."""
        for i in ids.tolist():
            motion = self._core.motions[i]
            assert motion is not None  # the engine has just assigned it
            self._tracks[i] = (ToolTrack if self._core.columns.has_tcp else JointTrack)(self._core, i, motion)
            self._pose(i)
            self._cameras[i] = camera_on(self._model, self._data, azimuth=120.0, elevation=-18.0)
        self.follow(ids)

    def follow(self, ids: IntArray) -> None:
        """Add the present state of sub-environments `ids` to their tracks."""
        for i in ids.tolist():
            self._tracks[i].add()

    def frame(self, index: int) -> NDArray[np.uint8]:
        """Draw a sub-environment, shape (height, width, 3)."""
        if self._canvas is None or index not in self._tracks:
            raise FFGymError("There is nothing to render before the first reset.")
        self._pose(index)
        return self._canvas.picture(self._data, self._panels(index))

    def show(self) -> None:
        """Show sub-environment 0 in MuJoCo's viewer, not faster than real time."""

        def look() -> list[Panel]:
            self._pose(0)
            return self._panels(0)

        if self._window is not None:
            self._window.show(float(self._core.time[0]), look)

    def close(self) -> None:
        """Free the OpenGL context, or close the window."""
        if self in self._core.observers:
            self._core.observers.remove(self)
        for place in (self._canvas, self._window):
            if place is not None:
                place.close()
        self._canvas, self._window = None, None

    def _panels(self, index: int) -> list[Panel]:
        """Lay out the whole robot on the left, the close-up and the motors' errors on the right."""
        track, top, bottom = (
            self._tracks[index],
            mujoco.mjtGridPos.mjGRID_TOPLEFT,
            mujoco.mjtGridPos.mjGRID_BOTTOMLEFT,
        )
        title = self._core.settings.rendering.title
        heading = "\n".join([*([title] if title else []), self._core.robot.name, track.motion.name])
        captions = [(top, heading, ""), (bottom, *track.values())]
        return [
            Panel(place=ROBOT, content=self._cameras[index], ball=track.ball, captions=captions),
            Panel(place=CLOSE_UP, content=track.close_up(), to_scale=track.ball is not None),
            Panel(place=ERRORS, content=track.motor_errors()),
        ]

    def _pose(self, index: int) -> None:
        """Put the drawn robot into the pose of a simulated one."""
        self._data.qpos[:] = self._core.plant.batch.qpos[index]
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)
