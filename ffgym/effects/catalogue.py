"""Every effect by its name: those of the modules of this package, and those that other packages declare."""

import inspect
import pkgutil
from collections.abc import Iterator, Mapping
from functools import cached_property
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import final

import ffgym.effects
from ffgym.core.errors import FFGymError
from ffgym.effects.effect import Effect

GROUP = "ffgym.effects"
"""Group of the entry points by which a package declares effects of its own, one class each."""

_LETTERS = "FTMGXK"
"""First letters of codes in their order: friction, transmission, motor, gravity and load, measurement, controller."""

_NEEDED = ("name", "code", "title", "equation", "side", "signature", "way_in")
"""Attributes that a class must have to be listed."""


@final
class EffectCatalogue(Mapping[str, type[Effect]]):
    """Effects by name, in the order of their codes; their modules are imported when the first effect is looked up.

    An effect of this package is a class with a code. One of another package is a class that its entry point names;
    other subclasses of Effect, such as the equations of a workcell, are no members.

    Raises:
        FFGymError: at the first look-up, if an entry point names no effect, or one whose name or code is taken.
    """

    def __getitem__(self, name: str) -> type[Effect]:
        return self._members[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._members)

    def __len__(self) -> int:
        return len(self._members)

    @cached_property
    def _members(self) -> dict[str, type[Effect]]:
        found: dict[str, type[Effect]] = {}
        for package in pkgutil.walk_packages(ffgym.effects.__path__, "ffgym.effects."):
            for kind in vars(import_module(package.name)).values():
                if (
                    isinstance(kind, type)
                    and issubclass(kind, Effect)
                    and kind.__module__ == package.name
                    and kind.code
                ):
                    found[kind.name] = kind
        for entry in entry_points(group=GROUP):
            kind = _foreign_effect(entry)
            for other in found.values():
                if kind.name == other.name or kind.code == other.code:
                    raise FFGymError(
                        f"{_describe(entry)} is effect {kind.name!r} with code {kind.code!r}, but there is effect "
                        f"{other.name!r} with code {other.code!r} already. Give it a name and a code of its own."
                    )
            found[kind.name] = kind
        return dict(sorted(found.items(), key=lambda item: _rank(item[1].code)))


EFFECTS: Mapping[str, type[Effect]] = EffectCatalogue()
"""Every effect by name."""


def _foreign_effect(entry: EntryPoint) -> type[Effect]:
    """Load the class that an entry point names, and check that it is an effect."""
    try:
        kind = entry.load()
    except Exception as error:  # whatever the package of somebody else raises
        raise FFGymError(
            f"{_describe(entry)} cannot be loaded: {type(error).__name__}: {error}. Mend the package, or uninstall it."
        ) from error
    if not (isinstance(kind, type) and issubclass(kind, Effect)) or inspect.isabstract(kind):
        raise FFGymError(
            f"{_describe(entry)} = {entry.value} must be a class without abstract methods that inherits from one of "
            "ffgym.effects.NativeEffect, ModelEffect, TorqueEffect, ResolverEffect, TrackerEffect or ClockEffect."
        )
    if missing := [name for name in _NEEDED if not getattr(kind, name, "")]:
        raise FFGymError(f"{_describe(entry)}: class {kind.__name__} lacks {missing}; see docs/extending.md.")
    return kind


def _describe(entry: EntryPoint) -> str:
    package = f" of package {entry.dist.name}" if entry.dist else ""
    return f"Entry point {entry.name!r}{package} in group {GROUP!r}"


def _rank(code: str) -> tuple[int, str, int]:
    """Place of a code among all: by the letter, then by the number; unknown letters come last."""
    letters = code.rstrip("0123456789")
    number = code[len(letters) :]
    known = _LETTERS.find(letters) if len(letters) == 1 else -1
    return known if known >= 0 else len(_LETTERS), letters, int(number or 0)
