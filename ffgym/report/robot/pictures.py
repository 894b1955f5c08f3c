"""A robot as a skeleton (joints and axes, masses and inertia ellipsoids, how far it comes), and its looks."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.envs.rendering.canvas import Canvas, Panel, camera_on
from ffgym.report.figure import new_figure, panels, require_matplotlib
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
"""Links and looks: all that a picture needs."""


@dataclass(frozen=True, kw_only=True)
class _View:
    """A projection on two axes of the world."""

    title: str
    right: int
    up: int

    @property
    def depth(self) -> int:
        """Axis of the world that is looked along."""
        return 3 - self.right - self.up


_VIEWS = (
    _View(title="from the side", right=0, up=2),
    _View(title="from the front", right=1, up=2),
    _View(title="from above", right=0, up=1),
)


def robot_figure(check: RobotCheck) -> "Figure":
    """Three views of the robot at rest; needs kinematics, and shows masses where they are known."""
    assert check.rest is not None
    assert check.rest.q is not None
    assert check.reach is not None
    with_masses = check.draft.can("kinematics", "links.mass", "links.com", "links.inertia")
    bones = skeleton(check.draft.description_for("kinematics"), check.rest.q)
    with panels(1, len(_VIEWS), size=(11.0, 4.0), legend=False) as (figure, grid):
        for axes, view in zip(grid[0], _VIEWS, strict=True):
            _draw(axes, view, bones, check.reach.points, check.draft.joints, with_masses=with_masses)
    return figure


def robot_caption(check: RobotCheck) -> str:
    """What the figure shows."""
    assert check.rest is not None
    masses = ""
    if check.draft.can("kinematics", "links.mass", "links.com", "links.inertia"):
        masses = (
            " Blue: centres of mass, with areas in proportion to the masses, and ellipsoids of uniform density that "
            "have the masses and inertias of the links."
        )
    return (
        f"The robot at {check.rest.name}: joints and links black, joint axes orange, the tip green (TCP, or end of the "
        f"chain). Grey: where the tip comes over {POSES} poses in the joint ranges.{masses}"
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
    size = _size(drawn)
    for point, axis in zip(bones.joints, bones.axes, strict=True):
        ends = point + np.outer([-1, 1], axis * size * _AXIS_LENGTH / 2)
        axes.plot(ends[:, right], ends[:, up], color=_AXIS, linewidth=1.4, zorder=5)
    _label(axes, view, bones.joints, joints, size)
    if with_masses:
        _masses(axes, view, bones)
    _frame(axes, view, drawn, size)


def _frame(axes: "Axes", view: _View, points: Array, size: float) -> None:
    """One scale for all views, with everything in the picture."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    half = _ROOM * size / 2
    axes.set(
        title=view.title,
        xlabel=f"{'xyz'[view.right]} [m]",
        ylabel=f"{'xyz'[view.up]} [m]",
        xlim=(middle[view.right] - half, middle[view.right] + half),
        ylim=(middle[view.up] - half, middle[view.up] + half),
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
    axes.scatter(
        bones.com[:, view.right],
        bones.com[:, view.up],
        s=_BUBBLE * np.maximum(bones.mass / bones.mass.max(), _LIGHTEST),
        color=_MASS,
        alpha=0.35,
        linewidths=0,
        zorder=3,
    )
    ellipse: Any = require_matplotlib().patches.Ellipse
    for com, half_axes, turn in zip(bones.com, bones.half_axes, bones.principal_axes, strict=True):
        width, height, angle = _shadow(half_axes, turn, view)
        shape = ellipse(com[[view.right, view.up]], width, height, angle=angle, fill=False, color=_MASS, lw=1.0)
        shape.set_zorder(3)
        axes.add_patch(shape)


def _shadow(half_axes: Array, turn: Array, view: _View) -> tuple[float, float, float]:
    """Width, height [m] and angle [deg] of an ellipsoid's outline in a view."""
    spread = (turn * half_axes**2) @ turn.T
    seen = spread[np.ix_([view.right, view.up], [view.right, view.up])]
    squares, directions = np.linalg.eigh(seen)
    width, height = 2 * np.sqrt(np.maximum(squares[::-1], 0.0))
    return float(width), float(height), float(np.degrees(np.arctan2(directions[1, 1], directions[0, 1])))


def _size(points: Array) -> float:
    """Longest side of the box around points [m]."""
    return float(np.ptp(points, axis=0).max()) or 1.0


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
    views = [camera_on(model, data, azimuth, elevation=-15.0) for azimuth in (130.0, 220.0)]
    halves = [Panel(place=(k / 2, 0.0, 0.5, 1.0), content=view) for k, view in enumerate(views)]
    picture = canvas.picture(data, halves)
    canvas.close()
    figure = new_figure(_SIZE[0] / 110, _SIZE[1] / 110)
    axes = figure.subplots()
    axes.imshow(picture)
    axes.set_axis_off()
    return figure
