"""Graphs as C: joints that are computed alike become one loop over joints, all else single statements.

A *row* is a tuple of nodes, one per joint. Rows whose nodes do the same with rows of the same kind are computed in a
loop; rows of nodes that differ from joint to joint (coupled drives) are gathered from single statements. Loops and
single statements alternate in phases, so that each has what it needs.
"""

import math
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TypeVar

from ffgym.simulation.plant.compiled.operations import OPERATIONS
from ffgym.simulation.plant.compiled.tracing import Node, Untraceable

Row = tuple[Node, ...]
Item = Row | Node
_Key = TypeVar("_Key", bound=Hashable)


class _Cycle(Exception):
    """Rows that need each other, as a joint needs the result of the joint before it."""


def _in_order(wanted: Iterable[_Key], needs: Callable[[_Key], Iterable[_Key]]) -> list[_Key]:
    """List all that is needed, each after what it needs itself."""
    done: dict[_Key, None] = {}
    open_ones: set[_Key] = set()
    stack = [*wanted][::-1]
    while stack:
        item = stack[-1]
        if item in done:
            stack.pop()
            continue
        missing = [need for need in needs(item) if need not in done]
        if not missing:
            done[item] = None
            open_ones.discard(item)
            stack.pop()
        elif item in open_ones:
            raise _Cycle
        else:
            open_ones.add(item)
            stack.extend(reversed(missing))
    return list(done)


def _kind(row: Row) -> str:
    """Say how the nodes of a row are alike: same, table, given, loop, or gather where they are not."""
    first = row[0]
    if all(node is first for node in row):
        return "same"
    if any(
        (n.operation, n.gives, len(n.arguments)) != (first.operation, first.gives, len(first.arguments)) for n in row
    ):
        return "gather"
    if first.operation == "number":
        return "table"
    if first.operation == "given":
        return "given" if _stride(row) is not None else "gather"
    return "loop"


def _stride(row: Row) -> int | None:
    """Distance of the places of a row of given numbers; None if they do not stand in one array at even distances."""
    names, places = {node.value[0] for node in row}, [node.value[1] for node in row]
    strides = {after - before for before, after in pairwise(places)}
    return strides.pop() if len(names) == 1 and len(strides) == 1 else None


def _children(row: Row) -> list[Row]:
    return list(zip(*(node.arguments for node in row), strict=True)) if _kind(row) == "loop" else []


@dataclass(eq=False)
class _Text:
    """Statements of a function, and the tables that it reads."""

    n: int
    """Number of joints."""
    lines: list[str] = field(default_factory=list)
    tables: dict[tuple[tuple[str, ...], ...], str] = field(default_factory=dict)

    def table(self, rows: Sequence[Sequence[str]]) -> str:
        """Name of a table of numbers (joints, columns)."""
        return self.tables.setdefault(tuple(map(tuple, rows)), f"table{len(self.tables)}")

    def declarations(self) -> list[str]:
        """Text of the tables."""
        found = []
        for rows, name in self.tables.items():
            width = len(rows[0])
            shape = f"[{len(rows)}]" + (f"[{width}]" if width > 1 else "")
            values = [row[0] if width == 1 else "{" + ", ".join(row) + "}" for row in rows]
            found.append(f"static const double {name}{shape} = {{{', '.join(values)}}};")
        return found


@dataclass(frozen=True)
class Output:
    """Row of results, and where its numbers go."""

    array: str
    """Name of an array of C."""
    first: int
    """Place of the first number."""
    stride: int
    """Distance of the places."""
    row: Row


def write_step(outputs: Sequence[Output], n: int) -> tuple[list[str], list[str]]:
    """Write C that computes outputs for N joints; returns declarations of tables, and statements of the function."""
    text = _Text(n)
    try:
        _Rolled([output.row for output in outputs], text).write(outputs)
    except _Cycle:  # one statement for each number of each joint
        text = _Text(1)
        singles = [
            Output(output.array, output.first + j * output.stride, 1, (node,))
            for output in outputs
            for j, node in enumerate(output.row)
        ]
        _Rolled([output.row for output in singles], text).write(singles)
    return text.declarations(), text.lines


def count_gathered(outputs: Sequence[Output]) -> int:
    """Count rows that differ from joint to joint, among all that are needed for some outputs."""
    return sum(_kind(row) == "gather" for row in _in_order([output.row for output in outputs], _children))


def literal(value: float) -> str:
    """Number in C, all of its bits."""
    if value != value:
        raise Untraceable("a number that is none")
    text = repr(abs(value)).replace("inf", "INFINITY")
    return f"(-{text})" if math.copysign(1.0, value) < 0 else text


