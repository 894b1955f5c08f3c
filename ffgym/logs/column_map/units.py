"""Units that files of other tools come in, and how each becomes the SI unit of a recording."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ffgym.core.errors import FFGymError, check_number
from ffgym.robot.reading.quantity import OTHER_UNITS

_TURN = 2 * np.pi
_MINUTE = 60.0

_TIMES = {"min": _MINUTE, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_ANGLES = OTHER_UNITS["rad"] | {"mrad": 1e-3, "arcmin": np.pi / (180 * 60), "turn": _TURN}
_SPEEDS = OTHER_UNITS["rad/s"] | {"mrad/s": 1e-3, "turn/s": _TURN, "rpm": _TURN / _MINUTE}
_ACCELERATIONS = {"deg/s^2": np.pi / 180, "turn/s^2": _TURN, "rpm/s": _TURN / _MINUTE}

UNITS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "s": _TIMES,
        "rad": _ANGLES,
        "rad/s": _SPEEDS,
        "rad/s^2": _ACCELERATIONS,
        "m": OTHER_UNITS["m"] | {"um": 1e-6, "cm": 1e-2},
        "m/s": OTHER_UNITS["m/s"],
        "m/s^2": {"mm/s^2": 1e-3},
        "N m": {"mN m": 1e-3, "N cm": 1e-2, "kN m": 1e3},
        "N": {"mN": 1e-3, "kN": 1e3},
        "degC": {},
        "1": {"%": 1e-2},
    }
)
"""SI unit -> other units of the same quantity, with the factor that converts them."""

COUNTS = MappingProxyType({"count": "rad", "count/s": "rad/s", "count/s^2": "rad/s^2"})
"""Units of an encoder, which `counts_per_turn` makes angles."""

KELVIN, ZERO_CELSIUS = "K", 273.15
"""0 degC is 273.15 K, by definition."""

_TO_TORQUE = {unit: f"N m/{unit}" for unit in ("A", "mA", "V", "mV", "%")}
"""Units of what drives a motor, or of its share of a rated torque, and of the factor that makes it a torque."""


class Conversion(NamedTuple):
    """SI = factor * value + shift."""

    factor: float
    shift: float = 0.0


def conversion(unit: str, wanted: str, counts_per_turn: float | None = None) -> Conversion:
    """How numbers in `unit` become the SI unit `wanted`.

    Raises:
        FFGymError: if `unit` does not measure the same quantity, or counts come without their number per turn.
    """
    if unit in COUNTS and COUNTS[unit] == wanted:
        if counts_per_turn is None:
            raise FFGymError(f"unit {unit!r} needs counts_per_turn: encoder counts per turn of the encoder's shaft.")
        turn = check_number("counts_per_turn", counts_per_turn, low=0.0, open_low=True)
        return Conversion(_TURN / turn)
    if counts_per_turn is not None:
        raise FFGymError(f"counts_per_turn belongs to unit 'count' of an angle, not to {unit!r} for [{wanted}].")
    if unit == KELVIN and wanted == "degC":
        return Conversion(1.0, -ZERO_CELSIUS)
    if unit == wanted:
        return Conversion(1.0)
    if unit not in UNITS.get(wanted, {}):
        raise FFGymError(f"unit {unit!r} does not fit a quantity in {wanted}, {_way_out(unit, wanted)}")
    return Conversion(UNITS[wanted][unit])


def si_of(unit: str, counts_per_turn: float | None = None) -> str:
    """SI unit that a column of the user's own is kept in: that of `unit`, or `unit` itself if it is not known."""
    if unit in COUNTS and counts_per_turn is not None:
        return COUNTS[unit]
    if unit == KELVIN:
        return "degC"
    return next((si for si, others in UNITS.items() if unit in others), unit)


def _way_out(unit: str, wanted: str) -> str:
    if unit in _TO_TORQUE and wanted in ("N m", "N"):
        return f"give scale = <{_TO_TORQUE[unit].replace('N m', wanted)}> and unit = {wanted!r}."
    counts = [count for count, angle in COUNTS.items() if angle == wanted]
    kelvin = [KELVIN] if wanted == "degC" else []
    return f"must be {', '.join(map(repr, [wanted, *UNITS.get(wanted, {}), *counts, *kelvin]))}."
