"""Pages of the effect library: one of each physical effect, and the table of all of them."""

import inspect
import re

from ffgym.effects import EFFECTS, Effect
from scripts.tables.page import WHOLE, Contents, markdown

_PER = {"joint": "joint", "pair": "pair of joints", "machine": "machine", "vector": "axis x, y, z"}


def overview() -> Contents:
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


def page(effect: type[Effect]) -> Contents:
    """Page of an effect."""
    sections = [
        f"# {effect.code}: {effect.title} (`{effect.name}`)",
        "Written by `python -m scripts.tables`; [all effects](README.md).",
        _text(effect),
        f"```math\n{effect.equation}\n```",
        f"It acts on the {effect.side} side. How it enters the simulation: {effect.way_in}.",
        _parameters(effect),
        f"**How it shows.** {effect.signature[0].upper()}{effect.signature[1:]}.",
        _confusable(effect),
        _needs(effect),
    ]
    return Contents(parts={WHOLE: "\n\n".join(section for section in sections if section) + "\n"})


def _text(effect: type[Effect]) -> str:
    """Docstring of the class, with formulas as Markdown has them."""
    text = inspect.getdoc(effect) or ""
    text = re.sub(r"^Raises:\n.*?(\n\n|\Z)", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^Reference:\n\s*", "Reference: ", text, flags=re.MULTILINE)
    text = "\n\n".join(" ".join(part.split()) for part in text.strip().split("\n\n"))
    return re.sub(r":math:`(.+?)`", r"$`\1`$", text)


def _parameters(effect: type[Effect]) -> str:
    rows = []
    for known in effect.parameters().values():
        null = "shape" if known.null is None else f"{known.null:g}"
        plausible = f"{known.low:g} to {known.high:g}"
        rows.append((f"`{known.name}`", known.meaning, _PER[known.per], known.unit, null, plausible, known.source))
    head = ("parameter", "meaning", "one per", "unit", "none at", "plausible", "source of the range")
    return markdown(head, rows)


def _confusable(effect: type[Effect]) -> str:
    by_code = {other.code: other for other in EFFECTS.values()}
    others = [f"[{code}, {by_code[code].title}]({by_code[code].name}.md)" for code in effect.confusable_with]
    protocols = ", ".join(f"`{name}`" for name in effect.separating_motions)
    alike = f"**What looks alike.** {'; '.join(others)}. " if others else "**What looks alike.** Nothing in torque. "
    return f"{alike}Protocols that tell it apart (`ffgym record`): {protocols}."


def _needs(effect: type[Effect]) -> str:
    known = {"elasticity": effect.needs_elasticity, "friction": effect.needs_friction}
    needs = [text for text, needed in known.items() if needed]
    return f"It acts only on joints that have {' and '.join(needs)}." if needs else ""
