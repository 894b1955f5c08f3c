"""Pages from templates: the one door to jinja2."""

import base64
from collections.abc import Mapping
from importlib import resources
from typing import TYPE_CHECKING, Any

from ffgym.core.errors import FFGymError
from ffgym.report._matplotlib import encode_figure, require_matplotlib
from ffgym.report.circles.comparison import percent
from ffgym.report.circles.figures import ReportFigure

if TYPE_CHECKING:
    from jinja2 import Environment


_DPI = 220
"""Pixels per inch of dense lines in a page, so that they stay sharp on a fine screen."""


def render(name: str, **context: Any) -> str:
    """HTML of the template of that name.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    require_matplotlib()
    return _environment().get_template(name).render(**context)


def embedded(figure: ReportFigure) -> dict[str, Any]:
    """A figure as the template takes it: its picture inside the page."""
    picture = base64.b64encode(encode_figure(figure.figure, "svg", _DPI)).decode()
    return {
        "name": figure.name,
        "title": figure.title,
        "thesis": figure.thesis,
        "caption": figure.caption,
        "width": round(figure.figure.get_figwidth() * 96),
        "source": f"data:image/svg+xml;base64,{picture}",
    }


def provenance_lines(info: Mapping[str, Any]) -> dict[str, str]:
    """Names and values as text; the entries of a dict become lines, those of a list stand in one."""
    lines: dict[str, str] = {}
    for name, value in info.items():
        if isinstance(value, Mapping):
            lines |= provenance_lines(value)
        elif isinstance(value, list | tuple):
            lines[name.replace("_", " ")] = ", ".join(str(entry) for entry in value) or "none"
        else:
            lines[name.replace("_", " ")] = "none" if value is None else str(value)
    return lines


def _environment() -> "Environment":
    try:
        from jinja2 import Environment, FunctionLoader, StrictUndefined
    except ImportError as error:
        raise FFGymError("The report page needs jinja2; pip install 'ffgym[report]'.") from error
    environment = Environment(
        loader=FunctionLoader(_template),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["change"] = lambda share: "–" if share is None else percent(share)
    environment.filters["mm"] = lambda value, digits=3: "–" if value is None else f"{value:.{digits}f}"
    return environment


def _template(name: str) -> str:
    return (resources.files("ffgym.report") / "templates" / name).read_text(encoding="utf-8")
