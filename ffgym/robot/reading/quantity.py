"""Numbers that carry unit, side of the gearbox and origin, and the rule that says which are valid."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array

OTHER_UNITS = {
    "rad": {"deg": np.pi / 180},
    "rad/s": {"deg/s": np.pi / 180},
    "m": {"mm": 1e-3},
    "m/s": {"mm/s": 1e-3},
    "kg m^2": {"kg cm^2": 1e-4},
}
"""Units that descriptions may use in place of SI, with the factor that converts them."""

MOTOR, LINK = "motor", "link"
SIDES = (MOTOR, LINK)
"""Side of a gearbox."""


@dataclass(frozen=True, kw_only=True)
class Rule:
    """Rule of one quantity of a description."""

    meaning: str
    """Meaning, in a few words."""
    shape: tuple[int | str, ...]
    """Wanted shape; 'N' stands for the number of joints."""
    unit: str
    """SI unit; on the link side, that of a hinge."""
    slide_unit: str | None = None
    """SI unit of a sliding joint, None if it is the same."""
    side: str | None = None
    """Side of the gearbox on which the quantity is kept, None where the question does not arise."""
    gear_power: int | None = None
    """p in: motor side = link side x |gear ratio|^p, for quantities that may be given on either side."""
    signed: bool = False
    """True if the quantity counts along the motion, so that the gear ratio's sign belongs to the conversion."""
    low: float = -np.inf
    """Smallest valid number."""
    open_low: bool = False
    """True if `low` itself is not valid."""
    nonzero: bool = False
    """True if 0 is not valid."""
    infinite: bool = False
    """True if +inf is valid (a rigid joint)."""
    optional: bool = False
    """True if a description may do without."""
    neutral: float | None = None
    """Number that an optional entry has where it is left out; None if it then is not known, or absent."""
    where: str = ""
    """Documents in which its numbers are found."""
    typical: str = ""
    """Usual size; empty if it would not help."""
    sliding: str = ""
    """The same for a sliding joint, where its unit is another."""

    def shape_for(self, n_joints: int) -> tuple[int, ...]:
        """Wanted shape for a number of joints."""
        return tuple(n_joints if s == "N" else int(s) for s in self.shape)


def si_units(rule: Rule, side: str | None, types: Sequence[str]) -> tuple[str, ...]:
    """Wanted SI units on a side for joints of these types: one, or one per joint where hinges and slides differ."""
    if rule.slide_unit is None or side == MOTOR or "N" not in rule.shape:
        return (rule.unit,)
    units = tuple(rule.slide_unit if kind == "slide" else rule.unit for kind in types)
    return units if len(set(units)) > 1 else units[:1]


def _unit_factors(path: str, unit: object, rule: Rule, side: str | None, types: Sequence[str]) -> Array:
    """Factors that convert to SI: one number, or one per joint, shaped to multiply the value."""
    wanted = si_units(rule, side, types)
    if isinstance(unit, list) and "N" in rule.shape and len(unit) == len(types):
        wanted = wanted if len(wanted) > 1 else wanted * len(types)
        factors = [_factor(have, want) for have, want in zip(unit, wanted, strict=True)]
    else:
        factors = [_factor(unit, wanted[0]) if len(wanted) == 1 else None]
    if None in factors:
        choices = " or ".join(repr(other) for other in (wanted[0], *OTHER_UNITS.get(wanted[0], {})))
        choices = choices if len(wanted) == 1 else f"one per joint, {list(wanted)}"
        raise FFGymError(f"{path}: unit is {unit!r}, must be {choices}.")
    return _per_joint(np.array(factors, dtype=np.float64), rule)


def _gear_factors(path: str, rule: Rule, side: str | None, gear_ratio: Array | None) -> Array | float:
    """Factors that bring a quantity from the side it is given on to the one it is kept on."""
    if side == rule.side:
        return 1.0
    if rule.gear_power is None or side not in (MOTOR, LINK):
        valid = repr(rule.side) if rule.gear_power is None else f"{MOTOR!r} or {LINK!r}"
        raise FFGymError(f"{path}: side is {side!r}, must be {valid}.")
    if gear_ratio is None:
        raise FFGymError(f"{path}: side is {side!r}; to bring it to the {rule.side} side takes drive.gear_ratio.")
    power = rule.gear_power if rule.side == MOTOR else -rule.gear_power
    ratio = gear_ratio if rule.signed else np.abs(gear_ratio)
    return _per_joint(ratio ** float(power), rule)


def _factor(unit: object, wanted: str) -> float | None:
    if unit == wanted:
        return 1.0
    return OTHER_UNITS.get(wanted, {}).get(unit) if isinstance(unit, str) else None


def _per_joint(factors: Array, rule: Rule) -> Array:
    """Factors (1,) or (N,) in a shape that multiplies a value of shape (N, ...)."""
    return factors.reshape(-1, *[1] * (len(rule.shape) - 1)) if len(factors) > 1 else factors.reshape(())


