"""A number that carries its unit, its side of the gearbox and where it comes from."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.robot.reading.rule import JointFrame, Rule, gear_factors, si_units, unit_factors

ORIGINS = ("sourced", "derived", "chosen", "fitted")
"""How a number came to be; `fitted` is written by a script or an identification, which keeps the number it
replaced in `prior`, and may say in `interval` how sure it is."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Quantity:
    """One entry of a robot description, in SI units."""

    value: Array
    """The numbers, any shape, converted to SI."""
    unit: str
    """SI unit as text, e.g. 'N m/rad'; one per joint, with commas, where hinges and sliding joints differ."""
    side: str | None
    """'motor' or 'link' side of the gearbox, None where the question does not arise."""
    origin: tuple[str, ...]
    """One of ORIGINS, for the whole entry or per joint."""
    source: str
    """Publication, derivation or reason."""
    prior: Array | None = None
    """The numbers that a fit replaced, None if nothing was fitted."""
    prior_source: str | None = None
    """Where those came from."""
    interval: Array | None = None
    """Lower and upper end of where a fit puts each number, shape (..., 2), 0 and inf where it says nothing; None if it
    says nothing at all."""


def parse_quantity(path: str, table: Any, rule: Rule, joints: JointFrame) -> Quantity:
    """Check one table of a description against its rule; convert it to SI and to the side on which it is kept.

    Args:
        path: where the table stands, e.g. 'drive.gear_ratio', for messages.
        table: the parsed TOML table with `value`, `unit`, `origin`, `source` and maybe `side`, `prior`, `interval`.
        rule: what is wanted.
        joints: their types, and gear ratios if they are known.

    Raises:
        FFGymError: if anything is missing or invalid; the message names `path`.
    """
    if not isinstance(table, Mapping):
        raise FFGymError(f"{path} must be a table with value, unit, origin and source, got {table!r}.")
    unknown = sorted(set(table) - {"value", "unit", "side", "origin", "source", "prior", "prior_source", "interval"})
    missing = sorted({"value", "unit", "origin", "source"} - set(table))
    if unknown or missing:
        raise FFGymError(
            f"{path} lacks {missing} and has unknown keys {unknown}; it needs value, unit, origin, source."
        )
    side = table.get("side")
    factors = gear_factors(path, rule, side, joints) * unit_factors(path, table["unit"], rule, side, joints)
    origin = _origins(path, table["origin"], joints.n_joints)
    fitted = "fitted" in origin
    if fitted != ("prior" in table) or fitted != ("prior_source" in table):
        raise FFGymError(f"{path}: prior and prior_source belong to origin 'fitted', and to no other, got {origin}.")
    if "interval" in table and not fitted:
        raise FFGymError(f"{path}: interval belongs to origin 'fitted', and to no other, got {origin}.")
    return Quantity(
        value=_checked_value(path, table["value"], rule, joints.n_joints, factors),
        unit=", ".join(si_units(rule, rule.side, joints)),
        side=rule.side,
        origin=origin,
        source=_text(path, "source", table["source"]),
        prior=_checked_value(path + ".prior", table["prior"], rule, joints.n_joints, factors) if fitted else None,
        prior_source=_text(path, "prior_source", table["prior_source"]) if fitted else None,
        interval=_interval(path, table["interval"], rule, joints.n_joints, factors) if "interval" in table else None,
    )


def _interval(path: str, value: Any, rule: Rule, n_joints: int, factors: Array | float) -> Array:
    """Intervals in SI units, read-only, shape (..., 2)."""
    shape = (*(n_joints if s == "N" else int(s) for s in rule.shape), 2)
    if not _only_numbers(value):
        raise FFGymError(f"{path}.interval must be numbers, got {value!r}.")
    check_shape(f"{path}.interval", _without_infinity(value), shape)
    ends = np.array(value, dtype=np.float64) * np.asarray(factors)[..., None]
    if np.any(ends[..., 0] > ends[..., 1]):
        raise FFGymError(f"{path}.interval = {value} must have its lower ends first.")
    ends.flags.writeable = False
    return ends


def _checked_value(path: str, value: Any, rule: Rule, n_joints: int, factors: Array | float) -> Array:
    """Numbers in SI units, read-only."""
    shape = tuple(n_joints if s == "N" else int(s) for s in rule.shape)
    if not _only_numbers(value):
        raise FFGymError(f"{path} must be numbers, got {value!r}.")
    check_shape(path, _without_infinity(value) if rule.infinite else value, shape)
    array = np.array(value, dtype=np.float64)
    if np.any(array < rule.low) or (rule.open_low and np.any(array == rule.low)):
        raise FFGymError(f"{path} = {array.tolist()} must be {'>' if rule.open_low else '>='} {rule.low} {rule.unit}.")
    if rule.nonzero and np.any(array == 0):
        raise FFGymError(f"{path} = {array.tolist()} must not be 0.")
    array *= factors
    array.flags.writeable = False
    return array


def _only_numbers(value: Any) -> bool:
    """Whether nested lists hold nothing but numbers; NumPy would take the text '1' for one."""
    if isinstance(value, list):
        return all(_only_numbers(entry) for entry in value)
    return isinstance(value, int | float) and not isinstance(value, bool)


def _without_infinity(value: Any) -> Any:
    """Nested lists of numbers with +inf replaced by 0, for a check that allows it."""
    if isinstance(value, list):
        return [_without_infinity(entry) for entry in value]
    return 0.0 if value == np.inf else value


def _origins(path: str, origin: Any, n_joints: int) -> tuple[str, ...]:
    origins = tuple(origin) if isinstance(origin, list) else (origin,)
    if len(origins) not in (1, n_joints) or any(o not in ORIGINS for o in origins):
        raise FFGymError(f"{path}: origin is {origin!r}, must be one of {ORIGINS}, once or once per joint.")
    return origins


def _text(path: str, key: str, source: Any) -> str:
    if not isinstance(source, str) or not source.strip():
        raise FFGymError(f"{path}: {key} is {source!r}, must say where the number comes from.")
    return source
