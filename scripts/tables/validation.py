"""The sheet of what is validated and what is not: docs/validation.md, from validation.toml beside this module."""

import json
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from ffgym.core.files import read_text
from ffgym.leaderboard.comparison.samples import WORKCELLS
from scripts.tables.leaderboard import row_of
from scripts.tables.page import DOCS, Contents, markdown
from scripts.tables.thesis import claim_of, count_verdicts, hold, items

SHEET = Path(__file__).with_name("validation.toml")
KINDS = {
    "real machine": "real machine",
    "published": "published numbers",
    "second engine": "second engine",
    "other programs": "other programs",
    "closed form": "closed form",
    "ours": "made by us",
}
"""What a claim is held against, and how the page calls it; the strongest evidence first."""

EXAMS = {
    "exam": (
        "clean logs named",
        "one effect, 10 and more: right effect and joint first",
        "one effect, 10 and more: wrong named",
    ),
    "independent": ("clean logs named", "one effect, 10 and more: right or in the tie", "wrong names"),
}
"""Figures of each exam that the sheet tells: clean logs that are named, loud effects that are right, wrong names."""


@dataclass(frozen=True, kw_only=True)
class Validated:
    """One claim, and how it was held against something."""

    group: str
    what: str
    kind: str
    """One of `KINDS`."""
    data: str
    error: str
    by: list[str] | str
    """Tests, or one command."""
    bounds: dict[str, str] = field(default_factory=dict)
    """Printed numbers that a test demands, each with the words of the test that do."""


def rows() -> list[Validated]:
    """Read the rows of what is validated."""
    return [Validated(**row) for row in _sheet()["validated"]]


def _sheet() -> dict[str, Any]:
    return tomllib.loads(read_text(SHEET))


def validation() -> Contents:
    """Tables of what is validated, by group, of what it is held against, and of what is not validated."""
    values = numbers()
    groups: dict[str, list[tuple[str, ...]]] = {}
    for row in rows():
        told = (row.what, KINDS[row.kind], row.data.format_map(values), row.error.format_map(values), shown_by(row))
        groups.setdefault(row.group, []).append(told)
    head = ("claim", "held against", "data", "error", "shown by")
    parts = [f"### {group}\n\n{markdown(head, each)}" for group, each in groups.items()]
    missing = [(row["what"], row["why"].format_map(values)) for row in _sheet()["not_validated"]]
    kinds = [(name, str(sum(row.kind == kind for row in rows()))) for kind, name in KINDS.items()]
    return Contents(
        parts={
            "kinds": markdown(("held against", "claims"), kinds),
            "validated": "\n\n".join(parts),
            "not validated": markdown(("not validated", "why, and what that means"), missing),
        }
    )


def shown_by(row: Validated) -> str:
    """Links to the tests of a row, or its command."""
    if isinstance(row.by, str):
        return f"`{row.by}`"
    return ", ".join(f"[{_short(test)}](../{test.partition('::')[0]})" for test in row.by)


def _short(test: str) -> str:
    return test.partition("::")[2].removeprefix("test_").replace("_", " ")


@cache
def numbers() -> Mapping[str, str]:
    """Numbers of stored results by their name in the sheet, as they are printed."""
    verdicts = count_verdicts()
    both = verdicts["chapter-4"] + verdicts["chapter-5"]
    found = {
        "claims": both.total(),
        "claims_hold": both["holds"],
        "claims_partly": both["partly"],
        "claims_fail": both["does not hold"],
    }
    near = {}
    for table, speed in ((1, 10), (2, 40)):
        claim = claim_of(f"T4.{table}-sizes")
        near[f"near_none_{speed}"] = hold(claim["fitted"])
        near[f"near_dynamic_{speed}"] = hold([c for c in claim["checks"] if c["where"].startswith("dynamic")])
    left = {
        f"left_{name}": f"{100 * row_of(WORKCELLS, name).score.left:.0f}" for name in ("elastic", "fitted", "amortised")
    }
    return {
        **{name: str(value) for name, value in found.items()},
        **near,
        **left,
        **_micrometres(),
        **_trial(),
        **_exam("exam", "exam"),
        **_exam("independent", "other"),
    }


def _micrometres() -> dict[str, str]:
    """Mean path errors of the table of agents [um], by law and speed."""
    table = {row[0]: row[-3:] for row in items()["agents"]["numbers"][0]["rows"]}
    names = {"none": "no compensation", "elastic": "elastic feed-forward"}
    return {
        f"{short}_{speed}": table[name][k].split(" ")[0]
        for short, name in names.items()
        for k, speed in enumerate((10, 40, 100))
    }


def _trial() -> dict[str, str]:
    """Count the programs of simulated trials whose interval holds the true gain."""
    kept = json.loads(read_text(DOCS / "deployment" / "trial_coverage.json"))["rows"]
    return {"trial_rows": str(len(kept)), "trial_covered": str(sum(row["covered"] for row in kept))}


def _exam(part: str, name: str) -> dict[str, str]:
    """Read figures of an exam from its part of docs/bench_diagnosis.md, which `make exam` writes."""
    page = read_text(DOCS / "bench_diagnosis.md")
    (text,) = re.findall(rf"<!-- {part} -->\n(.*?)<!-- end -->", page, flags=re.DOTALL)
    cells = [[cell.strip() for cell in line.split("|")] for line in text.splitlines() if line.startswith("| ")]
    figures = {row[2]: row[4:6] for row in cells if len(row) == 8}
    (questions,) = re.findall(r"all (\d+) questions", text)
    clean, right, wrong = EXAMS[part]
    return {
        f"{name}_questions": questions,
        **{f"{name}_clean{suffix}": value for suffix, value in zip(("", "_of"), figures[clean], strict=True)},
        **{f"{name}_wrong{suffix}": value for suffix, value in zip(("", "_of"), figures[wrong], strict=True)},
        f"{name}_right": f"{float(figures[right][0].rstrip('%')) * int(figures[right][1]) / 100:.0f}",
        f"{name}_right_of": figures[right][1],
    }
