"""Write docs/effects: a page for each physical effect, and the table of all of them.

python -m scripts.effect_tables
"""

import inspect
import re
from dataclasses import dataclass
from pathlib import Path

import tyro

from ffgym.core.files import write_text
from ffgym.effects import EFFECTS, Effect
from ffgym.effects.parameters import Parameter
from scripts.format_tables import with_tables

_PER = {"joint": "joint", "pair": "pair of joints", "machine": "machine", "vector": "axis x, y, z"}


@dataclass(frozen=True)
class Config:
    """Pages of the effect library."""

    folder: Path = Path("docs/effects")
    """Where the page README.md holds the table, and one page per effect is written."""


def table() -> str:
    """Markdown table of all effects."""
    lines = ["| code | name | effect | added | side | enters by | looks like |", "|---|---|---|---|---|---|---|"]
    for name, effect in EFFECTS.items():
        entries = (
            effect.code,
            f"[`{name}`]({name}.md)",
            effect.title,
            f"$`{_in_table(effect.equation)}`$",
            effect.side,
            re.split("[:;,]", effect.way_in)[0],
            ", ".join(effect.confusable_with),
        )
        lines.append(f"| {' | '.join(entries)} |")
    return "\n".join(lines)


def page(effect: type[Effect]) -> str:
    """Markdown page of an effect."""
    sections = [
        f"# {effect.code}: {effect.title} (`{effect.name}`)",
        "Written by `python -m scripts.effect_tables`; [all effects](README.md).",
        _text(effect),
        f"```math\n{effect.equation}\n```",
        f"It acts on the {effect.side} side. How it enters the simulation: {effect.way_in}.",
        _parameters(effect),
        f"**How it shows.** {effect.signature[0].upper()}{effect.signature[1:]}.",
        _confusable(effect),
        _needs(effect),
    ]
    return "\n\n".join(section for section in sections if section) + "\n"


def _text(effect: type[Effect]) -> str:
    """What the class says of itself, with formulas as Markdown has them."""
    text = inspect.getdoc(effect) or ""
    text = re.sub(r"^Raises:\n.*?(\n\n|\Z)", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^Reference:\n\s*", "Reference: ", text, flags=re.MULTILINE)
    text = "\n\n".join(" ".join(part.split()) for part in text.strip().split("\n\n"))
    return re.sub(r":math:`(.+?)`", r"$`\1`$", text)


def _parameters(effect: type[Effect]) -> str:
    lines = [
        "| parameter | meaning | one per | unit | none at | plausible | source of the range |",
        "|---|---|---|---|---|---|---|",
    ]
    return "\n".join(lines + [_row(known) for known in effect.parameters().values()])


def _row(known: Parameter) -> str:
    null = "shape" if known.null is None else f"{known.null:g}"
    plausible = f"{known.low:g} to {known.high:g}"
    entries = (f"`{known.name}`", known.meaning, _PER[known.per], known.unit, null, plausible, known.source)
    return f"| {' | '.join(entries)} |"


def _confusable(effect: type[Effect]) -> str:
    by_code = {other.code: other for other in EFFECTS.values()}
    others = [f"[{code}, {by_code[code].title}]({by_code[code].name}.md)" for code in effect.confusable_with]
    protocols = ", ".join(f"`{name}`" for name in effect.separating_motions)
    alike = f"**What looks alike.** {'; '.join(others)}. " if others else "**What looks alike.** Nothing in torque. "
    return f"{alike}Protocols that tell it apart (`ffgym record`): {protocols}."


def _needs(effect: type[Effect]) -> str:
    needs = [
        text
        for needed, text in ((effect.needs_elasticity, "elasticity"), (effect.needs_friction, "friction"))
        if needed
    ]
    return f"It acts only on joints that have {' and '.join(needs)}." if needs else ""


def _in_table(equation: str) -> str:
    """A formula without bars, which would end a cell."""
    return equation.replace("|", r"\vert ")


def main(config: Config) -> list[Path]:
    """Write all pages."""
    overview = config.folder / "README.md"
    write_text(overview, with_tables(overview.read_text(encoding="utf-8"), {"effects": table()}))
    pages = [config.folder / f"{name}.md" for name in EFFECTS]
    for path, effect in zip(pages, EFFECTS.values(), strict=True):
        write_text(path, page(effect))
    return [overview, *pages]


if __name__ == "__main__":
    main(tyro.cli(Config))
