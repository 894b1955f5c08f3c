"""A robot's looks in a picture, where OpenGL works."""

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.envs.rendering.camera import Camera
from ffgym.envs.rendering.canvas import Canvas, Panel
from ffgym.report.figure import new_figure
from ffgym.robot import ModelOptions, compile_model
from ffgym.studies.robot_check import RobotCheck

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SIZE = (960, 480)
"""Of the picture [pixel]."""
_BARE = ModelOptions(flexible=False, friction=False, servo=False)
"""Links and looks: all that a picture needs."""


def rendered_robot(check: RobotCheck) -> "Figure | None":
    """The robot at rest from two sides; None if it has no looks, or OpenGL does not work here."""
    if not check.draft.geoms or check.rest is None or check.rest.q is None:
        return None
    model = compile_model(check.draft.description_for("kinematics"), _BARE)
    data = mujoco.MjData(model)
    data.qpos[:] = check.rest.q
    mujoco.mj_forward(model, data)
    try:
        canvas = Canvas(model, *_SIZE)
    except FFGymError:  # no OpenGL; the skeleton needs none
        return None
    centre, radius = _ball(model, data)
    views = [Camera(centre=centre, radius=radius, azimuth=azimuth, elevation=15.0) for azimuth in (-50.0, 40.0)]
    panels = [Panel(left=k / 2, right=(k + 1) / 2, camera=view) for k, view in enumerate(views)]
    picture = canvas.picture(data, panels)
    canvas.close()
    figure = new_figure(_SIZE[0] / 110, _SIZE[1] / 110)
    axes = figure.subplots()
    axes.imshow(picture)
    axes.set_axis_off()
    return figure


def _ball(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[np.ndarray, float]:
    """Centre and radius [m] of a ball around all geoms of the robot."""
    own = np.flatnonzero(model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE)
    points, sizes = data.geom_xpos[own], model.geom_rbound[own, None]
    low, high = (points - sizes).min(axis=0), (points + sizes).max(axis=0)
    return (low + high) / 2, float(np.linalg.norm(high - low) / 2)
