"""Entries of a description as TOML text."""

import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.robot.reading.rule import LINK, JointFrame, Rule, si_units
from ffgym.robot.template.proposals import Proposal

MARK = "#? "
"""Begins the lines of an entry that waits for numbers; without it they are TOML."""
_DIGITS = 5
"""Of proposed numbers per joint; rules of thumb deserve no more. Single numbers are times, which must fit exactly."""


def text(value: str) -> str:
    """A string in quotes; JSON's are TOML's, but for a control character that JSON leaves as it is."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def names(values: Sequence[str]) -> str:
    """A list of strings."""
    return f"[{', '.join(map(text, values))}]"


def filled_entry(proposal: Proposal, rule: Rule, types: tuple[str, ...]) -> list[str]:
    """Lines of an entry with its numbers."""
    return _entry(
        proposal.path,
        _numbers(proposal.value),
        _unit(rule, proposal.side, types),
        proposal.side,
        proposal.origin,
        text(proposal.source),
    )


def empty_entry(path: str, rule: Rule, types: tuple[str, ...]) -> list[str]:
    """Lines of an entry that waits for numbers."""
    shape = tuple(len(types) if s == "N" else int(s) for s in rule.shape)
    unit = _unit(rule, rule.side, types)
    if rule.side == LINK and rule.gear_power is None:  # angles of joints are read in degrees
        unit = unit.replace('"rad', '"deg')
    lines = _entry(path, _numbers(np.full(shape, np.nan)), unit, rule.side, "sourced", '"?"')
    return [MARK + line for line in lines]


def marked(lines: list[str]) -> list[str]:
    """The same lines, waiting for numbers."""
    return [MARK + line for line in lines]


def _entry(path: str, value: str, unit: str, side: str | None, origin: str, source: str) -> list[str]:
    sides = [] if side is None else [f"side = {text(side)}"]
    return [f"[{path}]", f"value = {value}", f"unit = {unit}", *sides, f"origin = {text(origin)}", f"source = {source}"]


def _unit(rule: Rule, side: str | None, types: tuple[str, ...]) -> str:
    units = si_units(rule, side, JointFrame(types=types))
    return text(units[0]) if len(units) == 1 else names(units)


def _numbers(value: Array) -> str:
    """Numbers to five digits, times with all, NaN as a question mark."""
    return _nested(value.tolist()) if value.ndim or np.isnan(value) else repr(float(value))


def _nested(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_nested, value))}]"
    if np.isnan(value):
        return "?"
    if np.isinf(value):
        return "inf"
    return repr(float(f"{value:.{_DIGITS}g}"))
