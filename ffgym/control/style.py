"""Look of a law in tables and figures, by name."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class LawStyle:
    """Look of one law."""

    label: str
    """Name for readers."""
    colour: str
    marker: str
    line: str = "-"


STYLES: dict[str, LawStyle] = {
    "lugre_identified": LawStyle(label="dynamic LuGre, identified", colour="#56B4E9", marker="P"),
}
"""Looks by name. Agents enter theirs (`ffgym.agents.declaration`). Blue,
red, green as in the thesis, in the colour-blind safe shades of Okabe and Ito."""
