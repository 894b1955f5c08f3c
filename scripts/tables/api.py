"""Public names of ffgym and of its rooms, docs/api.md, and the rooms on docs/architecture.md."""

import inspect
from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType

import ffgym
from scripts.tables.page import WHOLE, Contents, markdown

HEAD = """# Public names

Written by `python -m scripts.tables` from the `__init__.pyi` of each package. What stands here is public: it changes
only with a line in the changelog. Anything deeper than one level below `ffgym` may change without one.
"""


def packages() -> Iterator[ModuleType]:
    """Yield ffgym, then each of its rooms that has public names."""
    yield ffgym
    for name in sorted(found.name for found in iter_modules(ffgym.__path__) if found.ispkg):
        room = import_module(f"ffgym.{name}")
        if getattr(room, "__all__", None):
            yield room


def page() -> Contents:
    """The page as it should be now."""
    return Contents(parts={WHOLE: HEAD + "".join(_section(package) for package in packages())})


def architecture() -> Contents:
    """The table of rooms on docs/architecture.md, from their docstrings."""
    names = sorted(found.name for found in iter_modules(ffgym.__path__) if found.ispkg)
    rows = []
    for room in (import_module(f"ffgym.{name}") for name in names):
        lives, elsewhere = (" ".join(part.split()) for part in (inspect.getdoc(room) or "").split("\n\n"))
        rows.append((f"`{room.__name__}`", lives, elsewhere))
    return Contents(parts={"rooms": markdown(("room", "what lives there", "what does not, and where it is"), rows)})


def _section(package: ModuleType) -> str:
    rows = [_row(name, getattr(package, name)) for name in sorted(package.__all__, key=str.lower)]
    return f"\n## `{package.__name__}`\n\n{_first_sentence(package)}\n\n{markdown(('name', 'kind', ''), rows)}\n"


def _row(name: str, thing: object) -> tuple[str, str, str]:
    kind = "class" if inspect.isclass(thing) else "function" if inspect.isfunction(thing) else "value"
    text = _first_sentence(thing) if kind != "value" else f"of type `{type(thing).__name__}`"
    return f"`{name}`", kind, text


def _first_sentence(thing: object) -> str:
    """First paragraph of a docstring, on one line of a table."""
    text = inspect.getdoc(thing) or ""
    return " ".join(text.split("\n\n")[0].split())
