"""How feed-forward laws are called and drawn: the same words and the same colour in every table and figure."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import cycle, product

UNCOMPENSATED = "none"
"""Name of the law that adds nothing; others are compared with it."""
ORACLE = "oracle"
"""Name of the law that knows the machine's true parameters; it is shown, and never called the best."""


@dataclass(frozen=True, kw_only=True)
class LawStyle:
    """Look of one law."""

    label: str
    """Words for readers."""
    colour: str
    marker: str
    line: str = "-"


_KNOWN = {
    "none": LawStyle(label="no compensation", colour="#0072B2", marker="o"),
    "lugre_static": LawStyle(label="static LuGre", colour="#D55E00", marker="s"),
    "lugre_dynamic": LawStyle(label="dynamic LuGre", colour="#009E73", marker="^"),
    "lugre_identified": LawStyle(label="dynamic LuGre, identified", colour="#56B4E9", marker="P"),
    "bsn_static": LawStyle(label="static B-spline network", colour="#CC79A7", marker="D"),
    "bsn_extended": LawStyle(label="extended B-spline network", colour="#E69F00", marker="v"),
    "bsn_extended_prior": LawStyle(label="B-spline network with prior", colour="#B8860B", marker="^", line="--"),
    "mlp_fel": LawStyle(label="perceptron", colour="#7F4F24", marker="X", line="-."),
    "residual_gp": LawStyle(label="residual torque model", colour="#8C6BB1", marker="P", line="-."),
    "narx": LawStyle(label="NARX network", colour="#56B4E9", marker="*", line="-."),
    "elastic": LawStyle(label="elastic feed-forward", colour="#A50F15", marker="p"),
    "model": LawStyle(label="model feed-forward", colour="#1B7837", marker="h"),
    "ilc_motor": LawStyle(label="iterative learning, motors", colour="#3B0F70", marker="<", line=":"),
    "ilc_tcp": LawStyle(label="iterative learning, tool", colour="#3B0F70", marker=">"),
    "oracle": LawStyle(label="oracle (true parameters)", colour="#A50F15", marker="H", line=":"),
}
"""Blue, red, green as in the thesis, in the colour-blind safe shades of Okabe and Ito."""
_SPARE = tuple(product(("-", "--", ":"), (("#56B4E9", "P"), ("#8C6BB1", "X"), ("#7F4F24", "*"), ("#5C5C5C", "h"))))


def law_styles(agents: Iterable[str]) -> dict[str, LawStyle]:
    """Style by law name, in the given order; laws without a fixed style get spare ones in order of appearance."""
    spare = cycle(_SPARE)
    styles: dict[str, LawStyle] = {}
    for agent in agents:
        if agent not in styles:
            styles[agent] = _KNOWN[agent] if agent in _KNOWN else _spare_style(agent, *next(spare))
    return styles


def _spare_style(agent: str, line: str, look: tuple[str, str]) -> LawStyle:
    return LawStyle(label=agent.replace("_", " "), colour=look[0], marker=look[1], line=line)


def baseline_of(agents: Sequence[str]) -> str:
    """Law that others are compared with: no compensation, else the first."""
    return UNCOMPENSATED if UNCOMPENSATED in agents else agents[0]


def compensated(agents: Sequence[str]) -> list[str]:
    """Laws other than the baseline; the baseline itself where there is no other."""
    return [agent for agent in agents if agent != baseline_of(agents)] or list(agents)
