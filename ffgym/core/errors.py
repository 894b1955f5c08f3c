"""One exception for all mistakes of a caller, and the checks that raise it."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from ffgym.core.types import Array

LONGEST = 2000
"""Characters of the longest message: values of damaged files have any length, and who reads the message has not."""


class FFGymError(ValueError):
    """A request that cannot be met; the message names the thing, its value, what is valid and the way out."""

    def __init__(self, message: str = "") -> None:
        """Keep the message; of one that is too long the beginning and the end."""
        half = LONGEST // 2 - 2
        super().__init__(message if len(message) <= LONGEST else f"{message[:half]} … {message[-half:]}")


@contextmanager
def errors_at(where: str) -> Iterator[None]:
    """Prefix errors of a block with a place, unless it is empty or they have it already."""
    try:
        yield
    except FFGymError as error:
        raise error if str(error).startswith(where) else FFGymError(f"{where}: {error}") from error


def check_shape(name: str, value: Any, shape: Sequence[int | None], *, infinite: bool = False) -> Array:
    """Return `value` as a float64 array of `shape`, where None stands for any length; finite, or +inf if `infinite`."""
    try:
        if np.asarray(value).dtype.kind in "USc":
            raise TypeError("text and complex numbers are not numbers")
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise FFGymError(f"{name} must be numbers, got {' '.join(repr(value).split())}.") from error
    if np.ma.is_masked(value):
        raise FFGymError(f"{name} has masked entries, must have a number everywhere; fill them or leave them out.")
    wanted = tuple(shape)
    if array.shape != wanted and (
        array.ndim != len(wanted) or any(w not in (None, s) for w, s in zip(wanted, array.shape, strict=True))
    ):
        text = "(" + ", ".join("any" if w is None else str(w) for w in wanted) + ")"
        raise FFGymError(f"{name} has shape {array.shape}, must be {text}.")
    finite = np.isfinite(array) | (array == np.inf) if infinite else np.isfinite(array)
    if not finite.all():
        index = tuple(int(i) for i in np.argwhere(~finite)[0])
        raise FFGymError(f"{name} must be finite, but entry {index} is {array[index]}.")
    return array


def check_rotation(name: str, value: Any) -> Array:
    """Return `value` as a rotation matrix, shape (3, 3)."""
    matrix = check_shape(name, value, (3, 3))
    bounded = np.all(np.abs(matrix) < 2)  # so that the product cannot overflow
    if not bounded or not np.allclose(matrix @ matrix.T, np.eye(3), atol=1e-6) or np.linalg.det(matrix) < 0:
        raise FFGymError(f"{name} = {matrix.tolist()} is not a rotation matrix.")
    return matrix


def check_rotations(name: str, value: Any, count: int) -> Array:
    """Return `value` as rotation matrices, shape (count, 3, 3)."""
    matrices = check_shape(name, value, (count, 3, 3))
    bounded = np.clip(matrices, -2.0, 2.0)  # so that no product can overflow
    off = np.abs(bounded @ bounded.swapaxes(1, 2) - np.eye(3)).max(axis=(1, 2)) > 1e-6
    wrong = np.flatnonzero(off | (np.linalg.det(bounded) < 0))
    if wrong.size:
        raise FFGymError(f"{name}[{wrong[0]}] = {matrices[wrong[0]].tolist()} is not a rotation matrix.")
    return matrices


def check_number(
    name: str, value: Any, *, unit: str = "", low: float = -np.inf, high: float = np.inf, open_low: bool = False
) -> float:
    """Return `value` as a float within [low, high], or (low, high] with `open_low`."""
    suffix = f" {unit}" if unit else ""
    try:
        if isinstance(value, str | bool):
            raise TypeError("text and truth values are not numbers")
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise FFGymError(f"{name} must be a number{f' in {unit}' if unit else ''}, got {value!r}.") from error
    if not np.isfinite(number):
        raise FFGymError(f"{name} must be finite, got {number}{suffix}.")
    if number < low or number > high or (open_low and number == low):
        bracket = "(" if open_low else "["
        raise FFGymError(f"{name} = {number}{suffix} is out of range, must be in {bracket}{low}, {high}]{suffix}.")
    return number


def check_whole(name: str, value: Any, *, unit: str = "", low: int, high: int | None = None) -> int:
    """Return `value` as an int within [low, high]."""
    number = check_number(name, value, unit=unit, low=low, high=np.inf if high is None else high)
    if number != round(number):
        raise FFGymError(f"{name} = {number} must be a whole number.")
    return round(number)


def check_class(name: str, value: Any, wanted: type, instead: str) -> None:
    """Check that `value` is of class `wanted`; `instead` says what makes one."""
    if not isinstance(value, wanted):
        raise FFGymError(f"{name} must be a {wanted.__name__}, got {type(value).__name__}; {instead}.")


def check_choice(name: str, value: str, available: Sequence[str]) -> str:
    """Return `value` if it is one of `available`."""
    if value not in available:
        raise FFGymError(f"Unknown {name} {value!r}. Available: {', '.join(sorted(available))}.")
    return value