class _Rolled:
    """Rows of outputs, and phases in which they are computed: even ones are single statements, odd ones loops."""

    def __init__(self, outputs: Sequence[Row], text: _Text) -> None:
        self._text = text
        self._lanes: dict[Node, tuple[Row, int]] = {}
        rows = _in_order(outputs, _children)
        for row in rows:
            if _kind(row) == "loop":
                self._lanes.update({node: (row, j) for j, node in enumerate(row)})
        wanted: list[Item] = [*rows]
        self._order = _in_order(wanted, self._needs)
        self._phase: dict[Item, int] = {}
        for item in self._order:
            self._phase[item] = self._find_phase(item)
        self._names: dict[Item, str] = {item: f"v{k}" for k, item in enumerate(self._order)}
        # loops whose numbers are needed outside their own
        self._kept: set[Item] = set(outputs)
        for item in self._order:
            self._kept |= {need for need in self._needs(item) if self._phase[need] != self._phase[item]}

    def _needs(self, item: Item) -> list[Item]:
        if isinstance(item, Node):
            if item in self._lanes:
                return [self._lanes[item][0]]
            return list(item.arguments)
        kind = _kind(item)
        if kind == "same":
            return [item[0]]
        if kind == "gather":
            return list(item)
        return list(_children(item))

    def _find_phase(self, item: Item) -> int:
        earliest = max((self._phase[need] for need in self._needs(item)), default=0)
        loops = not isinstance(item, Node) and _kind(item) == "loop"
        return earliest + (earliest % 2 != loops)

    def write(self, outputs: Sequence[Output]) -> None:
        """Write all phases, then the outputs."""
        lines, n = self._text.lines, self._text.n
        for phase in range(max(self._phase.values(), default=0) + 1):
            items = [item for item in self._order if self._phase[item] == phase]
            if phase % 2 == 0:
                for item in items:
                    self._write_single(item)
                continue
            loops = [item for item in items if isinstance(item, tuple)]
            lines += [f"double {self._names[row]}_of[{n}];" for row in loops if row in self._kept]
            lines.append(f"for (int j = 0; j < {n}; ++j) {{")
            for row in loops:
                name = self._names[row]
                lines.append(f"    const {_type(row[0])} {name} = {self._expression(row)};")
                if row in self._kept:
                    lines.append(f"    {name}_of[j] = {name};")
            lines.append("}")
        lines.append(f"for (int j = 0; j < {n}; ++j) {{")
        lines += [f"    {_place(o.array, o.first, o.stride)} = {self._of(o.row, -1)};" for o in outputs]
        lines.append("}")

    def _write_single(self, item: Item) -> None:
        """Write statements outside loops."""
        name, lines = self._names[item], self._text.lines
        if isinstance(item, tuple):
            if _kind(item) == "gather":
                values = ", ".join(self._single(node) for node in item)
                lines.append(f"const double {name}_of[{self._text.n}] = {{{values}}};")
        elif item not in self._lanes and item.operation not in ("number", "given"):
            arguments = [self._single(argument) for argument in item.arguments]
            lines.append(f"const {_type(item)} {name} = {self._apply(item, arguments, [item])};")

    def _expression(self, row: Row) -> str:
        children = _children(row)
        if row[0].operation == "pick":
            return self._pick(self._of(children[0], self._phase[row]), children[1:])
        return self._apply(row[0], [self._of(child, self._phase[row]) for child in children], row)

    def _apply(self, node: Node, arguments: Sequence[str], row: Sequence[Node]) -> str:
        if node.operation == "where":
            return f"{arguments[0]} ? {arguments[1]} : {arguments[2]}"
        if node.operation == "pick":
            return self._pick(arguments[0], [(argument,) for argument in row[0].arguments[1:]], single=True)
        return OPERATIONS[node.operation].c.format(*arguments)

    def _pick(self, index: str, rows: Sequence[Row], *, single: bool = False) -> str:
        """Write a look-up in a table; an index outside is the nearest."""
        if any(node.operation != "number" for row in rows for node in row):
            raise Untraceable("a choice by number between results")
        columns = [[literal(float.fromhex(node.value)) for node in row] for row in rows]
        table = self._text.table(list(zip(*columns, strict=True)))
        return f"{table}[{0 if single else 'j'}][(int)fmin(fmax({index}, 0.0), {len(rows) - 1}.0)]"

    def _of(self, row: Row, phase: int) -> str:
        """Name of a row's number of joint j, in a loop of a phase."""
        kind = _kind(row)
        if kind == "same":
            return self._single(row[0])
        if kind == "table":
            return f"{self._text.table([[literal(float.fromhex(node.value))] for node in row])}[j]"
        if kind == "given":
            name, first = row[0].value
            return _place(name, first, _stride(row) or 0)
        name = self._names[row]
        return name if kind == "loop" and self._phase[row] == phase else f"{name}_of[j]"

    def _single(self, node: Node) -> str:
        """Name of a number outside loops."""
        if node.operation == "number":
            return literal(float.fromhex(node.value))
        if node.operation == "given":
            return f"{node.value[0]}[{node.value[1]}]"
        if node in self._lanes:
            row, j = self._lanes[node]
            return f"{self._names[row]}_of[{j}]"
        return self._names[node]


def _place(array: str, first: int, stride: int) -> str:
    """Number of joint j in an array of C."""
    return f"{array}[{first} + j]" if stride == 1 else f"{array}[{first} + {stride} * j]"


def _type(node: Node) -> str:
    return "double" if node.gives == "number" else "int"
