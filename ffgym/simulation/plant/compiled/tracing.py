"""Formulas of effects as graphs: arrays that record what numpy is asked to do with them.

An effect is a formula in numpy, elementwise over robots and joints. Asked at `Traced` arrays in place of numbers it
gives the graph of its operations, from which code is made. What is not elementwise raises `Untraceable`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.simulation.plant.compiled.operations import OPERATIONS

Nodes = Any
"""NumPy array of nodes."""


class Untraceable(Exception):
    """Formula that is no graph of elementwise operations; numpy computes it."""


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """Number or truth value of one robot's joint at a physics step, or an operation on such."""

    operation: str
    """Name in `OPERATIONS`, or 'where', 'pick', 'number' (as `value`), or 'given' (from the source `value`)."""
    arguments: tuple["Node", ...]
    value: Any
    gives: str
    """Kind: number or truth."""
    is_fixed: bool
    """True if it is the same at all physics steps."""


@dataclass(eq=False)
class Graph:
    """Nodes of several formulas; equal ones are made once."""

    n_joints: int
    nodes: dict[tuple[Any, ...], Node] = field(default_factory=dict)
    tables: list[Array] = field(default_factory=list)
    """Constants that differ from joint to joint, (N,) each."""

    def make(self, operation: str, *arguments: Node, value: Any = None, gives: str = "number", fixed: bool) -> Node:
        """Make a node, or find it."""
        key = (operation, value, *map(id, arguments))
        if key not in self.nodes:
            self.nodes[key] = Node(operation, arguments, value, gives, fixed)
        return self.nodes[key]

    def number(self, value: float) -> Node:
        """Make a constant; its bits are what it is found by."""
        return self.make("number", value=float(value).hex(), fixed=True)

    def given(self, source: Any, *, fixed: bool = False) -> Any:
        """Make an array (..., N) that a `source` gives, at each physics step or once for all; `Traced`."""
        return Traced(self, _single(self.make("given", value=source, fixed=fixed)))

    def given_memory(self, sources: Sequence[Any]) -> Any:
        """Make an array (..., N, M) whose M parts `sources` give; `Traced`."""
        parts = np.empty(len(sources), dtype=object)
        parts[:] = [self.make("given", value=source, fixed=False) for source in sources]
        return Traced(self, parts)

    def constant(self, values: Any, trailing: int) -> Nodes:
        """Nodes of numbers beside arrays with so many axes after that of the joints.

        Raises:
            Untraceable: if they differ from robot to robot.
        """
        array = np.asarray(values)
        if array.dtype.kind not in "fiub":
            raise Untraceable(f"an array of {array.dtype}")
        lead = max(array.ndim - trailing, 0)
        nodes = np.empty(array.shape[lead:], dtype=object)
        for place in np.ndindex(nodes.shape):
            nodes[place] = self._of_joints(array[(..., *place)])
        return nodes

    def describe(self) -> list[tuple[Any, ...]]:
        """All of it as text and numbers, to tell whether two graphs are the same."""
        place = {id(node): k for k, node in enumerate(self.nodes.values())}
        nodes = [(n.operation, n.value, *(place[id(a)] for a in n.arguments)) for n in self.nodes.values()]
        return [*nodes, *(tuple(table.tolist()) for table in self.tables)]

    def _of_joints(self, values: Any) -> Node:
        """Node of one number, or of one for each joint."""
        flat = np.asarray(values, dtype=np.float64)
        if flat.size and np.all(flat.view(np.int64) == flat.view(np.int64).flat[0]):
            return self.number(flat.flat[0])
        if flat.shape[-1:] != (self.n_joints,) or flat.size != self.n_joints:
            raise Untraceable(f"an array of shape {flat.shape}")
        table = flat.ravel()
        known = [other.tobytes() for other in self.tables]
        if table.tobytes() not in known:
            self.tables.append(table.copy())
            known.append(table.tobytes())
        return self.make("given", value=("table", known.index(table.tobytes())), fixed=True)

    def apply(self, operation: str, arguments: Sequence[Node]) -> Node:
        """Make the node of an operation in `OPERATIONS`."""
        known = OPERATIONS[operation]
        if operation in ("add", "subtract", "multiply") and all(a.gives == "truth" for a in arguments):
            raise Untraceable(f"{operation} of truth values")
        fixed = all(argument.is_fixed for argument in arguments)
        return self.make(operation, *(self.cast(a, known.of) for a in arguments), gives=known.gives, fixed=fixed)

    def cast(self, node: Node, kind: str) -> Node:
        """Node as a number or as a truth value."""
        if node.gives == kind:
            return node
        if kind == "truth":
            return self.apply("not_equal", [node, self.number(0.0)])
        return self.choose(node, self.number(1.0), self.number(0.0))

    def choose(self, condition: Node, yes: Node, no: Node) -> Node:
        """Node of one of two."""
        kind = "truth" if yes.gives == no.gives == "truth" else "number"
        each = self.cast(condition, "truth"), self.cast(yes, kind), self.cast(no, kind)
        return self.make("where", *each, gives=kind, fixed=all(node.is_fixed for node in each))

    def pick(self, index: Node, nodes: Sequence[Node]) -> Node:
        """Node of the one of `nodes` with that index."""
        numbers = [self.cast(node, "number") for node in nodes]
        if len(numbers) == 1:
            return numbers[0]
        return self.make("pick", self.cast(index, "number"), *numbers, fixed=False)


