"""Workcells by name."""

from functools import cache

from ffgym.core.errors import check_choice
from ffgym.workcell.cell import Workcell
from ffgym.workcell.reading import build, read_tree

INSTANCES = ("thesis", "cold", "worn", "heavy_tool")
"""Workcells that ship with the package, each a file in `data`."""


@cache
def workcell(name: str) -> Workcell:
    """A workcell by its name.

    Raises:
        FFGymError: if there is none of that name.
    """
    return build(check_choice("workcell", name, INSTANCES), read_tree(name))
