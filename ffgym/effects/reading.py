"""Effects in TOML: [effects.<name>] tables, every parameter with its unit and where its value comes from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.toml import toml_key, toml_table
from ffgym.core.types import Array
from ffgym.effects.catalogue import EFFECTS
from ffgym.effects.effect import Effect
from ffgym.robot import RobotDescription


@dataclass(frozen=True, kw_only=True, eq=False)
class Origin:
    """Origin of the numbers of one effect, as its table in a file states it."""

    label: str = ""
    """Text behind the effect's name and a colon, e.g. the joint; may be empty."""
    sources: Mapping[str, str] = field(default_factory=dict)
    """Sources by parameter."""
    intervals: Mapping[str, Array] = field(default_factory=dict)
    """Lower and upper ends by parameter, shape (..., 2)."""


def read_origins(tables: Mapping[str, Any]) -> tuple[Origin, ...]:
    """Read the origins of the effects that `read_effects` reads from the same tables."""
    return tuple(
        Origin(
            label=name.partition(":")[2],
            sources={entry: given["source"] for entry, given in table.items() if "source" in given},
            intervals={entry: np.asarray(given["interval"]) for entry, given in table.items() if "interval" in given},
        )
        for name, table in tables.items()
    )


def read_effects(
    tables: Mapping[str, Any], robot: RobotDescription, known: Mapping[str, type[Effect]] = EFFECTS
) -> tuple[Effect, ...]:
    """Read effects from the tables [effects.<name>] of a file, e.g.

    .. code:: toml

        [effects.load_friction]
        share = { value = [0.06, 0.06, 0.06, 0.1, 0.1, 0.1], unit = "1", source = "identified" }

    One number stands for all joints. A name may be followed by a colon and anything, for a second effect of that name.

    Args:
        tables: entries below [effects].
        robot: the robot that has them.
        known: classes of effects by name.

    Raises:
        FFGymError: if an effect or parameter is unknown or missing, or a value has a wrong unit or shape.
    """
    effects = []
    for name, table in tables.items():
        kind = known[check_choice("effect", name.split(":")[0], list(known))]
        if not isinstance(table, dict):
            raise FFGymError(f"[effects.{name}] must be a table of parameters, got {table!r}.")
        its, values = kind.parameters(), {}
        for entry, given in table.items():
            check_choice(f"parameter of effects.{name}", entry, list(its))
            where = f"effects.{name}.{entry}"
            values[entry] = given_value(where, given, its[entry].unit, also=("interval",))
            if "interval" in given:
                ends = its[entry].numbers(f"effects.{name}", given["interval"])
                if ends.shape[-1:] != (2,) or np.any(ends[..., 0] > ends[..., 1]):
                    raise FFGymError(
                        f"{where}.interval = {given['interval']!r} must be lower and upper ends, shape (..., 2)."
                    )
        effects.append(kind.on(robot, **values))
    return tuple(effects)


def given_value(where: str, given: Any, unit: str, also: tuple[str, ...] = ()) -> Any:
    """Return the value of a table of value and unit, which may have a source and the entries `also`."""
    maybe = ("source", *also)
    if not isinstance(given, dict) or not {"value", "unit"} <= set(given) <= {"value", "unit", *maybe}:
        raise FFGymError(f"{where} = {given!r} must be a table of value, unit, and maybe {' and '.join(maybe)}.")
    if given["unit"] != unit:
        raise FFGymError(f"{where} has unit {given['unit']!r}, must be {unit!r}.")
    if not isinstance(given.get("source", ""), str):
        raise FFGymError(f"{where}.source = {given['source']!r} must be text.")
    return given["value"]


def effects_toml(effects: Sequence[Effect], source: str, origins: Sequence[Origin] = ()) -> str:
    """Write effects as TOML tables, which `read_effects` reads back to the bit.

    Args:
        effects: effects to write.
        source: source of all values without one in `origins`.
        origins: origins of the first effects.
    """
    used: set[str] = set()
    lines = []
    for i, effect in enumerate(effects):
        origin = origins[i] if i < len(origins) else Origin()
        entries: dict[str, Mapping[str, Any]] = {}
        for known in effect.parameters().values():
            entry = {"value": np.asarray(getattr(effect, known.name)), "unit": known.unit}
            entry |= {"interval": origin.intervals[known.name]} if known.name in origin.intervals else {}
            entries[known.name] = entry | {"source": origin.sources.get(known.name, source)}
        lines += [*toml_table(f"effects.{_title(effect.name, origin.label, used)}", entries), ""]
    return "\n".join(lines)


def _title(name: str, label: str, used: set[str]) -> str:
    """Return a name of a table that is not used yet, in quotes if it needs them."""
    first = title = f"{name}:{label}" if label else name
    count = 1
    while title in used:
        count += 1
        title = f"{first}:{count}"
    used.add(title)
    return toml_key(title)
