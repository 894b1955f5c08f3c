"""One entry of a column map: where the numbers of a family of columns are in a file, and what they mean there."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole, errors_at
from ffgym.logs.keys import check_table
from ffgym.robot.reading.quantity import OTHER_UNITS

Resample = Literal["", "gaps", "linear", "hold"]

MOST_BITS = 32
"""Bits of a counter; whole numbers of more bits do not fit a float64 in files of text."""

AXES = ("motion", "time", "part")
"""Meanings that an axis of an array may have."""

_TURN = 2 * np.pi
_MINUTE = 60.0

UNITS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "s": {"min": _MINUTE, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
        "rad": OTHER_UNITS["rad"] | {"mrad": 1e-3, "arcmin": np.pi / (180 * 60), "turn": _TURN},
        "rad/s": OTHER_UNITS["rad/s"] | {"mrad/s": 1e-3, "turn/s": _TURN, "rpm": _TURN / _MINUTE},
        "rad/s^2": {"deg/s^2": np.pi / 180, "turn/s^2": _TURN, "rpm/s": _TURN / _MINUTE},
        "m": OTHER_UNITS["m"] | {"um": 1e-6, "cm": 1e-2},
        "m/s": OTHER_UNITS["m/s"],
        "m/s^2": {"mm/s^2": 1e-3},
        "N m": {"mN m": 1e-3, "N cm": 1e-2, "kN m": 1e3},
        "N": {"mN": 1e-3, "kN": 1e3},
        "degC": {"K": 1.0},
        "1": {"%": 1e-2},
    }
)
"""SI unit -> other units of the same quantity, with the factor that converts them."""

COUNTS = MappingProxyType({"count": "rad", "count/s": "rad/s", "count/s^2": "rad/s^2"})
"""Units of an encoder, which `counts_per_turn` makes angles."""

_SHIFTS = {"K": -273.15}
"""Offsets that are added after the factor: 0 degC is 273.15 K, by definition."""

DRIVING = ("A", "mA", "V", "mV", "%")
"""Units of what drives a motor, or of its share of a rated torque, which a scale makes torques."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MappedColumn:
    """One family or column of a recording; the fields are the keys [columns] of keys.toml."""

    source: str | tuple[str, ...] = ""
    otherwise: tuple[str, ...] = ()
    unit: str | tuple[str, ...] = ""
    axes: tuple[str, ...] | None = None
    pick: tuple[int, ...] | None = None
    twos_complement: int | None = None
    times: str = ""
    scale: float | tuple[float, ...] | str = 1.0
    offset: float | tuple[float, ...] | str = 0.0
    sign: float | tuple[float, ...] = 1.0
    side: str = ""
    counts_per_turn: float | None = None
    clock: str = ""
    clock_unit: str = ""
    resample: Resample = ""
    rate_hz: float | str | None = None
    from_first: bool = False
    parts: tuple[str, ...] = ()
    optional: bool = False

    def __post_init__(self) -> None:
        if bool(self.source) == (self.rate_hz is not None):
            raise FFGymError("source says which array holds the numbers; it is missing, or stands beside rate_hz.")
        if self.source and not self.unit:
            raise FFGymError("unit is missing: it says what the numbers of the file are in, e.g. 'deg' or 'N m'.")
        if self.otherwise and not isinstance(self.source, str):
            raise FFGymError("otherwise goes with a source that is one name, not a list.")
        if self.axes is not None:
            for axis in self.axes:
                check_choice("axes entry", axis, AXES)
            if "time" not in self.axes or len(set(self.axes)) < len(self.axes):
                raise FFGymError(
                    f"axes = {list(self.axes)} must hold 'time', and each of {', '.join(AXES)} at most once."
                )
        if np.any(np.abs(self.sign) != 1):
            raise FFGymError(f"sign = {self.sign} must be 1 or -1, or a list of them; other factors are a scale.")
        if self.side:
            check_choice("side", self.side, ("motor", "link"))
        if self.resample:
            check_choice("resample", self.resample, ("gaps", "linear", "hold"))
        if self.pick is not None and any(index < 0 for index in self.pick):
            raise FFGymError(f"pick = {list(self.pick)} must be numbers of parts, counted from 0.")
        if (self.clock or self.clock_unit) and not self.resample:
            raise FFGymError("clock needs resample = 'gaps', 'linear' or 'hold': what becomes of samples between rows.")

    @property
    def is_scaled(self) -> bool:
        """Tell whether numbers are more than converted from their unit."""
        plain = (self.scale, self.offset, self.sign) == (1.0, 0.0, 1.0)
        return not plain or self.twos_complement is not None or bool(self.times)


