"""Families whose members are found, not listed: those of a room, and those of other packages by entry points."""

from functools import cache
from importlib import import_module
from importlib.metadata import entry_points

from ffgym.core.errors import FFGymError


@cache
def load_families(group: str) -> None:
    """Import everything that declares members of a family, once: the room's own module `families`, then entry points.

    Args:
        group: dotted name of the room, e.g. 'ffgym.agents', which is the group of the entry points too.

    Raises:
        FFGymError: if an entry point of another package cannot be imported.
    """
    import_module(f"{group}.families")
    for point in sorted(entry_points(group=group), key=lambda point: point.name):
        try:
            point.load()
        except (ImportError, AttributeError) as error:
            owner = "a package" if point.dist is None else f"the package {point.dist.name!r}"
            raise FFGymError(
                f"Entry point {point.name!r} = {point.value!r} of {owner} in group {group!r} cannot be loaded: "
                f"{error}. Mend or uninstall that package."
            ) from error