ORIGINS = ("sourced", "derived", "chosen", "fitted")
"""Origin of a number; `fitted` is written by a script or an identification, which keeps the number it
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
    """Source of the replaced numbers."""
    interval: Array | None = None
    """Lower and upper end of where a fit puts each number, shape (..., 2), 0 and inf where it says nothing; None if it
    says nothing at all."""


def parse_quantity(
    path: str, table: Any, rule: Rule, types: Sequence[str], gear_ratio: Array | None = None
) -> Quantity:
    """Check one table of a description against its rule; convert it to SI and to the side on which it is kept.

    Args:
        path: where the table stands, e.g. 'drive.gear_ratio', for messages.
        table: the parsed TOML table with `value`, `unit`, `origin`, `source` and maybe `side`, `prior`, `interval`.
        rule: what is wanted.
        types: 'hinge' or 'slide', one per joint.
        gear_ratio: motor over joint motion, shape (N,); None while it is not known.
    """
    if not isinstance(table, Mapping):
        raise FFGymError(f"{path} must be a table with value, unit, origin and source, got {table!r}.")
    unknown = sorted(set(table) - {"value", "unit", "side", "origin", "source", "prior", "prior_source", "interval"})
    missing = sorted({"value", "unit", "origin", "source"} - set(table))
    if unknown or missing:
        raise FFGymError(
            f"{path} lacks {missing} and has unknown keys {unknown}; it needs value, unit, origin, source."
        )
    # factors to SI units and to the side of the gearbox on which the number is kept
    side, shape = table.get("side"), rule.shape_for(len(types))
    factors = _gear_factors(path, rule, side, gear_ratio) * _unit_factors(path, table["unit"], rule, side, types)
    # origin by joint; a fitted number also tells what it was before
    origin = tuple(table["origin"]) if isinstance(table["origin"], list) else (table["origin"],)
    if len(origin) not in (1, len(types)) or any(o not in ORIGINS for o in origin):
        raise FFGymError(f"{path}: origin is {table['origin']!r}, must be one of {ORIGINS}, once or once per joint.")
    fitted = "fitted" in origin
    if fitted != ("prior" in table) or fitted != ("prior_source" in table):
        raise FFGymError(f"{path}: prior and prior_source belong to origin 'fitted', and to no other, got {origin}.")
    if "interval" in table and not fitted:
        raise FFGymError(f"{path}: interval belongs to origin 'fitted', and to no other, got {origin}.")
    value = _check_value(path, table["value"], rule, shape, factors)
    for key in ("source", "prior_source") if fitted else ("source",):
        if not isinstance(table[key], str) or not table[key].strip():
            raise FFGymError(f"{path}: {key} is {table[key]!r}, must say where the number comes from.")
    # interval of a fitted number, in the same units
    ends = None
    if "interval" in table:
        ends = _numbers(f"{path}.interval", table["interval"], (*shape, 2), infinite=True) * factors[..., None]
        if np.any(ends[..., 0] > ends[..., 1]):
            raise FFGymError(f"{path}.interval = {table['interval']} must have its lower ends first.")
        ends.flags.writeable = False
    return Quantity(
        value=value,
        unit=", ".join(si_units(rule, rule.side, types)),
        side=rule.side,
        origin=origin,
        source=table["source"],
        prior=_check_value(path + ".prior", table["prior"], rule, shape, factors) if fitted else None,
        prior_source=table["prior_source"] if fitted else None,
        interval=ends,
    )


def _numbers(path: str, value: Any, shape: tuple[int, ...], *, infinite: bool) -> Array:
    """Array of nested lists of numbers, finite unless `infinite`."""
    if not _only_numbers(value):
        raise FFGymError(f"{path} must be numbers, got {value!r}.")
    return check_shape(path, value, shape, infinite=infinite)


def _check_value(path: str, value: Any, rule: Rule, shape: tuple[int, ...], factors: Array) -> Array:
    """Check numbers and convert them to SI units, read-only."""
    array = _numbers(path, value, shape, infinite=rule.infinite)
    _check_bounds(path, array, rule)
    array *= factors
    array.flags.writeable = False
    return array


def check_numbers(path: str, value: Any, rule: Rule, n_joints: int) -> Array:
    """Return numbers of an entry that are in SI units, on the side where they are kept, as a read-only array.

    Raises:
        FFGymError: if they are not as the rule says.
    """
    array = check_shape(path, value, rule.shape_for(n_joints), infinite=rule.infinite)
    _check_bounds(path, array, rule)
    if array.flags.writeable:
        array = array.copy()
        array.flags.writeable = False
    return array


def _check_bounds(path: str, array: Array, rule: Rule) -> None:
    smallest = array.min(initial=np.inf)
    if smallest < rule.low or (rule.open_low and smallest == rule.low):
        sign, each = ">" if rule.open_low else ">=", " on every joint" if "N" in rule.shape else ""
        out = "" if rule.neutral is None else f"; {rule.neutral:g} leaves it out"
        raise FFGymError(f"{path} = {array.tolist()} must be {sign} {rule.low} {rule.unit}{each}{out}.")
    if rule.nonzero and np.any(array == 0):
        raise FFGymError(f"{path} = {array.tolist()} must not be 0.")


def _only_numbers(value: Any) -> bool:
    """Tell if nested lists hold numbers alone; NumPy would take the text '1' for one."""
    if isinstance(value, list):
        return all(_only_numbers(entry) for entry in value)
    return isinstance(value, int | float) and not isinstance(value, bool)
