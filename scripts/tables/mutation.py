"""Scores of mutation testing: docs/mutation.md, from the outcomes that `scripts.mutation` made before."""

import json
from collections import Counter
from pathlib import Path

from ffgym.core.files import read_text
from scripts.mutation.rooms import ROOMS
from scripts.mutation.score import Score, read_score
from scripts.tables.page import DOCS, Contents, markdown

OUTCOMES = DOCS / "records" / "mutation.json"
"""Every mutant that was tested, with versions and seeds."""


def scores(file: Path = OUTCOMES) -> Contents:
    """Count what tests noticed in each room, and list what they did not."""
    kept = json.loads(read_text(file))
    rooms = [read_score(row) for row in kept["rooms"]]
    rows = []
    for score in rooms:
        low, high = score.interval()
        code = ", ".join(f"`{place}`" for place in ROOMS[score.room].code)
        tested, share = f"{len(score.outcomes)} of {score.n_mutants}", f"{100 * score.share:.0f} %"
        interval = f"{100 * low:.0f} to {100 * high:.0f} %"
        rows.append((score.room, code, str(score.seed), tested, str(score.n_killed), share, interval))
    unmeasured = [name for name in ROOMS if name not in {score.room for score in rooms}]
    missing = f" Not measured yet: {', '.join(unmeasured)}." if unmeasured else ""
    versions = ", ".join(f"{name} {version}" for name, version in kept["versions"].items())
    table = markdown(("room", "code", "seed", "mutants tested", "noticed", "score", "95 % interval"), rows)
    survived = [_survivor(score, i) for score in rooms for i, each in enumerate(score.outcomes) if not each.is_killed]
    return Contents(
        parts={
            "scores": f"{table}\n\nBy {versions}.{missing}",
            "survivors": markdown(("place", "change", "line"), survived),
            "operators": markdown(("change", "tested", "noticed"), _by_operator(rooms)),
        },
        numbers={score.room: {"tested": len(score.outcomes), "noticed": score.n_killed} for score in rooms},
    )


def _survivor(score: Score, i: int) -> tuple[str, str, str]:
    """Place, operator and line of a mutant that no test noticed."""
    mutant = score.outcomes[i].mutant
    text = mutant.text.replace("|", "\\|")
    return f"`{Path(mutant.module).name}`", _words(mutant.operator), f"`{text}`"


def _by_operator(rooms: list[Score]) -> list[tuple[str, str, str]]:
    """Number of mutants of each operator that were tested, and that tests noticed."""
    outcomes = [outcome for score in rooms for outcome in score.outcomes]
    tested = Counter(_words(outcome.mutant.operator) for outcome in outcomes)
    noticed = Counter(_words(outcome.mutant.operator) for outcome in outcomes if outcome.is_killed)
    return [(words, str(count), str(noticed[words])) for words, count in tested.most_common()]


_SIGNS = {
    **{"Add": "+", "Sub": "-", "Mul": "*", "Div": "/", "Pow": "**", "FloorDiv": "//", "Mod": "%"},
    **{"USub": "-", "Not": "not", "Invert": "~", "Is": "is", "IsNot": "is not"},
    **{"Lt": "<", "LtE": "<=", "Gt": ">", "GtE": ">=", "Eq": "==", "NotEq": "!="},
}
_OTHERS = {
    "AddNot": "not before a condition",
    "ReplaceAndWithOr": "`and` to `or`",
    "ReplaceOrWithAnd": "`or` to `and`",
    "ReplaceTrueWithFalse": "`True` to `False`",
    "ReplaceFalseWithTrue": "`False` to `True`",
    "NumberReplacer": "a number by 1",
    "ZeroIterationForLoop": "a loop over nothing",
}


def _words(operator: str) -> str:
    """Operator of cosmic-ray in words."""
    if operator in _OTHERS:
        return _OTHERS[operator]
    old, new = operator.split("_")[1:]
    return f"without `{_SIGNS[new]}`" if old == "Delete" else f"`{_SIGNS[old]}` to `{_SIGNS[new]}`"
