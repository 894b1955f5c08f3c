"""The table [rewire] of a column map: corrections of columns after they are read, as a fit of wiring finds them."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from ffgym.core.errors import FFGymError, check_number
from ffgym.recordings.rewiring import Rewire, Rewiring
from ffgym.recordings.schema import FAMILIES, closest

REWIRE_KEYS: Mapping[str, str] = MappingProxyType(
    {
        "source": "which of the columns of the family, from 0, holds the numbers of each joint or axis, one each",
        "factor": "by which they are multiplied, one each",
        "offset": "added after `factor`, in the unit that the recording keeps, one each",
        "delay": "by which they come late [s of the clock as it is in the file], one each; rows without a sample are "
        "dropped",
    }
)
"""What a table [rewire."..."] of a family may say; absent keys change nothing. `clock` in [rewire] multiplies all
times."""

_NEUTRAL = {"factor": 1.0, "offset": 0.0, "delay": 0.0}


def parse_rewiring(table: Any) -> Rewiring:
    """Corrections of the table [rewire].

    Raises:
        FFGymError: if an entry is unknown or invalid.
    """
    if not isinstance(table, dict):
        raise FFGymError(f"[rewire] must be a table, got {table!r}.")
    clock, families = 1.0, {}
    for name, entry in table.items():
        if name == "clock":
            clock = check_number("[rewire] clock", entry, low=0.0, open_low=True)
        elif name not in FAMILIES or FAMILIES[name].parts == "one":
            raise FFGymError(f"[rewire.{name!r}] is no family of columns. {closest(name, FAMILIES)}")
        else:
            families[name] = _rewire(f"[rewire.{name!r}]", entry)
    return Rewiring(families=families, clock=clock)


def rewiring_table(rewiring: Rewiring) -> dict[str, Any]:
    """The table [rewire] of corrections; what changes nothing stays away."""
    table: dict[str, Any] = {} if rewiring.clock == 1.0 else {"clock": rewiring.clock}
    for name, rewire in rewiring.families.items():
        if rewire.is_none:
            continue
        given, none = rewire, Rewire.none(len(rewire.source))
        keys = [key for key in REWIRE_KEYS if getattr(given, key) != getattr(none, key)]
        table[name] = {key: list(getattr(given, key)) for key in keys}
    return table


def _rewire(where: str, table: Any) -> Rewire:
    if not isinstance(table, dict) or not table:
        raise FFGymError(f"{where} must be a table with {', '.join(REWIRE_KEYS)}.")
    for key, entry in table.items():
        if key not in REWIRE_KEYS:
            raise FFGymError(f"Unknown key {key!r} in {where}. {closest(key, REWIRE_KEYS)}")
        if not isinstance(entry, list) or not entry:
            raise FFGymError(f"{where} {key} = {entry!r} must be a list with a number for each joint or axis.")
    (n, *others) = {len(entry) for entry in table.values()}
    if others:
        raise FFGymError(f"{where}: its lists must have one length, a number for each joint or axis.")
    source = table.get("source", list(range(n)))
    if not all(type(part) is int for part in source) or sorted(source) != list(range(n)):
        raise FFGymError(f"{where} source = {source} must hold each number from 0 to {n - 1} once.")
    numbers = {
        key: tuple(check_number(f"{where} {key}", number) for number in table.get(key, [neutral] * n))
        for key, neutral in _NEUTRAL.items()
    }
    if 0.0 in numbers["factor"]:
        raise FFGymError(f"{where} factor = {list(numbers['factor'])} must not be zero: nothing of them would be left.")
    return Rewire(source=tuple(source), **numbers)
