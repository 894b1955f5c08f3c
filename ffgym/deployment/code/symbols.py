"""Arrays of symbols: numpy's arrays whose elements are nodes of a graph, so that a law's formulas become one.

Laws index joints and mix them (coupled drives, a servo whose integral ends for all joints), so that each element is a
symbol of its own here, where formulas of effects (`ffgym.simulation.plant.compiled.tracing`) know one joint for all.
Operations, nodes and graphs are those of that package.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ffgym.simulation.plant.compiled.tracing import ALIASES, Graph, Node, Untraceable, record_one


class Symbols(np.ndarray[Any, Any]):
    """Array of any shape with nodes and numbers as elements, which records what numpy is asked to do with it."""

    graph: Graph

    @classmethod
    def of(cls, graph: Graph, nodes: Any) -> "Symbols":
        """Make an array of nodes and numbers that belong to a graph."""
        array = np.asarray(nodes, dtype=object).view(cls)
        array.graph = graph
        return array

    def __array_finalize__(self, source: Any) -> None:
        if (graph := getattr(source, "graph", None)) is not None:
            self.graph = graph

    def __bool__(self) -> bool:
        raise Untraceable("a branch that depends on the reference or the memory")

    __float__ = __int__ = __index__ = __bool__

    def __getitem__(self, key: Any) -> Any:
        found = super().__getitem__(key)
        return found if isinstance(found, Symbols) else Symbols.of(self.graph, found)

    def __setitem__(self, key: Any, values: Any) -> None:
        plain = np.asarray(values, dtype=object)
        np.ndarray.__setitem__(self.view(np.ndarray), key, plain if plain.ndim else plain.item())

    def __iter__(self) -> Iterator["Symbols"]:  # type: ignore[override]
        return (self[k] for k in range(len(self)))

    def astype(self, kind: Any, *_: Any, **__: Any) -> Any:  # type: ignore[override]
        """Copy it as numbers, whole numbers or truth values."""
        wanted = np.dtype(kind).kind
        if wanted == "O":
            return self.copy()
        if wanted == "i":
            return np.trunc(self)
        return self._each(self, "truth" if wanted == "b" else "number")

    @staticmethod
    def _each(values: "Symbols", kind: str) -> "Symbols":
        found = [values.graph.cast(node_of(values.graph, value), kind) for value in values.flat]
        return _fill(values.graph, found, values.shape)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        """Record a function of numpy, element by element; sums and the like are taken in their order."""
        out, where = options.pop("out", None), options.pop("where", True)
        graph = self.graph
        if method == "reduce":
            return _reduce(graph, ufunc, inputs[0], **options)
        if method != "__call__" or ufunc.nout != 1 or {name for name in options if name != "dtype"}:
            raise Untraceable(f"{ufunc.__name__}.{method} with {sorted(options)}")
        result = _elementwise(graph, ufunc, inputs)
        if where is True and (out is None or (out[0] is inputs[0] and not isinstance(out[0], Symbols))):
            return result  # of `total += symbols` too, where total was an array of numbers and is one of symbols then
        if out is None or not isinstance(out[0], Symbols):
            raise Untraceable("a result that is written into an array of numbers")
        out[0][...] = result if where is True else _where(graph, where, result, out[0])
        return out[0]

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        """Record a choice; functions that move elements do so themselves."""
        graph = self.graph
        if function is np.where and len(args) == 3:
            return _where(graph, *args)
        if function is np.take_along_axis:
            return _take_along_last_axis(graph, *args, **kwargs)
        if function.__module__ not in ("numpy", "numpy.lib.stride_tricks") or function.__name__ in _REFUSED:
            raise Untraceable(f"numpy.{function.__name__}")
        return _with_graph(graph, super().__array_function__(function, types, args, kwargs))


_REFUSED = ("einsum", "dot", "matmul", "interp", "searchsorted", "sort", "argsort", "argmax", "argmin", "array_equal")
"""Functions of numpy that would look at the values of elements."""


def node_of(graph: Graph, value: Any) -> Node:
    """Node of an element, which may be a number."""
    return value if isinstance(value, Node) else graph.number(float(value))


def _with_graph(graph: Graph, found: Any) -> Any:
    """Give arrays that numpy made of ours the graph; all else is left as it is."""
    if isinstance(found, tuple | list):
        return type(found)(_with_graph(graph, part) for part in found)
    if isinstance(found, Node) or (isinstance(found, np.ndarray) and found.dtype == object):
        return Symbols.of(graph, found)
    return found


def _fill(graph: Graph, nodes: Sequence[Any], shape: tuple[int, ...]) -> Symbols:
    """Array of a shape with nodes in C order."""
    array = np.empty(len(nodes), dtype=object)
    array[:] = nodes
    return Symbols.of(graph, array.reshape(shape))


def _elementwise(graph: Graph, ufunc: np.ufunc, inputs: Sequence[Any]) -> Symbols:
    """Record a function at each element of inputs that are broadcast."""
    name = ALIASES.get(ufunc.__name__, ufunc.__name__)
    if name == "clip":
        return np.minimum(np.maximum(inputs[0], inputs[1]), inputs[2])
    arrays = [np.asarray(each, dtype=object) for each in inputs]
    each = np.broadcast_arrays(*arrays)
    if (same := _find_result(name, arrays)) is not None:
        return _fill(graph, list(each[same].flat), each[same].shape)
    found = [_record(graph, ufunc, name, values) for values in zip(*(array.flat for array in each), strict=True)]
    return _fill(graph, found, each[0].shape)


_NEUTRAL = {"add": (0.0, (0, 1)), "subtract": (0.0, (1,)), "multiply": (1.0, (0, 1)), "divide": (1.0, (1,))}
"""Number that leaves the other argument as it is, and the places where it does."""


def _find_result(name: str, arrays: Sequence[Any]) -> int | None:
    """Find the argument that is the result, since the other one is neutral for all elements; None if none is."""
    number, places = _NEUTRAL.get(name, (0.0, ()))
    for place in places:
        if all(not isinstance(value, Node) and value == number for value in arrays[place].flat):
            return 1 - place
    return None


def _record(graph: Graph, ufunc: np.ufunc, name: str, values: Sequence[Any]) -> Any:
    """Record a function of elements; one of numbers alone is a number."""
    if not any(isinstance(value, Node) for value in values):
        return ufunc(*(np.float64(value) if not isinstance(value, bool | np.bool_) else value for value in values))
    return record_one(graph, name, [node_of(graph, value) for value in values])


def _reduce(graph: Graph, ufunc: np.ufunc, values: Any, axis: Any = 0, keepdims: bool = False, **options: Any) -> Any:
    """Record a function between neighbours along an axis, from the first element to the last."""
    if axis is None:
        values, axis = np.asarray(values, dtype=object).reshape(-1), 0
    if isinstance(axis, tuple) or options.get("initial", np._NoValue) not in (np._NoValue, None):
        raise Untraceable(f"{ufunc.__name__}.reduce over axes {axis}")
    rows = np.moveaxis(np.asarray(values, dtype=object), axis, 0)
    total = Symbols.of(graph, rows[0])
    for row in rows[1:]:
        total = _elementwise(graph, ufunc, [total, row])
    return np.expand_dims(total, axis) if keepdims else total


def _where(graph: Graph, condition: Any, yes: Any, no: Any) -> Symbols:
    """Record `numpy.where`."""
    each = np.broadcast_arrays(*(np.asarray(part, dtype=object) for part in (condition, yes, no)))
    found = [
        graph.choose(*(node_of(graph, value) for value in values))
        for values in zip(*(array.flat for array in each), strict=True)
    ]
    return _fill(graph, found, each[0].shape)


def _take_along_last_axis(graph: Graph, array: Any, indices: Any, axis: int = -1) -> Symbols:
    """Record `numpy.take_along_axis` along the last axis."""
    if axis != -1:
        raise Untraceable(f"take_along_axis along axis {axis}")
    rows = np.broadcast_to(np.asarray(array, dtype=object), (*indices.shape[:-1], np.shape(array)[-1]))
    found = [
        graph.pick(node_of(graph, index), [node_of(graph, value) for value in row])
        for place in np.ndindex(indices.shape[:-1])
        for row, chosen in [(rows[place], np.asarray(indices, dtype=object)[place])]
        for index in chosen
    ]
    return _fill(graph, found, indices.shape)
