"""Formulas of a physics step of effects, traced: what is written before it and after it, as graphs.

What stands here is the order of things in a step. The formulas are those of `ffgym.effects` and of the modules beside
this package, which numpy computes where a formula cannot be traced.
"""

from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from ffgym.effects import ResolverEffect, TorqueEffect
from ffgym.effects.together import step
from ffgym.robot.drive import Drive
from ffgym.simulation.plant.compiled.tracing import Graph, Node, Traced, Untraceable
from ffgym.simulation.plant.engine_state import Addresses, hinge_torques
from ffgym.simulation.plant.reading import Reading
from ffgym.simulation.plant.resolvers import count_step, look_again, read_beyond, sum_errors

_READINGS = ("angle", "speed", "count")
"""Memories of resolvers, as in `Resolvers.memory`."""


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Structure of simulations for which code is made; numbers are no part of it."""

    kinds: tuple[tuple[type[TorqueEffect], int], ...]
    """Torque effects, and how many numbers each remembers of a joint."""
    resolver_kinds: tuple[type[ResolverEffect], ...]
    reads: bool
    """True if servos read resolvers."""
    dt: float
    names: tuple[str, ...]
    """Numbers of machines."""
    n_velocities: int
    key: bytes
    """Addresses and gears, as bytes, by which layouts are told apart."""
    at: Addresses = field(compare=False, hash=False)
    drive: Drive = field(compare=False, hash=False)

    @property
    def looks(self) -> bool:
        """True if what servos know differs from the truth."""
        return self.reads or bool(self.resolver_kinds)

    @property
    def memories(self) -> list[tuple[Any, int]]:
        """Memories in their order, and how many numbers each has of a joint; those of effects come first."""
        names = ("motor", *(_READINGS if self.reads else ()))
        return [*((k, size) for k, (_, size) in enumerate(self.kinds)), *((name, 1) for name in names)]

    @property
    def n_joints(self) -> int:
        """Number of joints N."""
        return len(self.at.is_elastic)


class _EngineArray:
    """Array of MuJoCo's state, (1, n) as of one robot, of which columns are taken.

    All of them have one width, that of the widest: slices of controls must name their end.
    """

    def __init__(self, graph: Graph, name: str, width: int) -> None:
        self._graph, self._name, self._places = graph, name, np.arange(width)
        self._known: dict[tuple[int, ...], Traced] = {}

    def __len__(self) -> int:
        return 1

    def copy(self) -> "_EngineArray":
        return self

    def reshape(self, *shape: int) -> Traced:
        return self._graph.given(self._name)

    def columns(self, key: Any) -> tuple[int, ...]:
        return tuple(self._places[key].tolist())

    def __getitem__(self, key: Any) -> Any:
        if not isinstance(key, tuple):
            return self
        places = self.columns(key[1])
        if places not in self._known:
            self._known[places] = self._graph.given(("engine", self._name, places))
        return self._known[places]

    def __setitem__(self, key: Any, values: Traced) -> None:
        self._known[self.columns(key[1])] = values


class _SymbolicEngine:
    """State of the engine as symbols, in place of `EngineState`."""

    def __init__(self, graph: Graph, layout: Layout) -> None:
        self.at, self.drive = layout.at, layout.drive
        places = [values for values in vars(layout.at).values() if isinstance(values, np.ndarray)]
        width = max(3 * layout.n_joints, *(int(values.max(initial=0)) + 1 for values in places))
        self.joints = tuple(_EngineArray(graph, name, width) for name in ("qpos", "qvel", "act", "ctrl"))
        self.time = _EngineArray(graph, "time", 1)
        outputs = tuple(_EngineArray(graph, name, width) for name in ("qfrc_actuator", "qacc"))
        self.outputs = None if layout.at.is_elastic.all() else outputs

    def motor(self) -> tuple[Any, Any]:
        """Motor angles [rad] and speeds [rad/s]."""
        angle, speed = (self.drive.motor_angle(values[:, self.at.motor_qpos]) for values in self.joints[:2])
        return angle, speed


def _symbolic(graph: Graph, kind: type[Any], source: tuple[Any, ...]) -> Any:
    """Effect whose parameters are symbols."""
    effect = object.__new__(kind)
    for name, known in kind.parameters().items():
        if known.per not in ("joint", "machine"):
            raise Untraceable(f"a parameter per {known.per}")
        object.__setattr__(effect, name, graph.given((*source, name), fixed=True))
    object.__setattr__(effect, "check_step", lambda dt: None)
    return effect


Stores = list[tuple[Any, Node]]
"""What a step writes: source of the place, and node."""


def _trace_look(graph: Graph, layout: Layout, engine: _SymbolicEngine) -> tuple[Stores, list[Node]]:
    """Trace what resolvers read after a physics step; returns what is written, and what servos know then."""
    numbers = {name: graph.given(("resolver", name), fixed=True) for name in ("every", "period", "step", "present")}
    effects = [_symbolic(graph, kind, ("resolver effect", k)) for k, kind in enumerate(layout.resolver_kinds)]
    angle, speed = engine.motor()
    before = tuple(graph.given(("memory", name, 0)) for name in ("angle", "speed"))
    count, due = count_step(graph.given(("memory", "count", 0)), numbers["every"])
    error = sum_errors(effects, angle, speed)
    read = look_again(before, due, angle + error.angle, numbers["step"], numbers["period"])
    known = read_beyond(read, angle, speed, error, numbers["present"].astype(bool))
    stores = [(("memory", name, 0), node) for name, node in zip(_READINGS, (*read, count), strict=True)]
    return [(place, _one(node)) for place, node in stores], [_one(angle + known.angle), _one(speed + known.speed)]


def _trace_apply(graph: Graph, layout: Layout, engine: _SymbolicEngine) -> Stores:
    """Trace torques of effects before a physics step, and errors of what servos know; returns what is written."""
    n, at, stores = layout.n_joints, layout.at, []
    controls = engine.joints[3]
    if layout.looks:
        effects = [_symbolic(graph, kind, ("resolver effect", k)) for k, kind in enumerate(layout.resolver_kinds)]
        angle, speed = engine.motor()
        error = sum_errors(effects, angle, speed)
        if layout.reads:
            read = tuple(graph.given(("memory", name, 0)) for name in ("angle", "speed"))
            present = graph.given(("resolver", "present"), fixed=True).astype(bool)
            error = read_beyond(read, angle, speed, error, present)
        for k, off in enumerate((error.angle, error.speed)):
            key = (slice(None), slice(k, 3 * n, 3))
            controls[key] = controls[key] - off
            stores.append((("engine", "ctrl", controls.columns(key[1])), _one(controls[key])))
    if layout.kinds:
        numbers = {name: graph.given(("machine", name), fixed=True) for name in layout.names}
        symbols: Any = engine  # in place of the engine's state
        state = Reading(symbols, slice(None), numbers, graph.given(("memory", "motor", 0)))
        effects = [_symbolic(graph, kind, ("effect", k)) for k, (kind, _) in enumerate(layout.kinds)]
        memories = [
            graph.given_memory([("memory", k, m) for m in range(size)]) for k, (_, size) in enumerate(layout.kinds)
        ]
        present = [graph.given(("present", k), fixed=True).astype(bool) for k in range(len(effects))]
        total, later = step(effects, state, memories, layout.dt, present)
        motor, turning, behind = hinge_torques(layout.drive, total)
        written: list[tuple[Any, Any]] = [
            (("memory", "motor", 0), motor),
            (("engine", "qfrc_applied", tuple(at.motor_qpos.tolist())), turning),
            (("engine", "qfrc_applied", tuple(at.deflection_of_joint.tolist())), behind),
        ]
        stores += [(place, _one(values)) for place, values in written if values is not None]
        for k, (before, memory) in enumerate(zip(memories, later, strict=True)):
            if not isinstance(memory, Traced) or memory.shape != before.shape:
                raise Untraceable("a memory of another shape")
            stores += [
                (("memory", k, m), graph.cast(node, "number"))
                for m, (node, old) in enumerate(zip(memory.nodes, before.nodes, strict=True))
                if node is not old
            ]
    return stores


def _one(values: Any) -> Node:
    if not isinstance(values, Traced) or values.nodes.ndim:
        raise Untraceable("a result that does not depend on the state, or is not one number per joint")
    return values.graph.cast(values.nodes[()], "number")


def trace_step(layout: Layout) -> tuple[Graph, Stores, tuple[Stores, list[Node]]]:
    """Trace a physics step.

    Returns:
        Graph; what is written before the step; what is written after it, with angles and speeds that servos know then.

    Raises:
        Untraceable: if a formula is no graph of elementwise operations.
    """
    graph = Graph(layout.n_joints)
    try:
        before = _trace_apply(graph, layout, _SymbolicEngine(graph, layout))
        after: tuple[Stores, list[Node]] = ([], [])
        if layout.reads:
            after = _trace_look(graph, layout, _SymbolicEngine(graph, layout))
    except Untraceable:
        raise
    except Exception as error:  # formulas may do with arrays what symbols do not bear, and say so in any way
        raise Untraceable(str(error)) from error
    return graph, before, after


@cache
def can_trace(layout: Layout) -> bool:
    """Tell if the formulas of a layout can be traced, and are the same each time they are asked."""
    try:
        first, second = trace_step(layout)[0], trace_step(layout)[0]
    except Untraceable:
        return False
    return first.describe() == second.describe()


def untraceable_kinds(layout: Layout) -> set[type[TorqueEffect] | type[ResolverEffect]] | None:
    """Return effects that cannot be traced; None if the rest of the step cannot be either."""
    bare = replace(layout, kinds=(), resolver_kinds=())
    if not can_trace(bare):
        return None
    kinds = {kind for kind, size in layout.kinds if not can_trace(replace(bare, kinds=((kind, size),)))}
    return kinds | {kind for kind in layout.resolver_kinds if not can_trace(replace(bare, resolver_kinds=(kind,)))}
