"""Figures of reports: a picture with its words, saved as a file or embedded in a page.

This is the one door to matplotlib, which is imported when a figure is made: no pyplot, no windows, no lasting settings.
"""

import base64
import io
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from math import ceil
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import check_writable, write_bytes
from ffgym.core.types import Array, IntArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE_FORMATS = ("svg", "png", "pdf")
"""Formats of `save_figure`, by suffix."""

_STYLE: dict[str, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.labelsize": 9.0,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#666666",
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.fontsize": 9.0,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "lines.solid_joinstyle": "round",
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "svg.hashsalt": "ffgym",  # equal figures give equal bytes
}

_DENSE = 100_000
"""Points of a figure's lines from which on they are drawn as pixels: as vectors they take 20 bytes each, and a page of
several such figures could not be sent."""

POINTS = 2000
"""Points of a thinned line: twice the pixels of a figure's width."""

_EMBEDDED_DPI = 220
"""Pixels per inch of dense lines in a page, so that they stay sharp on a fine screen."""

_LEGEND_HANDLE, _LEGEND_LETTER = 0.55, 0.065
"""Width of an entry's line with its margins and of a letter [inch], at the font size above; measured, rounded up."""


@dataclass(frozen=True, eq=False)
class ReportFigure:
    """A picture with its words."""

    name: str
    """Name in file names and links."""
    title: str
    """Title, and description of the picture for screen readers."""
    caption: str
    figure: "Figure"
    thesis: str = ""
    """Figure of the thesis that shows the same; empty if the page names it."""

    @property
    def width(self) -> int:
        """Own width on a page [pixel]."""
        return round(self.figure.get_figwidth() * 96)

    @cached_property
    def source(self) -> str:
        """Picture as a data address, so that a page needs no other file; drawn once, as layouts drift."""
        picture = base64.b64encode(encode_figure(self.figure, "svg", _EMBEDDED_DPI)).decode()
        return f"data:image/svg+xml;base64,{picture}"


def require_matplotlib() -> ModuleType:
    """Return matplotlib; FFGymError if it is not installed."""
    try:
        import matplotlib
        import matplotlib.figure
    except ImportError as error:
        raise FFGymError("A figure needs matplotlib; pip install 'ffgym[report]'.") from error
    return matplotlib


@contextmanager
def house_style() -> Iterator[None]:
    """Draw in the style of the reports, with the user's matplotlibrc left aside; restore the user's settings."""
    matplotlib = require_matplotlib()
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_STYLE)
        yield


def new_figure(width: float, height: float) -> "Figure":
    """Make an empty figure of that size [inch], without a window."""
    figure: Figure = require_matplotlib().figure.Figure(figsize=(width, height), layout="constrained")
    return figure


@contextmanager
def panels(
    rows: int = 1, columns: int = 1, *, size: tuple[float, float], legend: bool = True, **options: Any
) -> Iterator[tuple["Figure", Any]]:
    """Draw on a new figure in the house style, with one legend of all panels above.

    Args:
        rows: number of rows of panels.
        columns: number of columns of panels.
        size: width and height [inch].
        legend: True for a legend.
        options: options of matplotlib's `subplots`, e.g. sharex.

    Yields:
        The figure and its axes, shape (rows, columns).
    """
    with house_style():
        figure = new_figure(*size)
        yield figure, figure.subplots(rows, columns, squeeze=False, **options)
        entries: dict[str, Any] = {}
        for axes in figure.axes if legend else ():
            for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
                entries.setdefault(label, handle)
        if entries:
            legend_above(figure, list(entries.values()), list(entries))


def legend_above(figure: "Figure", handles: Sequence[Any], labels: Sequence[str]) -> None:
    """Put a legend above all panels, in as many columns as fit the width of the figure."""
    longest = max(len(label) for label in labels)
    room = max(int(figure.get_figwidth() / (_LEGEND_HANDLE + longest * _LEGEND_LETTER)), 1)
    rows = ceil(len(labels) / room)
    figure.legend(handles, labels, loc="outside upper center", ncols=ceil(len(labels) / rows))


def keep_peaks(values: Array) -> IntArray:
    """Select rows of `values` (T,) to draw, ascending: smallest and largest of each of POINTS / 2 stretches.

    All rows if there are no more than POINTS; NaN stands for a gap and is never chosen where there is a number.
    """
    if len(values) <= POINTS:
        return np.arange(len(values))
    kept = [np.array([0, len(values) - 1])]
    # the first stretches have a row more if they cannot all have the same length
    length, longer = divmod(len(values), POINTS // 2)
    cut = longer * (length + 1)
    for first, last, width in ((0, cut, length + 1), (cut, len(values), length)):
        stretches, starts = values[first:last].reshape(-1, width), np.arange(first, last, width)
        gaps = np.isnan(stretches)
        kept.append(starts + np.where(gaps, np.inf, stretches).argmin(axis=1))
        kept.append(starts + np.where(gaps, -np.inf, stretches).argmax(axis=1))
    return np.unique(np.concatenate(kept))


def encode_figure(figure: "Figure", kind: Literal["svg", "png", "pdf"] = "svg", dpi: float = 110) -> bytes:
    """Encode a picture file; `dpi` [pixel/inch] counts for png, and for lines of very many points in the others."""
    lines = [line for axes in figure.axes for line in axes.lines]
    dense = sum(len(line.get_path()) for line in lines) > _DENSE
    for line in lines:
        line.set_rasterized(dense)
    date = {"svg": "Date", "pdf": "CreationDate"}.get(kind)
    buffer = io.BytesIO()
    with house_style(), _laid_out(figure, format=kind, dpi=dpi):
        figure.savefig(buffer, format=kind, dpi=dpi, metadata={date: None} if date else None)
    return buffer.getvalue()


@contextmanager
def _laid_out(figure: "Figure", **options: Any) -> Iterator[None]:
    """Arrange a figure as `savefig` with these options does, which draws all of it once more to that end."""
    engine: Any = figure.get_layout_engine()
    if engine is None:
        yield
        return

    class Arranged(Exception):
        """End of the part of `savefig` that arranges."""

    def arrange(figure: "Figure") -> None:
        type(engine).execute(engine, figure)
        raise Arranged

    with suppress(Arranged):
        engine.execute = arrange
        figure.savefig(io.BytesIO(), **options)
    del engine.execute
    figure.set_layout_engine("none")
    try:
        yield
    finally:
        figure.set_layout_engine(engine)


def check_figure(path: str | os.PathLike[str]) -> Path:
    """Check a path for `save_figure`, before work that ends in a figure.

    Raises:
        FFGymError: if the suffix is unknown, the file cannot be written, or matplotlib is not installed.
    """
    require_matplotlib()
    target = Path(path)
    check_choice("figure format", target.suffix.lower().lstrip("."), FIGURE_FORMATS)
    check_writable(target)
    return target


def save_figure(figure: "Figure", path: str | os.PathLike[str], dpi: float = 150) -> Path:
    """Write a figure to `path`, which ends in .svg, .png or .pdf, whole or not at all.

    Raises:
        FFGymError: if the suffix is unknown or the file cannot be written.
    """
    target = check_figure(path)
    kind: Any = target.suffix.lower().lstrip(".")
    write_bytes(target, encode_figure(figure, kind, dpi))
    return target
