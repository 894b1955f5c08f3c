"""How feed-forward laws are called and drawn: the same words and the same colour in every table and figure."""

from collections.abc import Iterable, Sequence
from itertools import cycle, product

from ffgym.control.style import STYLES
from ffgym.control.style import LawStyle as LawStyle
from ffgym.core.plugins import load_families

UNCOMPENSATED = "none"
"""Name of the law that adds nothing; others are compared with it."""
ORACLE = "oracle"
"""Name of the law that knows the machine's true parameters; it is shown, and never called the best."""


_SPARE = tuple(product(("-", "--", ":"), (("#56B4E9", "P"), ("#8C6BB1", "X"), ("#7F4F24", "*"), ("#5C5C5C", "h"))))


def law_styles(agents: Iterable[str]) -> dict[str, LawStyle]:
    """Style by law name, in the given order; laws without a fixed style get spare ones in order of appearance."""
    load_families("ffgym.agents")
    spare = cycle(_SPARE)
    styles: dict[str, LawStyle] = {}
    for agent in agents:
        if agent not in styles:
            styles[agent] = STYLES[agent] if agent in STYLES else _spare_style(agent, *next(spare))
    return styles


def _spare_style(agent: str, line: str, look: tuple[str, str]) -> LawStyle:
    return LawStyle(label=agent.replace("_", " "), colour=look[0], marker=look[1], line=line)


def baseline_of(agents: Sequence[str]) -> str:
    """Law that others are compared with: no compensation, else the first."""
    return UNCOMPENSATED if UNCOMPENSATED in agents else agents[0]


def compensated(agents: Sequence[str]) -> list[str]:
    """Laws other than the baseline; the baseline itself where there is no other."""
    return [agent for agent in agents if agent != baseline_of(agents)] or list(agents)
