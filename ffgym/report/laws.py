"""Names and styles of feed-forward laws: the same words and the same colour in every table and figure."""

from collections.abc import Iterable, Sequence
from itertools import cycle, product

from ffgym.control.style import STYLES
from ffgym.control.style import LawStyle as LawStyle
from ffgym.core.plugins import load_families
from ffgym.report.table import Cell, Column

UNCOMPENSATED = "none"
"""Name of the law that adds nothing; others are compared with it."""
ORACLE = "oracle"
"""Name of the law with the machine's true parameters; it is shown, and never called the best."""

_SPARE = tuple(product(("-", "--", ":"), (("#56B4E9", "P"), ("#8C6BB1", "X"), ("#7F4F24", "*"), ("#5C5C5C", "h"))))


def law_styles(agents: Iterable[str]) -> dict[str, LawStyle]:
    """Return styles by law name, in the given order; laws without a fixed style get spare ones in turn."""
    load_families("ffgym.agents")
    spare = cycle(_SPARE)
    styles: dict[str, LawStyle] = {}
    for agent in agents:
        if agent not in styles:
            if agent in STYLES:
                styles[agent] = STYLES[agent]
            else:
                line, (colour, marker) = next(spare)
                styles[agent] = LawStyle(label=agent.replace("_", " "), colour=colour, marker=marker, line=line)
    return styles


def law_column(heading: str, agents: Sequence[str]) -> Column:
    """Make a column of laws in their words and colours, one for each row."""
    styles = law_styles(agents)
    return Column(heading, [Cell(styles[law].label, colour=styles[law].colour) for law in agents], kind="name")


def baseline_of(agents: Sequence[str]) -> str:
    """Return the law that others are compared with: no compensation, else the first."""
    return UNCOMPENSATED if UNCOMPENSATED in agents else agents[0]


def list_compensated(agents: Sequence[str]) -> list[str]:
    """List the laws other than the baseline; the baseline itself if there is no other."""
    return [agent for agent in agents if agent != baseline_of(agents)] or list(agents)
