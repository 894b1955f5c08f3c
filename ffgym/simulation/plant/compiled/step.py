"""Compiled physics step of simulations, bound to their numbers and memories."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from mujoco import batch

from ffgym.core.types import Array, IntArray
from ffgym.simulation.plant.compiled.engine_hook import Marks, address
from ffgym.simulation.plant.compiled.formulas import Layout
from ffgym.simulation.plant.compiled.functions import CONTEXT, compile_layout
from ffgym.simulation.plant.compiled.operations import OPERATIONS
from ffgym.simulation.plant.compiled.tracing import Node


def evaluate(nodes: Sequence[Node], given: Callable[[Any], Array]) -> list[Any]:
    """Compute nodes with numpy, from what `given` returns for each source."""
    known: dict[Node, Any] = {}

    def value(node: Node) -> Any:
        if node not in known:
            arguments = [value(argument) for argument in node.arguments]
            if node.operation == "number":
                known[node] = np.float64(float.fromhex(node.value))
            elif node.operation == "given":
                known[node] = given(node.value)
            elif node.operation == "where":
                known[node] = np.where(*arguments)
            else:
                known[node] = OPERATIONS[node.operation].function(*arguments)
        return known[node]

    # machines without an effect have numbers that it need not bear
    with np.errstate(all="ignore"):
        return [value(node) for node in nodes]


class CompiledStep:
    """Compiled physics step of simulations, bound to their numbers and memories.

    Args:
        engine: simulations.
        layout: their structure.
        numbers: what each source gives, (B, N) or (B, 1).
        memories: of effects, (B, N, M) each, then of motors and resolvers, (B, N) each.
        outputs: generalised forces of actuators and accelerations that the engine keeps, None if it keeps none.

    Raises:
        Untraceable: if a formula cannot be traced.
    """

    def __init__(
        self,
        engine: batch.Batch,
        layout: Layout,
        numbers: Mapping[Any, Array],
        memories: Sequence[Array],
        outputs: tuple[Array, Array] | None,
    ) -> None:
        self._engine, self._layout = engine, layout
        self._code = code = compile_layout(layout)
        shape = (engine.nsim, layout.n_joints)

        def given(source: Any) -> Array:
            return code.graph.tables[source[1]] if source[0] == "table" else numbers[source]

        found = evaluate(code.slots, given)
        self._numbers = np.empty((shape[0], len(found), shape[1]))
        for k, values in enumerate(found):
            self._numbers[:, k] = values
        self._steps = np.zeros(shape[0], dtype=np.int64)
        self._position = np.arange(shape[0], dtype=np.int64)
        self._kept = (memories, outputs)  # arrays whose addresses the table has
        entries = {
            "function": code.on_step,
            "numbers": address(self._numbers),
            "steps": address(self._steps),
            "position": address(self._position),
        }
        if outputs is not None:
            entries["driven"], entries["acceleration"] = map(address, outputs)
        table = [entries.get(name, 0) for name in CONTEXT]
        self._context = np.array([*table, *map(address, memories)], dtype=np.int64)
        self._marks = Marks(engine, self._context)
        self._everyone = self._position.copy()
        # where states stand, for readings after the last step
        self._states = engine.bind("qpos").ctypes.data, engine.bind("qvel").ctypes.data
        self._stride = engine.state.strides[0] // engine.state.itemsize

    def rollout(
        self, controls: Array, record: tuple[str, ...], ids: IntArray | None, reading: Array | None
    ) -> dict[str, Array]:
        """Roll out controls (B', S, 3 N); `reading` (B', S, 2 N) takes what servos know after each step."""
        engine = self._engine
        rows = self._everyone if ids is None else np.ascontiguousarray(ids, dtype=np.int64)
        chosen = slice(None) if ids is None else rows
        self._steps[chosen], self._position[chosen] = 0, self._everyone[: len(rows)]
        self._context[CONTEXT.index("reading")] = 0 if reading is None else address(reading)
        self._context[CONTEXT.index("length")] = controls.shape[1]
        with self._marks.set(chosen):
            out: dict[str, Array] = engine.rollout(controls.shape[1], control=controls, record=record, ids=ids)
        if self._layout.reads:
            self._code.finish(self._context.ctypes.data, rows.ctypes.data, *self._states, len(rows), self._stride)
        return out
