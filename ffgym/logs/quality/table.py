"""The checks as documentation."""

from ffgym.logs.quality.check import Check
from ffgym.logs.quality.gate import STAGES
from ffgym.logs.quality.needs import NEEDS


def markdown_table() -> str:
    """All checks by stage, as printed in docs/quality.md."""
    lines = ["| check | figure | unit | flagged above | refused above | why |", "|---|---|---|---|---|---|"]
    for stage, checks in STAGES.items():
        lines.append(f"| **{stage}** | | | | | |")
        lines += [_row(check) for check in checks]
    return "\n".join(lines)


def needs_table() -> str:
    """All uses, as printed in docs/quality.md."""
    lines = ["| need | columns | at least, on one joint | not even flagged | why |", "|---|---|---|---|---|"]
    for name, need in NEEDS.items():
        columns = ", ".join(f"`{column}`" for column in need.columns)
        least = ", ".join(f"{figure} {value:g}" for figure, value in need.least.items())
        sound = ", ".join(f"`{check}`" for check in need.sound)
        lines.append(f"| `{name}` | {columns} | {least} | {sound} | {need.why} |")
    return "\n".join(lines)


def _row(check: Check) -> str:
    limits = " | ".join("" if limit is None else f"{limit:.3g}" for limit in (check.flag, check.refuse))
    figure = check.figure.replace("|ln|", "absolute logarithm")
    return f"| `{check.name}` | {figure} | {check.unit} | {limits} | {check.why} |"