def parse_column(table: Any, where: str) -> MappedColumn:
    """Column of a TOML table that messages call `where`."""
    entries = check_table(table, "columns", where)
    with errors_at(where):
        return MappedColumn(**{key: _READERS[key](key, value) for key, value in entries.items()})


def _text(key: str, value: Any) -> str:
    if not isinstance(value, str) or not value:
        raise FFGymError(f"{key} = {value!r} must be text.")
    return value


def _texts(key: str, value: Any) -> tuple[str, ...]:
    if not isinstance(value, list) or not value:
        raise FFGymError(f"{key} = {value!r} must be a list of text.")
    return tuple(_text(f"{key} entry", entry) for entry in value)


def _one_or_texts(key: str, value: Any) -> str | tuple[str, ...]:
    return _texts(key, value) if isinstance(value, list) else _text(key, value)


def _numbers(key: str, value: Any) -> float | tuple[float, ...]:
    if isinstance(value, list) and value:
        return tuple(check_number(f"{key} entry", entry) for entry in value)
    return check_number(key, value)


def _numbers_or_name(key: str, value: Any) -> float | tuple[float, ...] | str:
    return _text(key, value) if isinstance(value, str) else _numbers(key, value)


def _rate(key: str, value: Any) -> float | str:
    return _text(key, value) if isinstance(value, str) else check_number(key, value, unit="Hz", low=0.0, open_low=True)


def _indices(key: str, value: Any) -> tuple[int, ...]:
    if not isinstance(value, list) or not value or not all(type(entry) is int for entry in value):
        raise FFGymError(f"{key} = {value!r} must be a list of whole numbers.")
    return tuple(value)


def check_truth(key: str, value: Any) -> bool:
    """Return `value` if it is true or false."""
    if not isinstance(value, bool):
        raise FFGymError(f"{key} = {value!r} must be true or false.")
    return value


_READERS: Mapping[str, Callable[[str, Any], Any]] = {
    **dict.fromkeys(("times", "side", "clock", "clock_unit", "resample"), _text),
    **dict.fromkeys(("otherwise", "axes", "parts"), _texts),
    **dict.fromkeys(("source", "unit"), _one_or_texts),
    **dict.fromkeys(("scale", "offset"), _numbers_or_name),
    **dict.fromkeys(("from_first", "optional"), check_truth),
    "sign": _numbers,
    "pick": _indices,
    "rate_hz": _rate,
    "counts_per_turn": check_number,
    "twos_complement": partial(check_whole, low=2, high=MOST_BITS),
}
"""Key -> function that checks its value and makes it that of a field."""


class Conversion(NamedTuple):
    """SI = factor * value + shift."""

    factor: float
    shift: float = 0.0


def conversion(unit: str, wanted: str, counts_per_turn: float | None = None) -> Conversion:
    """Find the conversion of numbers in `unit` to the SI unit `wanted`."""
    if unit in COUNTS and COUNTS[unit] == wanted:
        if counts_per_turn is None:
            raise FFGymError(f"unit {unit!r} needs counts_per_turn: encoder counts per turn of the encoder's shaft.")
        turn = check_number("counts_per_turn", counts_per_turn, low=0.0, open_low=True)
        return Conversion(_TURN / turn)
    if counts_per_turn is not None:
        raise FFGymError(f"counts_per_turn belongs to unit 'count' of an angle, not to {unit!r} for [{wanted}].")
    if unit == wanted:
        return Conversion(1.0)
    if unit not in UNITS.get(wanted, {}):
        counts = [count for count, angle in COUNTS.items() if angle == wanted]
        way_out = f"must be {', '.join(map(repr, [wanted, *UNITS.get(wanted, {}), *counts]))}."
        if unit in DRIVING and wanted in ("N m", "N"):
            way_out = f"give scale = <{wanted}/{unit}> and unit = {wanted!r}."
        raise FFGymError(f"unit {unit!r} does not fit a quantity in {wanted}, {way_out}")
    return Conversion(UNITS[wanted][unit], _SHIFTS.get(unit, 0.0))


def si_of(unit: str, counts_per_turn: float | None = None) -> str:
    """SI unit that a column of the user's own is kept in: that of `unit`, or `unit` itself if it is not known."""
    if unit in COUNTS and counts_per_turn is not None:
        return COUNTS[unit]
    return next((si for si, others in UNITS.items() if unit in others), unit)
