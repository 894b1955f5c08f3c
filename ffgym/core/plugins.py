"""Discovery of the members of a family: in modules of a package, and by entry points of other packages."""

import pkgutil
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points

from ffgym.core.errors import FFGymError


@cache
def load_families(group: str, own: str = "") -> None:
    """Import all modules that declare members of a family, once: those of a package, then those of other packages.

    Args:
        group: group of the entry points, e.g. 'ffgym.agents'.
        own: module that declares members, or package all of whose modules do; by default `families` in the package
            that the group is called after.

    Raises:
        FFGymError: if an entry point of another package cannot be imported.
    """
    package = import_module(own or f"{group}.families")
    for module in pkgutil.iter_modules(getattr(package, "__path__", ())):
        import_module(f"{package.__name__}.{module.name}")
    for point in sorted(entry_points(group=group), key=lambda point: point.name):
        try:
            point.load()
        except Exception as error:  # another package may raise anything
            owner = "a package" if point.dist is None else f"the package {point.dist.name!r}"
            raise FFGymError(
                f"Entry point {point.name!r} = {point.value!r} of {owner} in group {group!r} cannot be loaded: "
                f"{error}. Mend or uninstall that package."
            ) from error
