"""Rules of robot descriptions: required and optional entries, and capabilities that need them; from `rules.toml`."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from importlib import resources
from types import MappingProxyType
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.robot.reading.quantity import Rule, check_numbers


@dataclass(frozen=True, kw_only=True)
class Capability:
    """A function of the library, or a group of them."""

    name: str
    """Name in code and JSON."""
    title: str
    """Description of the capability, in words."""
    needs: tuple[str, ...]
    """Entries of the description without which it does not work; POSITIONS stands for one named point or more."""


def _rule(fields: Mapping[str, Any]) -> Rule:
    return Rule(**{**fields, "shape": tuple(fields.get("shape", ()))})


_TABLES = tomllib.loads((resources.files(__package__) / "rules.toml").read_text(encoding="utf-8"))

RULES: Mapping[str, Rule] = MappingProxyType(
    {f"{group}.{name}": _rule(rule) for group, rules in _TABLES["entry"].items() for name, rule in rules.items()}
)
"""Rules of entries; optional entries may be left out."""


_IN_PYTHON = {**RULES, "servo.position_gain": replace(RULES["servo.position_gain"], open_low=False)}
"""Rules of descriptions that are made in Python, whose motors may have no servo."""


def check_part(table: str, part: Any, n_joints: int) -> None:
    """Check the numbers of a part of a description by the rules of a table of its file; its arrays become read-only.

    Raises:
        FFGymError: if one is not valid; one that is None by default may be None.
    """
    for field in fields(part):
        path, value = f"{table}.{field.name}", getattr(part, field.name)
        if path in RULES and not (value is None and field.default is None):
            array = check_numbers(path, value, _IN_PYTHON[path], n_joints)
            if array.ndim:
                object.__setattr__(part, field.name, array)


REQUIRED = tuple(path for path, rule in RULES.items() if not rule.optional)
"""Entries without which a robot is not complete."""

POINT = _rule(_TABLES["point"])
"""A named point of the work area."""

POSITIONS = "work_area.positions"
"""Table of named points."""

SPRING_RULES: Mapping[str, Rule] = MappingProxyType({name: _rule(rule) for name, rule in _TABLES["spring"].items()})
"""Rules of a table [springs.<name>], beside the names of the bodies that it joins."""

_GROUPS: Mapping[str, tuple[str, ...]] = {**_TABLES["groups"], "complete": REQUIRED}

CAPABILITIES: tuple[Capability, ...] = tuple(
    Capability(
        name=name,
        title=table["title"],
        needs=tuple(path for need in table["needs"] for path in _GROUPS.get(need, (need,))),
    )
    for name, table in _TABLES["capability"].items()
)
"""Capabilities, from the fewest needs to the most."""


def capability(name: str) -> Capability:
    """Find the capability of that name."""
    for entry in CAPABILITIES:
        if entry.name == name:
            return entry
    raise FFGymError(f"Unknown capability {name!r}. Available: {', '.join(entry.name for entry in CAPABILITIES)}.")


def list_capabilities_needing(path: str) -> tuple[Capability, ...]:
    """List capabilities that do not work without an entry."""
    return tuple(entry for entry in CAPABILITIES if path in entry.needs)
