"""The reproduction as data: every item with its pictures, tables and verdicts."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from ffgym.report import ReportFigure, SpeedTable
from ffgym.robot import ModelOptions, compile_model, physics_fingerprint
from scripts.thesis.claims import VERDICTS, Judgement, Verdict, judge
from scripts.thesis.items import Item, PlainTable
from scripts.thesis.laboratory import WORKCELL, Laboratory


@dataclass(frozen=True, kw_only=True, eq=False)
class Reproduced:
    """One item, simulated and judged."""

    item: Item
    judgements: tuple[Judgement, ...]
    figures: tuple[ReportFigure, ...]
    tables: tuple[SpeedTable, ...]
    numbers: tuple[PlainTable, ...]


def reproduce(items: Sequence[Item], laboratory: Laboratory) -> Iterator[Reproduced]:
    """Simulate what each item needs, draw it, and judge its claims; one item after the other."""
    for item in items:
        yield Reproduced(
            item=item,
            judgements=tuple(judge(claim, laboratory) for claim in item.claims),
            figures=tuple(item.figures(laboratory)),
            tables=tuple(item.tables(laboratory)),
            numbers=tuple(item.numbers(laboratory)),
        )


def count(results: Sequence[Reproduced]) -> dict[Verdict, int]:
    """How many claims have each verdict; verdicts that none has are left out."""
    found = Counter(judgement.verdict for result in results for judgement in result.judgements)
    return {verdict: found[verdict] for verdict in VERDICTS if found[verdict]}


def fingerprints(laboratory: Laboratory) -> dict[str, str]:
    """Physics fingerprint of each robot and of the workcell, by name."""
    robots = (laboratory.robot, laboratory.axis)
    found = {robot.name: physics_fingerprint(compile_model(robot, ModelOptions(looks=False))) for robot in robots}
    return found | {WORKCELL: laboratory.workcell.fingerprint}


def as_json(results: Sequence[Reproduced], info: Mapping[str, Any]) -> dict[str, Any]:
    """Everything that was found, as JSON can hold it, with its origin `info`."""
    return {**info, "verdicts": count(results), "items": [_item(result) for result in results]}


def _item(result: Reproduced) -> dict[str, Any]:
    return {
        "name": result.item.name,
        "chapter": result.item.chapter,
        "title": result.item.title,
        "counterpart": result.item.counterpart,
        "claims": [_claim(judgement) for judgement in result.judgements],
        "figures": {figure.name: figure.caption for figure in result.figures},
        "tables": [asdict(table) for table in result.tables],
        "numbers": [asdict(table) for table in result.numbers],
    }


def _claim(judgement: Judgement) -> dict[str, Any]:
    return {
        "name": judgement.claim.name,
        "statement": judgement.claim.statement,
        "criterion": judgement.claim.criterion,
        "share": judgement.claim.share,
        "verdict": judgement.verdict,
        "checks": [asdict(check) | {"true": bool(check.true)} for check in judgement.checks],
        "published": [asdict(check) | {"true": bool(check.true)} for check in judgement.published],
    }
