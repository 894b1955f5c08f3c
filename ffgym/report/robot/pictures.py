"""Pictures of a robot: its skeleton (joints, axes, masses, inertia ellipsoids, reach), and its looks."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.envs.rendering.canvas import Canvas, Panel, camera_on
from ffgym.report.figure import ReportFigure, new_figure, panels, require_matplotlib
from ffgym.report.page import words_of
from ffgym.robot import ModelOptions, compile_model
from ffgym.studies.robot_check import POSES, RobotCheck, Skeleton, skeleton

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BONE, _AXIS, _MASS, _TIP, _REACH = "#1c2430", "#D55E00", "#0072B2", "#009E73", "#c9d3de"
_AXIS_LENGTH = 0.12
"""Half length of a drawn axis, as a share of the picture."""
_TOGETHER = 0.06
"""Distance of joints in a view, as a share of the picture, below which one label serves them."""
_ROOM = 1.15
"""Side of the picture, in lengths of the longest side of all that is drawn."""
_BUBBLE = 900.0
"""Area of the heaviest body's bubble [points^2]."""
_LIGHTEST = 0.02
"""Share of the heaviest body's bubble below which a bubble would not be seen."""
_SIZE = (960, 480)
"""Size of the picture of the looks [pixel]."""
_BARE = ModelOptions(flexible=False, friction=False, servo=False)
"""Options of the model of a picture: links and looks alone."""


@dataclass(frozen=True, kw_only=True)
class _View:
    """A projection on two axes of the world."""

    title: str
    right: int
    up: int


_VIEWS = (
    _View(title="from the side", right=0, up=2),
    _View(title="from the front", right=1, up=2),
    _View(title="from above", right=0, up=1),
)


def robot_figures(check: RobotCheck) -> list[ReportFigure]:
    """Draw the skeleton, if the kinematics are known, and the looks, if they can be drawn."""
    figures = [] if check.reach is None else [_skeleton(check)]
    looks = _looks(check)
    if looks is not None:
        caption = "The description's own shapes; they weigh nothing."
        figures.append(ReportFigure("looks", "Looks", caption, looks))
    return figures


def _skeleton(check: RobotCheck) -> ReportFigure:
    """Draw three views of the robot at rest; needs kinematics, and shows masses if they are known."""
    assert check.rest is not None
    assert check.rest.q is not None
    assert check.reach is not None
    with_masses = check.draft.can("kinematics", "links.mass", "links.com", "links.inertia")
    bones = skeleton(check.draft.description_for("kinematics"), check.rest.q)
    with panels(1, len(_VIEWS), size=(11.0, 4.0), legend=False) as (figure, grid):
        for axes, view in zip(grid[0], _VIEWS, strict=True):
            _draw(axes, view, bones, check.reach.points, check.draft.joints, with_masses=with_masses)
    words = words_of("robot")
    caption = words["skeleton"].format(pose=check.rest.name, poses=POSES)
    if with_masses:
        caption += f" {words['masses']}"
    return ReportFigure(
        name="skeleton",
        title="Joints, masses, reach",
        caption=caption,
        figure=figure,
    )


def _draw(
    axes: "Axes", view: _View, bones: Skeleton, reach: Array, joints: Sequence[str], *, with_masses: bool
) -> None:
    right, up = view.right, view.up
    axes.scatter(reach[:, right], reach[:, up], s=1.5, color=_REACH, linewidths=0, rasterized=True, zorder=1)
    chain = np.vstack([np.zeros(3), bones.joints, bones.tip])
    axes.plot(chain[:, right], chain[:, up], color=_BONE, linewidth=2.2, zorder=4)
    axes.plot(bones.joints[:, right], bones.joints[:, up], "o", color=_BONE, markersize=4, zorder=5)
    axes.plot(bones.tip[right], bones.tip[up], "o", color=_TIP, markersize=6, zorder=6)
    around = bones.half_axes.max(axis=1, keepdims=True)
    drawn = np.vstack([reach, chain, *([bones.com - around, bones.com + around] if with_masses else [])])
    size = float(np.ptp(drawn, axis=0).max()) or 1.0  # longest side of the box around all [m]
    for point, axis in zip(bones.joints, bones.axes, strict=True):
        ends = point + np.outer([-1, 1], axis * size * _AXIS_LENGTH / 2)
        axes.plot(ends[:, right], ends[:, up], color=_AXIS, linewidth=1.4, zorder=5)
    _label(axes, view, bones.joints, joints, size)
    if with_masses:
        _masses(axes, view, bones)
    # one scale for all views, with everything in the picture
    middle, half = (drawn.min(axis=0) + drawn.max(axis=0)) / 2, _ROOM * size / 2
    axes.set(
        title=view.title,
        xlabel=f"{'xyz'[right]} [m]",
        ylabel=f"{'xyz'[up]} [m]",
        xlim=(middle[right] - half, middle[right] + half),
        ylim=(middle[up] - half, middle[up] + half),
        aspect="equal",
    )
    axes.set_axisbelow(True)


def _label(axes: "Axes", view: _View, points: Array, names: Sequence[str], size: float) -> None:
    """Name joints beside their points; those that coincide in a view share one label."""
    shown: list[tuple[Array, list[str]]] = []
    for point, name in zip(points[:, [view.right, view.up]], names, strict=True):
        near = [entry for entry in shown if np.linalg.norm(entry[0] - point) < _TOGETHER * size]
        if near:
            near[0][1].append(name)
        else:
            shown.append((point, [name]))
    for point, together in shown:
        axes.annotate(
            ", ".join(together), (point[0], point[1]), (5, 4), textcoords="offset points", fontsize=7, zorder=7
        )


def _masses(axes: "Axes", view: _View, bones: Skeleton) -> None:
    """Draw masses as bubbles, and outlines of the ellipsoids with the inertia of the links."""
    seen = [view.right, view.up]
    areas = _BUBBLE * np.maximum(bones.mass / bones.mass.max(), _LIGHTEST)
    x, y = bones.com[:, seen].T
    axes.scatter(x, y, s=areas, color=_MASS, alpha=0.35, linewidths=0, zorder=3)
    ellipse: Any = require_matplotlib().patches.Ellipse
    for com, half_axes, turn in zip(bones.com, bones.half_axes, bones.principal_axes, strict=True):
        spread = (turn * half_axes**2) @ turn.T
        squares, directions = np.linalg.eigh(spread[np.ix_(seen, seen)])
        width, height = 2 * np.sqrt(np.maximum(squares[::-1], 0.0))
        angle = float(np.degrees(np.arctan2(directions[1, 1], directions[0, 1])))
        shape = ellipse(com[seen], float(width), float(height), angle=angle, fill=False, color=_MASS, lw=1.0)
        shape.set_zorder(3)
        axes.add_patch(shape)


def _looks(check: RobotCheck) -> "Figure | None":
    """Draw the robot at rest from two sides; None if it has no looks, or OpenGL does not work here."""
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
    views = [camera_on(model, data, azimuth, elevation=-15.0) for azimuth in (130.0, 220.0)]
    halves = [Panel(place=(k / 2, 0.0, 0.5, 1.0), content=view) for k, view in enumerate(views)]
    picture = canvas.picture(data, halves)
    canvas.close()
    figure = new_figure(_SIZE[0] / 110, _SIZE[1] / 110)
    axes = figure.subplots()
    axes.imshow(picture)
    axes.set_axis_off()
    return figure