def _single(node: Node) -> Nodes:
    nodes = np.empty((), dtype=object)
    nodes[()] = node
    return nodes


ALIASES = {
    "true_divide": "divide",
    "fabs": "absolute",
    "bitwise_and": "logical_and",
    "bitwise_or": "logical_or",
    "bitwise_xor": "logical_xor",
    "invert": "logical_not",
    "float_power": "power",
}
"""Functions of numpy that are others by name; bitwise ones of truth values alone."""


class Traced(np.lib.mixins.NDArrayOperatorsMixin):
    """Array (1, N, ...) that records what is done with it; all axes after that of the joints are known one by one."""

    def __init__(self, graph: Graph, nodes: Nodes) -> None:
        self.graph, self.nodes = graph, nodes

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape, as of one robot."""
        return (1, self.graph.n_joints, *self.nodes.shape)

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return 2 + self.nodes.ndim

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of its elements."""
        kinds = {node.gives for node in self.nodes.flat}
        return np.dtype(np.bool_ if kinds == {"truth"} else np.float64)

    def copy(self) -> "Traced":
        """Copy it."""
        return Traced(self.graph, self.nodes.copy())

    def astype(self, kind: Any) -> "Traced":
        """Copy it as numbers, whole numbers or truth values."""
        wanted = np.dtype(kind).kind
        if wanted == "b":
            return self._each(lambda node: self.graph.cast(node, "truth"))
        if wanted == "i":
            return self._each(lambda node: self.graph.apply("trunc", [node]))
        return self._each(lambda node: self.graph.cast(node, "number"))

    def _each(self, change: Callable[[Node], Node]) -> "Traced":
        nodes = np.empty_like(self.nodes)
        for place in np.ndindex(nodes.shape):
            nodes[place] = change(self.nodes[place])
        return Traced(self.graph, nodes)

    def __array__(self, *_: Any, **__: Any) -> Any:
        """Refuse to become an array of numbers."""
        raise Untraceable("a conversion to an array of numbers")

    def __bool__(self) -> bool:
        raise Untraceable("a branch that depends on the state")

    __float__ = __int__ = __len__ = __iter__ = __index__ = __bool__

    def __getitem__(self, key: Any) -> "Traced":
        return Traced(self.graph, self._view(key))

    def __setitem__(self, key: Any, values: Any) -> None:
        target = self._view(key)
        target[...] = self._beside(values, target.ndim)

    def _view(self, key: Any) -> Nodes:
        """Nodes at a key that leaves robots and joints as they are."""
        keys = key if isinstance(key, tuple) else (key,)
        from_the_end = keys[:1] == (Ellipsis,)
        after = keys[1:] if from_the_end else keys[2:]
        whole = from_the_end or all(isinstance(k, slice) and k == slice(None) for k in keys[:2])
        used = sum(k is not None for k in after)
        simple = all(k is None or isinstance(k, int | np.integer | slice) for k in after)
        if not whole or not simple or used > self.nodes.ndim:
            raise Untraceable(f"the index {key!r}")
        view: Nodes = self.nodes[(Ellipsis, *after) if from_the_end else (*after, Ellipsis)]
        return view

    def _beside(self, other: Any, trailing: int) -> Nodes:
        """Nodes of another array, which has so many axes after that of the joints."""
        if isinstance(other, Traced):
            if other.graph is not self.graph:
                raise Untraceable("two graphs")
            if other.nodes.ndim != trailing:  # numpy would set joints beside what they remember
                raise Untraceable("arrays of different numbers of axes")
            return other.nodes
        return self.graph.constant(other, trailing)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        """Record a function of numpy."""
        name = ALIASES.get(ufunc.__name__, ufunc.__name__)
        out, where = options.pop("out", None), options.pop("where", True)
        if method != "__call__" or options or ufunc.nout != 1:
            raise Untraceable(f"{ufunc.__name__}.{method} with {sorted(options)}")
        if ufunc.__name__.startswith(("bitwise", "invert")) and any(np.asarray(_kind(i)) != "b" for i in inputs):
            raise Untraceable(f"{ufunc.__name__} of numbers")
        result = self._record(name, inputs)
        if out is None:
            return result if where is True else _refuse("where without out")
        (target,) = out
        if not isinstance(target, Traced):
            raise Untraceable("a result that is written into an array of numbers")
        if where is not True:
            result = _where(self, where, result, target)
        target.nodes[...] = result.nodes
        return target

    def _record(self, name: str, inputs: Sequence[Any]) -> "Traced":
        graph = self.graph
        trailing = max(i.nodes.ndim for i in inputs if isinstance(i, Traced))
        each: list[Nodes] = list(np.broadcast_arrays(*(self._beside(i, trailing) for i in inputs)))
        nodes = np.empty(each[0].shape, dtype=object)
        for place in np.ndindex(nodes.shape):
            nodes[place] = record_one(graph, name, [array[place] for array in each])
        return Traced(graph, nodes)

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        """Record a function of numpy that is no ufunc."""
        known = _FUNCTIONS.get(function.__name__)
        if known is None:
            raise Untraceable(f"numpy.{function.__name__}")
        return known(self, *args, **kwargs)


