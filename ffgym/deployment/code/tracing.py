"""Laws as graphs: one step of a law, asked at symbols, and what of it depends on the program alone."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from ffgym.agents.spline_basis import SplineBasis
from ffgym.control import CausalLaw, Window
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, IntArray
from ffgym.deployment.code.symbols import Symbols, node_of
from ffgym.paths import Reference
from ffgym.robot import RigidArm
from ffgym.simulation.plant.compiled.operations import OPERATIONS
from ffgym.simulation.plant.compiled.tracing import Graph, Node, Untraceable

WINDOW = ("q", "motor_dq", "motor_ddq")
"""Quantities of a window, in the order of the arguments of a step in C."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ProgramTerm:
    """Term of a law that a function outside numpy gives along the program, e.g. torque of rigid links."""

    function: Callable[..., Array]
    """Function of rows (R, N) each, which gives rows (R, N)."""
    arguments: tuple[Any, ...]
    """Nodes and numbers that it is asked at, (R, N) each."""
    first: int
    """Column of its first number in the table of the program."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TracedLaw:
    """One step of a law as a graph."""

    law: CausalLaw
    dt: float
    """Time between samples [s]."""
    graph: Graph
    torque: tuple[Node, ...]
    """Torque of each motor [N m]."""
    memory: tuple[Node, ...]
    """Memory after the step."""
    own_error: tuple[tuple[Node, ...], tuple[Node, ...]]
    """Errors that the law itself asks for at the next sample, position [rad] and speed [rad/s]."""
    instant_error: tuple[tuple[Node, ...], tuple[Node, ...]]
    """The same at the instant of that sample, see `CausalLaw.instant_error`."""
    terms: tuple[ProgramTerm, ...]

    @property
    def n_program(self) -> int:
        """Numbers in a row of the table of the program."""
        return sum(term.arguments[0].size for term in self.terms)


def trace_law(law: CausalLaw, reference: Reference) -> TracedLaw:
    """Trace a step of a law for motions sampled as `reference` is.

    Raises:
        FFGymError: if the law does something that has no form in C; the message says what.
    """
    law.check_joints(reference)
    window = Window.along(reference, law.preview)[0]
    n, size = law.n_joints, law.initial_memory(window).shape[-1]
    graph, terms = Graph(1), list[ProgramTerm]()
    given = {name: _given(graph, name, (law.preview + 1, n)) for name in WINDOW}
    try:
        traced: Any = _with_symbols(law, graph, terms)
        before = _given(graph, "memory", (size,))
        torque, memory = traced.step(before, Window(**given, dt=window.dt))
        own, instant = traced.own_error(before, Window(**given, dt=window.dt)), traced.instant_error(before)
    except Exception as error:  # formulas may do with arrays what symbols do not bear, and say so in any way
        raise no_form(law, error) from error
    return TracedLaw(
        law=law,
        dt=window.dt,
        graph=graph,
        torque=_numbers(graph, torque),
        memory=_numbers(graph, memory),
        own_error=(_numbers(graph, own[0]), _numbers(graph, own[1])),
        instant_error=(_numbers(graph, instant[0]), _numbers(graph, instant[1])),
        terms=tuple(terms),
    )


def no_form(law: CausalLaw, error: Exception) -> FFGymError:
    """Error for a law that has no form in C, from what its step could not do."""
    reason = str(error) if isinstance(error, Untraceable) else f"what symbols cannot do ({error})"
    return FFGymError(
        f"Law {law.name!r} has no form in C: its step needs {reason}. Its torques along one motion can be written as a "
        "table: ffgym export table."
    )


def _given(graph: Graph, name: str, shape: tuple[int, ...]) -> Symbols:
    """Array of symbols that stand in an array of C, row by row."""
    nodes = np.empty(shape, dtype=object)
    for k, place in enumerate(np.ndindex(shape)):
        nodes[place] = graph.make("given", value=(name, k), fixed=False)
    return Symbols.of(graph, nodes)


def _numbers(graph: Graph, values: Any) -> tuple[Node, ...]:
    return tuple(graph.cast(node_of(graph, value), "number") for value in np.asarray(values, dtype=object).flat)


def _with_symbols(part: Any, graph: Graph, terms: list[ProgramTerm]) -> Any:
    """Copy of a law, and of what it is made of, that can be asked at symbols."""
    if isinstance(part, RigidArm):
        return _TracedArm(part, graph, terms)
    if isinstance(part, SplineBasis):
        return TracedBasis(knots=part.knots, order=part.order)
    if not is_dataclass(part) or isinstance(part, type):
        return part
    found = {field.name: getattr(part, field.name) for field in fields(part) if field.init}
    changed = {name: _with_symbols(value, graph, terms) for name, value in found.items()}
    changed = {name: value for name, value in changed.items() if value is not found[name]}
    return replace(part, **changed) if changed else part


class _TracedArm(RigidArm):
    """Rigid dynamics that are asked at symbols: the answers come from the table of the program."""

    def __init__(self, arm: RigidArm, graph: Graph, terms: list[ProgramTerm]) -> None:
        self.__dict__.update(vars(arm))
        self._arm, self._graph, self._terms = arm, graph, terms

    def inverse_dynamics(self, q: Array, dq: Array, ddq: Array, *, gravity: bool = False) -> Array:
        """Torque of the links from the table."""
        return self._term(lambda *rows: self._arm.inverse_dynamics(*rows, gravity=gravity), q, dq, ddq)

    def spring_torque(self, q: Array) -> Array:
        """Torque of springs between links from the table; none without springs."""
        if not self._arm.robot.springs:
            return np.zeros(q.shape)
        return self._term(self._arm.spring_torque, q)

    def gravity_torque(self, q: Array) -> Array:
        """Torque of gravity from the table."""
        return self._term(self._arm.gravity_torque, q)

    def _term(self, function: Callable[..., Array], *arguments: Any) -> Any:
        first = sum(term.arguments[0].size for term in self._terms)
        plain = tuple(np.asarray(argument, dtype=object) for argument in arguments)
        self._terms.append(ProgramTerm(function=function, arguments=plain, first=first))
        found = [self._graph.make("given", value=("program", first + k), fixed=False) for k in range(plain[0].size)]
        return Symbols.of(self._graph, np.array(found, dtype=object).reshape(plain[0].shape))


class TracedBasis(SplineBasis):
    """B-splines in arithmetic, where those for numbers come from a compiled function of SciPy."""

    def active(self, motor_dq: Array) -> tuple[Array, IntArray]:
        """Evaluate the splines that are not zero by the recursion of Cox and de Boor, thesis (3.11)."""
        inside = np.clip(motor_dq, self.knots[0], self.knots[-1])
        interval: Any = np.zeros_like(inside)
        for knot in self.knots[1:-1]:
            interval = interval + (inside >= knot).astype(np.float64)

        def knot_at(step: int) -> Any:  # `step` knots on from the left end of the interval
            row = np.broadcast_to(self.clamped, (*inside.shape, len(self.clamped)))
            places: Any = (interval + float(self.order - 1 + step))[..., None]
            return np.take_along_axis(row, places, axis=-1)[..., 0]

        values = [np.ones_like(inside)]
        for degree in range(1, self.order):
            shares = []  # of the splines one degree below, in those that begin at the same knot
            for k in range(degree):
                low, high = knot_at(k + 1 - degree), knot_at(k + 1)
                shares.append((inside - low) / (high - low))
            falling = [value * (1.0 - share) for value, share in zip(values, shares, strict=True)]
            rising = [value * share for value, share in zip(values, shares, strict=True)]
            values = [falling[0], *(b + a for a, b in zip(rising[:-1], falling[1:], strict=True)), rising[-1]]
        places = [interval + float(k) for k in range(self.order)]
        return np.stack(values, axis=-1), np.stack(places, axis=-1)


def tabulate_program(traced: TracedLaw, reference: Reference) -> Array:
    """Compute the terms of a law along a program, a row for each step, shape (T - 1, n).

    Raises:
        FFGymError: if a term depends on what the law remembers, so that no table has it.
    """
    windows = Window.along(reference, traced.law.preview)
    steps = len(windows.q)
    known = {name: getattr(windows, name).reshape(steps, -1) for name in WINDOW}
    table = np.zeros((steps, traced.n_program))
    for term in traced.terms:
        nodes = [[node_of(traced.graph, value) for value in rows.flat] for rows in term.arguments]
        try:
            values = evaluate(traced.graph, [node for row in nodes for node in row], known | {"program": table})
        except KeyError as error:
            raise FFGymError(
                f"Law {traced.law.name!r} asks for rigid dynamics at what it remembers ({error}), which no table of a "
                "program has. Write its torques as a table: ffgym export table."
            ) from error
        rows = np.stack([np.broadcast_to(value, steps) for value in values], axis=1)
        n = term.arguments[0].shape[-1]
        parts = np.split(rows, len(term.arguments), axis=1)
        found = term.function(*(np.ascontiguousarray(part).reshape(-1, n) for part in parts))
        table[:, term.first : term.first + found.size // steps] = found.reshape(steps, -1)
    return table


def evaluate(graph: Graph, wanted: Sequence[Node], known: dict[str, Array]) -> list[Any]:
    """Compute nodes in numpy where arrays (T, K) are known by name; (T,) or a number each."""
    values: dict[Node, Any] = {}
    for node in reachable(graph, wanted):
        arguments = [values[argument] for argument in node.arguments]
        if node.operation == "number":
            values[node] = float.fromhex(node.value)
        elif node.operation == "given":
            name, k = node.value
            values[node] = known[name][..., k]
        elif node.operation == "where":
            values[node] = np.where(*arguments)
        elif node.operation == "pick":
            at = np.clip(arguments[0], 0, len(arguments) - 2).astype(int)
            values[node] = np.choose(at, np.broadcast_arrays(*arguments[1:]))
        else:
            values[node] = OPERATIONS[node.operation].function(*arguments)
    return [values[node] for node in wanted]


def reachable(graph: Graph, wanted: Iterable[Node]) -> list[Node]:
    """List nodes that others are made of, and these, each after its arguments."""
    needed, stack = set(), list(wanted)
    while stack:
        node = stack.pop()
        if node not in needed:
            needed.add(node)
            stack.extend(node.arguments)
    return [node for node in graph.nodes.values() if node in needed]
