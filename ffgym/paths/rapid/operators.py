"""Operators of RAPID: which types they take, and what they give."""

import math
import operator
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid.records import BOOL, NUM, ORIENT, POS, STRING, Type, Value

Operate = Callable[[Any, Any], Value]

LARGEST_NUMBER = 1e38
"""Bound on every number; RAPID's num is an IEEE 754 float of 32 bit, which ends at 3.4e38."""


def check_size(value: float) -> float:
    """Return a number that is not too large for RAPID."""
    if not abs(value) <= LARGEST_NUMBER:
        raise FFGymError(f"{value:g} is too large, numbers go to {LARGEST_NUMBER:g}.")
    return value


def _check_result(operate: Callable[[float, float], float]) -> Operate:
    return lambda a, b: check_size(operate(a, b))


def _act_on_vectors(operate: Callable[[Any, Any], Any]) -> Operate:
    return lambda a, b: tuple(check_size(x) for x in np.asarray(operate(np.asarray(a), np.asarray(b))).tolist())


def multiply_quaternions(first: Value, second: Value) -> Value:
    """Product of two quaternions, scalar first: the turn by the second, then by the first."""
    a, u = first[0], np.array(first[1:])
    b, v = second[0], np.array(second[1:])
    scalar = a * b - float(u @ v)
    return (scalar, *(a * v + b * u + np.cross(u, v)).tolist())


ARITHMETIC: Mapping[tuple[str, str, str], tuple[Type, Operate]] = MappingProxyType(
    {
        **{
            (sign, "num", "num"): (NUM, _check_result(operate))
            for sign, operate in {
                "+": operator.add,
                "-": operator.sub,
                "*": operator.mul,
                "/": operator.truediv,
                "DIV": lambda a, b: float(math.trunc(a / b)),
                "MOD": math.fmod,
            }.items()
        },
        **{
            (sign, "pos", "pos"): (POS, _act_on_vectors(operate))
            for sign, operate in {"+": np.add, "-": np.subtract}.items()
        },
        ("*", "pos", "num"): (POS, _act_on_vectors(np.multiply)),
        ("*", "num", "pos"): (POS, _act_on_vectors(np.multiply)),
        ("/", "pos", "num"): (POS, lambda a, b: tuple(check_size(x / b) for x in a)),
        ("*", "pos", "pos"): (POS, _act_on_vectors(np.cross)),
        ("*", "orient", "orient"): (ORIENT, multiply_quaternions),
        ("+", "string", "string"): (STRING, operator.add),
        **{(sign, "num", "num"): (BOOL, operate) for sign, operate in {"<": operator.lt, ">": operator.gt}.items()},
        **{(sign, "num", "num"): (BOOL, operate) for sign, operate in {"<=": operator.le, ">=": operator.ge}.items()},
        ("AND", "bool", "bool"): (BOOL, lambda a, b: a and b),
        ("OR", "bool", "bool"): (BOOL, lambda a, b: a or b),
        ("XOR", "bool", "bool"): (BOOL, operator.ne),
    }
)
"""Result and computation by operator and types of its operands; technical reference manual RAPID overview (ABB
3HAC16580-1), operators."""


def find_operator(sign: str, left: Type, right: Type) -> tuple[Type, Operate]:
    """Find an operator by its sign, in upper case, and the types of its operands.

    Raises:
        FFGymError: if it does not take these types.
    """
    if sign in ("=", "<>"):
        if left.takes(right) or right.takes(left):
            return BOOL, operator.eq if sign == "=" else operator.ne
    elif not left.dimensions and not right.dimensions:
        found = ARITHMETIC.get((sign, left.name, right.name))
        if found is not None:
            return found
        takers = sorted({a for op, a, _ in ARITHMETIC if op == sign})
        if left.name not in takers:
            raise FFGymError(f"{' or '.join(takers)} is wanted before {sign}, this is {left}.")
        wanted = sorted({b for op, a, b in ARITHMETIC if op == sign and a == left.name})
        raise FFGymError(f"{' or '.join(wanted)} is wanted here, this is {right}.")
    raise FFGymError(f"{left} {sign} {right} is not possible.")