def _kind(value: Any) -> str:
    return str(value.dtype.kind if hasattr(value, "dtype") else np.asarray(value).dtype.kind)


def _refuse(why: str) -> Any:
    raise Untraceable(why)


def record_one(graph: Graph, name: str, nodes: list[Node]) -> Node:
    """Record a function of single nodes; some are written by others, as numpy does."""
    if name == "square":
        return graph.apply("multiply", [nodes[0], nodes[0]])
    if name == "reciprocal":
        return graph.apply("divide", [graph.number(1.0), nodes[0]])
    if name == "positive":
        return nodes[0]
    if name == "power" and nodes[1].operation == "number":
        exponent = float.fromhex(nodes[1].value)
        if exponent == 2.0:
            return graph.apply("multiply", [nodes[0], nodes[0]])
        if exponent == 1.0:
            return nodes[0]
        if exponent == 0.5:
            return graph.apply("sqrt", [nodes[0]])
    if name not in OPERATIONS:
        raise Untraceable(f"numpy.{name}")
    return graph.apply(name, nodes)


def _where(first: Traced, condition: Any, yes: Any, no: Any) -> Traced:
    """Record `numpy.where`."""
    trailing = max(i.nodes.ndim for i in (condition, yes, no) if isinstance(i, Traced))
    each: list[Nodes] = list(np.broadcast_arrays(*(first._beside(i, trailing) for i in (condition, yes, no))))
    nodes = np.empty(each[0].shape, dtype=object)
    for place in np.ndindex(nodes.shape):
        nodes[place] = first.graph.choose(*(array[place] for array in each))
    return Traced(first.graph, nodes)


