"""Pictures of an engine's episodes."""

from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError
from ffgym.core.types import IntArray
from ffgym.envs.rendering.axis_view import AxisView
from ffgym.envs.rendering.canvas import Canvas
from ffgym.envs.rendering.tool_path import Trails
from ffgym.envs.rendering.tool_view import ToolView
from ffgym.envs.rendering.view import View
from ffgym.envs.rendering.viewer import Sight, Window
from ffgym.robot import ModelOptions

if TYPE_CHECKING:
    from ffgym.envs.core import TrackingCore

SPLIT = 0.5
"""Share of the picture that the whole robot has."""


class EpisodeRenderer:
    """Draws the robots of an engine, which it follows at every control step; it changes nothing in it.

    Args:
        core: the engine; its settings say how to draw.
        render_mode: 'rgb_array' or 'human'.

    Raises:
        FFGymError: if this machine has no OpenGL, or no screen in mode 'human'.
    """

    def __init__(self, core: "TrackingCore", render_mode: str) -> None:
        self._core, self._options = core, core.settings.rendering
        self._model = core.plant.machines[0].spec(ModelOptions(looks=True)).compile()  # with the joints of its effects
        self._data = mujoco.MjData(self._model)
        self._view: View = (ToolView if core.columns.has_tcp else AxisView)(core, self._options)
        self._trails = Trails(core.n, self._view.trail_width)
        self._canvas, self._window = None, None
        if render_mode == "human":
            self._window = Window(self._model, self._data)
        else:
            self._canvas = Canvas(self._model, self._options.width, self._options.height)
        core.observers.append(self)

    def begin(self, ids: IntArray) -> None:
        """Sub-environments `ids` begin an episode: forget their trails."""
        self._trails.begin(ids)
        for i in ids.tolist():
            motion = self._core.motions[i]
            assert motion is not None  # the engine has just assigned it
            self._view.begin(i, motion)
        self.follow(ids)

    def follow(self, ids: IntArray) -> None:
        """Add the present state of sub-environments `ids` to their trails."""
        self._trails.add(ids, self._view.sample(ids))

    def frame(self, index: int) -> NDArray[np.uint8]:
        """Picture of a sub-environment, shape (height, width, 3)."""
        trail = self._trails.of(index)
        if self._canvas is None or not len(trail):
            raise FFGymError("There is nothing to render before the first reset.")
        self._pose(index)
        return self._canvas.picture(self._data, self._view.panels(index, self._model, trail, SPLIT))

    def show(self) -> None:
        """Show sub-environment 0 in MuJoCo's viewer, not faster than real time."""
        if self._window is not None:
            self._window.show(float(self._core.time[0]), self._sight)

    def close(self) -> None:
        """Free the OpenGL context, or close the window."""
        if self in self._core.observers:
            self._core.observers.remove(self)
        for place in (self._canvas, self._window):
            if place is not None:
                place.close()
        self._canvas, self._window = None, None

    def _sight(self) -> Sight:
        """What the viewer shows now."""
        self._pose(0)
        trail, view = self._trails.of(0), self._view
        text = f"{view.caption(0)}\nerror x {view.magnify(0):g}\n{self._core.time[0]:.2f} s"
        return Sight(view.whole_robot(0, self._model), view.board(0, self._model, trail), text)

    def _pose(self, index: int) -> None:
        """Put the drawn robot where a simulated one is."""
        self._data.qpos[:] = self._core.plant.batch.qpos[index]
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)
