"""Formulas in numpy as graphs of ONNX: arrays that record what numpy is asked to do with them.

What a policy does with an observation (features, memory, network, scaling) is asked at such arrays in place of numbers,
so that no formula is written twice. Shapes are fixed; numbers have one type.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import onnx
from onnx import helper, numpy_helper

from ffgym.simulation.plant.compiled.tracing import Untraceable

OPSET = 17
"""Version of the operators; chosen: runtimes since 2022 have it (ONNX 1.12)."""
_IR_VERSION = 8
"""Version of the file format that goes with it."""
_OPERATORS = {
    "add": "Add",
    "subtract": "Sub",
    "multiply": "Mul",
    "divide": "Div",
    "negative": "Neg",
    "absolute": "Abs",
    "exp": "Exp",
    "log": "Log",
    "sqrt": "Sqrt",
    "tanh": "Tanh",
    "minimum": "Min",
    "maximum": "Max",
}
"""Operators of ONNX by names of numpy's functions."""


class OnnxGraph:
    """Nodes and constants of a graph while formulas are recorded."""

    def __init__(self, dtype: Any) -> None:
        self.dtype = np.dtype(dtype)
        self._inputs: list[Any] = []
        self._nodes: list[Any] = []
        self._constants: dict[tuple[Any, ...], Any] = {}

    def give(self, name: str, shape: tuple[int, ...], dtype: Any = None) -> "Recorded":
        """Make an input."""
        kind = helper.np_dtype_to_tensor_dtype(np.dtype(dtype or self.dtype))
        self._inputs.append(helper.make_tensor_value_info(name, kind, shape))
        return Recorded(self, name, shape)

    def constant(self, values: Any, dtype: Any = None) -> str:
        """Make a constant, or find it; returns its name."""
        array = np.ascontiguousarray(values, dtype=dtype or self.dtype)
        key = (array.dtype.str, array.shape, array.tobytes())
        if key not in self._constants:
            self._constants[key] = numpy_helper.from_array(array, name=f"constant_{len(self._constants)}")
        return str(self._constants[key].name)

    def record(self, operator: str, inputs: Sequence[Any], shape: tuple[int, ...], **attributes: Any) -> "Recorded":
        """Record an operator on arrays, numbers and names of constants."""
        names = [self._name(value) for value in inputs]
        name = f"v{len(self._nodes)}"
        self._nodes.append(helper.make_node(operator, names, [name], **attributes))
        return Recorded(self, name, shape)

    def _name(self, value: Any) -> str:
        if isinstance(value, Recorded):
            return value.name
        return value if isinstance(value, str) else self.constant(value)

    def model(self, outputs: dict[str, "Recorded"], name: str, notes: dict[str, str]) -> Any:
        """Make the model with named outputs, checked by ONNX.

        Args:
            outputs: results by name.
            name: name of the graph.
            notes: metadata of the model.
        """
        kind = helper.np_dtype_to_tensor_dtype(self.dtype)
        ends = [helper.make_node("Identity", [value.name], [key]) for key, value in outputs.items()]
        infos = [helper.make_tensor_value_info(key, kind, value.shape) for key, value in outputs.items()]
        graph = helper.make_graph([*self._nodes, *ends], name, self._inputs, infos, [*self._constants.values()])
        opsets = [helper.make_opsetid("", OPSET)]
        model = helper.make_model(graph, opset_imports=opsets, ir_version=_IR_VERSION, producer_name="ffgym")
        helper.set_model_props(model, notes)
        onnx.checker.check_model(model, full_check=True)
        return model


