"""Where a picture is taken from, and what it can be told."""

from dataclasses import dataclass

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.core.types import Array

FIELD_OF_VIEW = np.deg2rad(30.0)
"""Full angle of the perspective camera along the shorter side."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Camera:
    """Looks at a ball, so that all of it is in the picture, whatever the shape of the panel."""

    centre: Array
    """[m], shape (3,)."""
    radius: float
    """[m]."""
    azimuth: float
    """Direction from the ball's centre to the camera [deg], from world x towards y."""
    elevation: float
    """Of the camera above the horizon [deg]."""
    orthographic: bool = False

    @classmethod
    def along(cls, normal: Array, centre: Array, radius: float) -> "Camera":
        """Orthographic camera that looks against a unit normal (3,); world x points right if the normal is up."""
        azimuth = -90.0 if abs(normal[2]) > 0.999 else float(np.rad2deg(np.arctan2(normal[1], normal[0])))
        elevation = float(np.rad2deg(np.arcsin(np.clip(normal[2], -1, 1))))
        return cls(centre=centre, radius=radius, azimuth=azimuth, elevation=elevation, orthographic=True)

    @property
    def backward(self) -> Array:
        """Unit vector from the centre to the camera."""
        a, e = np.deg2rad(self.azimuth), np.deg2rad(self.elevation)
        return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])

    @property
    def up(self) -> Array:
        """Unit vector that points up in the picture."""
        a, e = np.deg2rad(self.azimuth), np.deg2rad(self.elevation)
        return np.array([-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)])

    @property
    def right(self) -> Array:
        """Unit vector that points right in the picture."""
        right: Array = np.cross(self.up, self.backward)
        return right

    @property
    def axes(self) -> Array:
        """Right, up and backward as columns, shape (3, 3)."""
        return np.stack([self.right, self.up, self.backward], axis=1)

    @property
    def distance(self) -> float:
        """From the camera to the centre [m]."""
        return self.radius * (4.0 if self.orthographic else float(1 / np.sin(FIELD_OF_VIEW / 2)))

    def aim(self, scene: mujoco.MjvScene, aspect: float) -> None:
        """Set the scene's cameras for a panel of width / height = `aspect`."""
        distance = self.distance
        near, far = 0.05 * distance, 10 * distance
        half = self.radius if self.orthographic else near * np.tan(FIELD_OF_VIEW / 2)
        half = half / min(aspect, 1.0)  # vertical
        for eye in scene.camera:
            eye.pos = self.centre + distance * self.backward
            eye.forward, eye.up = -self.backward, self.up
            eye.orthographic = int(self.orthographic)
            eye.frustum_center, eye.frustum_width = 0.0, half * aspect
            eye.frustum_bottom, eye.frustum_top = -half, half
            eye.frustum_near, eye.frustum_far = near, far


LARGEST = 4096
"""Largest width and height [pixel]; software OpenGL draws no larger ones."""


@dataclass(frozen=True, kw_only=True)
class Rendering:
    """How episodes are drawn."""

    magnify: float | None = None
    """Factor on the error that is drawn; None takes a round one that suits the motion, the same for every agent."""
    width: int = 960
    """Of a picture [pixel]."""
    height: int = 540
    """Of a picture [pixel]."""
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
        FFGymError: if it is not.
    """
    if mode is None:
        return None
    check_choice("render_mode", mode, ("human", "rgb_array"))
    if mode == "human" and num_envs != 1:
        raise FFGymError(
            f"render_mode='human' shows one robot, num_envs = {num_envs}; use gym.make, or render_mode='rgb_array'."
        )
    return mode
