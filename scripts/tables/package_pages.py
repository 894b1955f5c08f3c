"""Pages about the package: public names, packages, and one page of each physical effect."""

import inspect
import re
from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType

import ffgym
from ffgym.effects import EFFECTS, Effect
from scripts.tables.page import WHOLE, Contents, markdown

HEAD = """# Public names

Written by `python -m scripts.tables` from the `__init__.pyi` of each package. What stands here is public: it changes
only with a line in the changelog. Anything deeper than one level below `ffgym` may change without one.
"""

_PER = {"joint": "joint", "pair": "pair of joints", "machine": "machine", "vector": "axis x, y, z"}


def find_packages() -> Iterator[ModuleType]:
    """Yield ffgym, then each of its packages that has public names."""
    yield ffgym
    for name in sorted(found.name for found in iter_modules(ffgym.__path__) if found.ispkg):
        package = import_module(f"ffgym.{name}")
        if getattr(package, "__all__", None):
            yield package


def names() -> Contents:
    """The page of public names as it should be now."""
    sections = [HEAD]
    for package in find_packages():
        rows = []
        for name in sorted(package.__all__, key=str.lower):
            thing = getattr(package, name)
            kind = "class" if inspect.isclass(thing) else "function" if inspect.isfunction(thing) else "value"
            text = _first_sentence(thing) if kind != "value" else f"of type `{type(thing).__name__}`"
            rows.append((f"`{name}`", kind, text))
        table = markdown(("name", "kind", ""), rows)
        sections.append(f"\n## `{package.__name__}`\n\n{_first_sentence(package)}\n\n{table}\n")
    return Contents(parts={WHOLE: "".join(sections)})


def architecture() -> Contents:
    """The table of packages on docs/architecture.md, from their docstrings."""
    names = sorted(found.name for found in iter_modules(ffgym.__path__) if found.ispkg)
    rows = []
    for package in (import_module(f"ffgym.{name}") for name in names):
        lives, elsewhere = (" ".join(part.split()) for part in (inspect.getdoc(package) or "").split("\n\n"))
        rows.append((f"`{package.__name__}`", lives, elsewhere))
    return Contents(
        parts={"packages": markdown(("package", "what lives there", "what does not, and where it is"), rows)}
    )


def _first_sentence(thing: object) -> str:
    """First paragraph of a docstring, on one line of a table."""
    text = inspect.getdoc(thing) or ""
    return " ".join(text.split("\n\n")[0].split())


def effects() -> Contents:
    """Table of all effects."""
    rows = [
        (
            effect.code,
            f"[`{name}`]({name}.md)",
            effect.title,
            f"$`{effect.equation.replace('|', chr(92) + 'vert ')}`$",  # a bar would end the cell
            effect.side,
            re.split("[:;,]", effect.way_in)[0],
            ", ".join(effect.confusable_with),
        )
        for name, effect in EFFECTS.items()
    ]
    head = ("code", "name", "effect", "added", "side", "enters by", "looks like")
    return Contents(parts={"effects": markdown(head, rows)})


def effect_page(effect: type[Effect]) -> Contents:
    """Page of an effect."""
    rows = []
    for known in effect.parameters().values():
        null = "shape" if known.null is None else f"{known.null:g}"
        plausible = f"{known.low:g} to {known.high:g}"
        rows.append((f"`{known.name}`", known.meaning, _PER[known.per], known.unit, null, plausible, known.source))
    head = ("parameter", "meaning", "one per", "unit", "none at", "plausible", "source of the range")
    by_code = {other.code: other for other in EFFECTS.values()}
    others = [f"[{code}, {by_code[code].title}]({by_code[code].name}.md)" for code in effect.confusable_with]
    protocols = ", ".join(f"`{name}`" for name in effect.separating_motions)
    needs = {"elasticity": effect.needs_elasticity, "friction": effect.needs_friction}
    needed = " and ".join(name for name, is_needed in needs.items() if is_needed)
    sections = [
        f"# {effect.code}: {effect.title} (`{effect.name}`)",
        "Written by `python -m scripts.tables`; [all effects](README.md).",
        _text(effect),
        f"```math\n{effect.equation}\n```",
        f"It acts on the {effect.side} side. How it enters the simulation: {effect.way_in}.",
        markdown(head, rows),
        f"**How it shows.** {effect.signature[0].upper()}{effect.signature[1:]}.",
        f"**What looks alike.** {'; '.join(others) or 'Nothing in torque'}. "
        f"Protocols that tell it apart (`ffgym record`): {protocols}.",
        f"It acts only on joints that have {needed}." if needed else "",
    ]
    return Contents(parts={WHOLE: "\n\n".join(section for section in sections if section) + "\n"})


def _text(effect: type[Effect]) -> str:
    """Docstring of the class, with formulas as Markdown has them."""
    text = inspect.getdoc(effect) or ""
    text = re.sub(r"^Raises:\n.*?(\n\n|\Z)", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^Reference:\n\s*", "Reference: ", text, flags=re.MULTILINE)
    text = "\n\n".join(" ".join(part.split()) for part in text.strip().split("\n\n"))
    return re.sub(r":math:`(.+?)`", r"$`\1`$", text)
