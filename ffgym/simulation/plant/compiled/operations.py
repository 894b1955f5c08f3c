"""Elementwise operations that formulas are made of: numpy's function for each, and its code for LLVM and in C99.

Arithmetic is the same to the bit. Functions of the C library may differ from numpy's in their last bits.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Operation:
    """Operation on numbers or truth values of one joint."""

    function: Callable[..., Any]
    """Function of numpy, elementwise."""
    code: str
    """Lines of LLVM's language: {r} is the result, {0}, {1}, ... are arguments."""
    c: str
    """Expression of C99; {0}, {1}, ... are names of its arguments, double for numbers and int for truth values."""
    of: str = "number"
    """Kind of its arguments: number or truth."""
    gives: str = "number"
    """Kind of its result."""


def _arithmetic(function: Callable[..., Any], instruction: str, sign: str) -> Operation:
    code = f"{{r}} = {instruction} double {{0}}, {{1}}"
    return Operation(function=function, code=code, c=f"{{0}} {sign} {{1}}")


def _comparison(function: Callable[..., Any], predicate: str, sign: str) -> Operation:
    code = f"{{r}} = fcmp {predicate} double {{0}}, {{1}}"
    return Operation(function=function, code=code, c=f"{{0}} {sign} {{1}}", gives="truth")


def _logic(function: Callable[..., Any], instruction: str, sign: str) -> Operation:
    code = f"{{r}} = {instruction} i1 {{0}}, {{1}}"
    return Operation(function=function, code=code, c=f"{{0}} {sign} {{1}}", of="truth", gives="truth")


def _intrinsic(function: Callable[..., Any], name: str, n: int = 1) -> Operation:
    arguments = ", ".join(f"double {{{k}}}" for k in range(n))
    code = f"{{r}} = call double @llvm.{name}.f64({arguments})"
    return Operation(function=function, code=code, c=_call(name, n))


def _call(name: str, n: int) -> str:
    """Call of a function of C99 with `n` arguments."""
    return f"{name}({', '.join(f'{{{k}}}' for k in range(n))})"


def _chosen(function: Callable[..., Any], predicate: str, sign: str) -> Operation:
    """Smaller or larger of two numbers as numpy gives it: a number that is none is passed on."""
    return Operation(
        function=function,
        code=f"{{r}}.before = fcmp {predicate} double {{0}}, {{1}}\n  {{r}}.none = fcmp uno double {{0}}, {{0}}\n"
        "  {r}.first = or i1 {r}.before, {r}.none\n  {r} = select i1 {r}.first, double {0}, double {1}",
        c=f"({{0}} {sign} {{1}} || {{0}} != {{0}}) ? {{0}} : {{1}}",
    )


LIBRARY: dict[str, tuple[str, int]] = {
    "exp": ("exp", 1),
    "exp2": ("exp2", 1),
    "expm1": ("expm1", 1),
    "log": ("log", 1),
    "log2": ("log2", 1),
    "log10": ("log10", 1),
    "log1p": ("log1p", 1),
    "sin": ("sin", 1),
    "cos": ("cos", 1),
    "tan": ("tan", 1),
    "arcsin": ("asin", 1),
    "arccos": ("acos", 1),
    "arctan": ("atan", 1),
    "arcsinh": ("asinh", 1),
    "sinh": ("sinh", 1),
    "cosh": ("cosh", 1),
    "tanh": ("tanh", 1),
    "cbrt": ("cbrt", 1),
    "arctan2": ("atan2", 2),
    "hypot": ("hypot", 2),
    "power": ("pow", 2),
}
"""Functions of the C library by numpy's names, with the number of their arguments."""


def library_symbol(name: str) -> str:
    """Name of a C function in compiled code: one that LLVM does not know, so that it calls the function as it is."""
    return f"ffgym.{name}"


def _library(name: str) -> Operation:
    function, n = LIBRARY[name]
    arguments = ", ".join(f"double {{{k}}}" for k in range(n))
    code = f"{{r}} = call double @{library_symbol(function)}({arguments})"
    return Operation(function=getattr(np, name), code=code, c=_call(function, n))


OPERATIONS: dict[str, Operation] = {
    "add": _arithmetic(np.add, "fadd", "+"),
    "subtract": _arithmetic(np.subtract, "fsub", "-"),
    "multiply": _arithmetic(np.multiply, "fmul", "*"),
    "divide": _arithmetic(np.divide, "fdiv", "/"),
    "negative": Operation(function=np.negative, code="{r} = fneg double {0}", c="-{0}"),
    "absolute": _intrinsic(np.absolute, "fabs"),
    "sqrt": _intrinsic(np.sqrt, "sqrt"),
    "rint": _intrinsic(np.rint, "rint"),
    "floor": _intrinsic(np.floor, "floor"),
    "ceil": _intrinsic(np.ceil, "ceil"),
    "trunc": _intrinsic(np.trunc, "trunc"),
    "copysign": _intrinsic(np.copysign, "copysign", 2),
    "minimum": _chosen(np.minimum, "olt", "<"),
    "maximum": _chosen(np.maximum, "ogt", ">"),
    "sign": Operation(
        function=np.sign,
        code="{r}.above = fcmp ogt double {0}, 0.0\n  {r}.below = fcmp olt double {0}, 0.0\n"
        "  {r}.none = fcmp uno double {0}, {0}\n  {r}.rest = select i1 {r}.none, double {0}, double 0.0\n"
        "  {r}.not = select i1 {r}.below, double -1.0, double {r}.rest\n"
        "  {r} = select i1 {r}.above, double 1.0, double {r}.not",
        c="{0} != {0} ? {0} : (double)(({0} > 0.0) - ({0} < 0.0))",
    ),
    "greater": _comparison(np.greater, "ogt", ">"),
    "greater_equal": _comparison(np.greater_equal, "oge", ">="),
    "less": _comparison(np.less, "olt", "<"),
    "less_equal": _comparison(np.less_equal, "ole", "<="),
    "equal": _comparison(np.equal, "oeq", "=="),
    "not_equal": _comparison(np.not_equal, "une", "!="),
    "logical_and": _logic(np.logical_and, "and", "&&"),
    "logical_or": _logic(np.logical_or, "or", "||"),
    "logical_xor": _logic(np.logical_xor, "xor", "!="),
    "logical_not": Operation(
        function=np.logical_not, code="{r} = xor i1 {0}, true", c="!{0}", of="truth", gives="truth"
    ),
    **{name: _library(name) for name in LIBRARY},
}
"""Operations by numpy's names of them."""