class Recorded(np.lib.mixins.NDArrayOperatorsMixin):
    """Array of a graph of ONNX."""

    def __init__(self, graph: OnnxGraph, name: str, shape: tuple[int, ...]) -> None:
        self.graph, self.name, self.shape = graph, name, tuple(int(n) for n in shape)

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self.shape)

    def __len__(self) -> int:
        return self.shape[0]

    def __array__(self, *_: Any, **__: Any) -> Any:
        """Refuse to become an array of numbers."""
        raise Untraceable("a conversion to an array of numbers")

    def __bool__(self) -> bool:
        raise Untraceable("a branch that depends on the observation")

    def astype(self, kind: Any) -> "Recorded":
        """Round to a type of numbers, and go on in the graph's own."""
        types = [helper.np_dtype_to_tensor_dtype(np.dtype(t)) for t in (kind, self.graph.dtype)]
        if types[0] == types[1] or np.dtype(kind).itemsize > self.graph.dtype.itemsize:
            return self
        rounded = self.graph.record("Cast", [self], self.shape, to=types[0])
        return self.graph.record("Cast", [rounded], self.shape, to=types[1])

    def reshape(self, *shape: Any) -> "Recorded":
        """Give it another shape."""
        wanted = shape[0] if len(shape) == 1 and isinstance(shape[0], tuple) else shape
        new = np.empty(self.shape, dtype=np.int8).reshape(wanted).shape
        return self.graph.record("Reshape", [self, self.graph.constant(new, np.int64)], new)

    def sum(self, axis: int) -> "Recorded":
        """Sum along an axis."""
        shape = np.empty(self.shape, dtype=np.int8).sum(axis=axis).shape
        return self.graph.record("ReduceSum", [self, self.graph.constant([axis], np.int64)], shape, keepdims=0)

    def __getitem__(self, key: Any) -> "Recorded":
        """Take a part by whole numbers, slices, and new axes."""
        keys = key if isinstance(key, tuple) else (key,)
        shape = np.empty(self.shape, dtype=np.int8)[key].shape
        taken = [k for k in keys if k is not None]
        if Ellipsis in taken:
            at = taken.index(Ellipsis)
            taken[at : at + 1] = [slice(None)] * (self.ndim - len(taken) + 1)
        part: Recorded = self
        for axis, k in enumerate(taken):
            part = part._slice(axis, k)
        return part if part.shape == shape else part.reshape(shape)

    def _slice(self, axis: int, k: Any) -> "Recorded":
        if not isinstance(k, slice | int | np.integer):
            raise Untraceable(f"the index {k!r}")
        start, stop, step = (k if isinstance(k, slice) else slice(k, k + 1 or None)).indices(self.shape[axis])
        count = len(range(start, stop, step))
        if count == self.shape[axis]:
            return self
        ends = [self.graph.constant([value], np.int64) for value in (start, stop, axis, step)]
        shape = (*self.shape[:axis], count, *self.shape[axis + 1 :])
        return self.graph.record("Slice", [self, *ends], shape)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> "Recorded":
        """Record a function of numpy."""
        if ufunc.__name__ == "clip" and method == "__call__":
            return np.minimum(np.maximum(inputs[0], inputs[1]), inputs[2])
        if method != "__call__" or options or ufunc.__name__ not in _OPERATORS:
            raise Untraceable(f"numpy.{ufunc.__name__}.{method} with {sorted(options)}")
        shape = np.broadcast_shapes(
            *(np.shape(value) if not isinstance(value, Recorded) else value.shape for value in inputs)
        )
        return self.graph.record(_OPERATORS[ufunc.__name__], inputs, shape)

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        """Record a function of numpy that moves or chooses elements."""
        known = _FUNCTIONS.get(function.__name__)
        if known is None:
            raise Untraceable(f"numpy.{function.__name__}")
        return known(self.graph, *args, **kwargs)


def _shape(value: Any) -> tuple[int, ...]:
    return value.shape if isinstance(value, Recorded) else np.shape(value)


def _concatenate(graph: OnnxGraph, arrays: Sequence[Any], axis: int = 0) -> Recorded:
    at = axis % len(_shape(arrays[0]))
    shape = np.concatenate([np.empty(_shape(array), dtype=np.int8) for array in arrays], axis=axis).shape
    return graph.record("Concat", [array for array in arrays if 0 not in _shape(array)], shape, axis=at)


def _stack(graph: OnnxGraph, arrays: Sequence[Any], axis: int = 0) -> Recorded:
    at = axis % (len(_shape(arrays[0])) + 1)
    parts = [array.reshape(*_shape(array)[:at], 1, *_shape(array)[at:]) for array in arrays]
    return _concatenate(graph, parts, axis=at)


def _swapaxes(graph: OnnxGraph, array: Recorded, first: int, second: int) -> Recorded:
    order = list(range(array.ndim))
    order[first], order[second] = order[second], order[first]
    return graph.record("Transpose", [array], tuple(array.shape[k] for k in order), perm=order)


def _split(graph: OnnxGraph, array: Recorded, count: int, axis: int = 0) -> list[Recorded]:
    at, size = axis % array.ndim, array.shape[axis] // count
    return [array._slice(at, slice(k * size, (k + 1) * size)) for k in range(count)]


def _repeat(graph: OnnxGraph, array: Recorded, count: int, axis: int = 0) -> Recorded:
    if array.shape[axis] != 1:
        raise Untraceable("a repetition of several elements")
    return array if count == 1 else _concatenate(graph, [array] * count, axis=axis)


def _where(graph: OnnxGraph, condition: Any, yes: Any, no: Any) -> Recorded:
    shape = np.broadcast_shapes(*map(_shape, (condition, yes, no)))
    return graph.record("Where", [condition, yes, no], shape)


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "concatenate": _concatenate,
    "stack": _stack,
    "swapaxes": _swapaxes,
    "split": _split,
    "repeat": _repeat,
    "where": _where,
    "clip": lambda graph, values, low, high: np.minimum(np.maximum(values, low), high),
}
"""Functions of numpy, beside ufuncs, that policies use."""