def _full_like(first: Traced, like: Traced, value: float) -> Traced:
    nodes = np.empty(like.nodes.shape, dtype=object)
    nodes[...] = first.graph.number(value)
    return Traced(first.graph, nodes)


def _stack(first: Traced, arrays: Sequence[Any], axis: int = 0) -> Traced:
    """Record `numpy.stack` along a last axis."""
    if axis != -1:
        raise Untraceable(f"stack along axis {axis}")
    trailing = max(a.nodes.ndim for a in arrays if isinstance(a, Traced))
    each: list[Nodes] = list(np.broadcast_arrays(*(first._beside(a, trailing) for a in arrays)))
    return Traced(first.graph, np.stack(each, axis=-1))


def _concatenate(first: Traced, arrays: Sequence[Any], axis: int = 0) -> Traced:
    """Record `numpy.concatenate` along a last axis."""
    trailing = max(a.nodes.ndim for a in arrays if isinstance(a, Traced))
    if axis != -1 or trailing == 0:
        raise Untraceable(f"concatenate along axis {axis}")
    return Traced(first.graph, np.concatenate([first._beside(a, trailing) for a in arrays], axis=-1))


def _take_along_axis(first: Traced, array: Any, indices: Any, axis: int = -1) -> Traced:
    """Record `numpy.take_along_axis` along the only axis after that of the joints."""
    nodes, chosen = first._beside(array, 1), first._beside(indices, 1)
    if axis != -1 or nodes.ndim != 1 or chosen.ndim != 1:
        raise Untraceable(f"take_along_axis along axis {axis}")
    found = np.empty(chosen.shape, dtype=object)
    for k, index in enumerate(chosen):
        found[k] = first.graph.pick(index, nodes.tolist())
    return Traced(first.graph, found)


def _broadcast_to(first: Traced, values: Traced, shape: tuple[int, ...]) -> Traced:
    """Record `numpy.broadcast_to` a shape of the same axes."""
    if tuple(shape) != values.shape:
        raise Untraceable(f"broadcast to {shape}")
    return values


def _clip(first: Traced, values: Any, low: Any = None, high: Any = None) -> Any:
    bounded = values if low is None else np.maximum(values, low)
    return bounded if high is None else np.minimum(bounded, high)


def _sum(first: Traced, values: Traced, axis: Any = None) -> Traced:
    """Record a sum along a last axis, in its order."""
    if axis != -1:
        raise Untraceable(f"a sum along axis {axis}")
    total = values[..., 0]
    for k in range(1, values.nodes.shape[-1]):
        total = total + values[..., k]
    return total


def _round(first: Traced, values: Traced, decimals: int = 0) -> Any:
    return np.rint(values) if decimals == 0 else _refuse("round to decimals")


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "where": _where,
    "zeros_like": lambda first, like, **_: _full_like(first, like, 0.0),
    "empty_like": lambda first, like, **_: _full_like(first, like, 0.0),
    "ones_like": lambda first, like, **_: _full_like(first, like, 1.0),
    "full_like": lambda first, like, value, **_: _full_like(first, like, value),
    "stack": _stack,
    "concatenate": _concatenate,
    "take_along_axis": _take_along_axis,
    "broadcast_to": _broadcast_to,
    "clip": _clip,
    "sum": _sum,
    "round": _round,
    "around": _round,
}
"""Functions of numpy, beside ufuncs, that effects may use."""
