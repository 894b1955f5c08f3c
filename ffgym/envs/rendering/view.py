"""What there is to see of a kind of robot."""

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

import mujoco
import numpy as np

from ffgym.core.types import Array, IntArray
from ffgym.envs.motion import Motion
from ffgym.envs.rendering.camera import Camera, Rendering
from ffgym.envs.rendering.canvas import Caption, Panel
from ffgym.envs.rendering.paper import Mark, Sheet

if TYPE_CHECKING:
    from ffgym.envs.core import TrackingCore


BOARD = 1.0
"""Size of the board in the viewer, in sizes of the robot."""


class View(ABC):
    """Turns an engine's state into panels."""

    trail_width: ClassVar[int]
    azimuth: ClassVar[float] = -60.0
    """Of the camera that shows all of the robot [deg]."""
    elevation: ClassVar[float] = 18.0
    margin: ClassVar[float] = 0.9
    """How much of the ball around the robot's bounding box is in the picture."""

    def __init__(self, core: "TrackingCore", options: Rendering) -> None:
        self.core, self.options = core, options
        self._start: dict[int, Array] = {}
        self._cameras: dict[int, Camera] = {}

    def begin(self, i: int, motion: Motion) -> None:
        """Sub-environment `i` begins an episode."""
        self._start[i] = self.core.plant.batch.qpos[i].copy()
        self._cameras.pop(i, None)

    def whole_robot(self, i: int, model: mujoco.MjModel) -> Camera:
        """Camera that shows all of the robot, standing still during an episode."""
        if i not in self._cameras:
            data = mujoco.MjData(model)
            data.qpos[:] = self._start[i]
            mujoco.mj_kinematics(model, data)
            low, high = _bounds(model, data)
            self._cameras[i] = Camera(
                centre=(low + high) / 2,
                radius=self.margin * float(np.linalg.norm(high - low)) / 2,
                azimuth=self.azimuth,
                elevation=self.elevation,
            )
        return self._cameras[i]

    def board(self, i: int, model: mujoco.MjModel, trail: Array) -> list[Mark]:
        """The close-up, enlarged and upright in the air on the right of the robot."""
        whole, close = self.whole_robot(i, model), self.close_up(i, model, trail)
        turn = BOARD * whole.radius / close.radius * whole.axes @ close.axes.T
        target = whole.centre + whole.radius * (1 + BOARD) * whole.right
        return [mark.moved(turn, close.centre, target) for mark in self.marks(i, model, trail)]

    def caption(self, i: int) -> str:
        """Title, robot and task."""
        motion = self.core.motions[i]
        assert motion is not None  # an episode has begun
        lines = [self.options.title] if self.options.title else []
        return "\n".join([*lines, self.core.robot.name, motion.name])

    @abstractmethod
    def sample(self, ids: IntArray) -> Array:
        """Rows for the trails of sub-environments `ids` now, shape (B', W)."""

    @abstractmethod
    def magnify(self, i: int) -> float:
        """Factor on the error that is drawn."""

    @abstractmethod
    def close_up(self, i: int, model: mujoco.MjModel, trail: Array) -> Camera:
        """Camera of the close-up."""

    @abstractmethod
    def marks(self, i: int, model: mujoco.MjModel, trail: Array) -> list[Mark]:
        """Path, trail and present error in the world, for a trail (T, W)."""

    def sheet_panel(
        self, i: int, model: mujoco.MjModel, trail: Array, split: float, sheet: Sheet, captions: list[Caption]
    ) -> Panel:
        """What is right of `split`: path, trail and error on a sheet, without the robot."""
        marks = [*sheet.marks(), *self.marks(i, model, trail)]
        return Panel(left=split, right=1, camera=sheet.camera, robot=False, marks=marks, captions=captions)

    @abstractmethod
    def panels(self, i: int, model: mujoco.MjModel, trail: Array, split: float) -> list[Panel]:
        """The picture: whole robot left of `split` of its width, close-up on the right."""


def _bounds(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[Array, Array]:
    """Lowest and highest coordinates of the robot's parts [m]."""
    parts = model.geom_bodyid > 0
    centre, half = model.geom_aabb[parts, :3], model.geom_aabb[parts, 3:]
    rotation = data.geom_xmat[parts].reshape(-1, 3, 3)
    if not parts.any():  # a robot without looks
        return data.xpos[1:].min(axis=0) - 0.1, data.xpos[1:].max(axis=0) + 0.1
    middle = data.geom_xpos[parts] + np.einsum("gij,gj->gi", rotation, centre)
    reach = np.einsum("gij,gj->gi", np.abs(rotation), half)
    return (middle - reach).min(axis=0), (middle + reach).max(axis=0)
