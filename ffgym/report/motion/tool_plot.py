"""The path of the tool on a motion of a study, with the path error of every law magnified."""

from typing import TYPE_CHECKING

import numpy as np

from ffgym.recordings.metrics import Contour
from ffgym.report.laws import law_styles
from ffgym.report.tool_path import ToolPath, scale_of_error, sights_of, tool_path_figure
from ffgym.studies import MotionStudy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ffgym.core.types import Array


def motion_path_figure(study: MotionStudy, motion: str) -> "Figure":
    """Path of the tool with every law beside the reference, dashed."""
    paths, reference = _paths(study, motion), _reference(study, motion)
    look = {"color": "k", "linewidth": 0.7, "linestyle": (0, (5, 3)), "label": "reference"}
    return tool_path_figure(paths, reference, look, scale_of_error(paths, reference))


def motion_path_caption(study: MotionStudy, motion: str) -> str:
    """What the figure shows, with its magnification and the largest deviation of each law."""
    paths, reference = _paths(study, motion), _reference(study, motion)
    factor, sights = scale_of_error(paths, reference), sights_of(reference)
    worst = ", ".join(f"{path.label} {1e3 * path.distance.max():.3f} mm" for path in paths)
    drawn = "drawn to scale" if factor == 1 else f"drawn {factor:g} times as large"
    hidden = max(float(np.abs(path.error @ sights[0].normal).max()) for path in paths)
    looked = f"Seen along its normal, up to {1e3 * hidden:.3f} mm are out of its plane. " if len(sights) == 1 else ""
    return (
        f"{looked}Dashed: reference. Deviations from it are {drawn}; where the tool is late on the right path there is "
        f"none. The offset at the start is removed. Dots: largest deviation in space ({worst})."
    )


def _paths(study: MotionStudy, motion: str) -> list[ToolPath]:
    styles = law_styles(study.agents)
    widths = np.linspace(2.4, 1.0, len(styles)) if len(styles) > 1 else [1.3]  # what lies below shows beside
    contours = [Contour.of(study.recordings[law, motion]) for law in styles]
    return [
        ToolPath(
            label=style.label,
            nearest=contour.nearest,
            error=contour.error,
            look={"color": style.colour, "linestyle": style.line, "linewidth": width},
        )
        for style, contour, width in zip(styles.values(), contours, widths, strict=True)
    ]


def _reference(study: MotionStudy, motion: str) -> "Array":
    return study.recordings[study.agents[0], motion].vector("tcp_reference.position")
