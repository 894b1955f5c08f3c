"""Functions of a compiled physics step: before each of MuJoCo's own, and for readings after the last one."""

import ctypes
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from ffgym.simulation.plant.compiled.code import JointPlace, LoopCode, Slots, compile_code, declarations
from ffgym.simulation.plant.compiled.engine_hook import FIELDS, data_offsets
from ffgym.simulation.plant.compiled.formulas import Layout, Stores, trace_step
from ffgym.simulation.plant.compiled.tracing import Graph, Node

CONTEXT = ("function", "numbers", "steps", "driven", "acceleration", "reading", "position", "length")
"""Entries of the table of a compiled step, before the addresses of memories."""


@dataclass(frozen=True, kw_only=True, eq=False)
class StepCode:
    """Compiled step of a layout."""

    graph: Graph
    slots: tuple[Node, ...]
    """Numbers that it wants of each joint, in their order."""
    module: Any
    on_step: int
    """Address of the function that MuJoCo calls."""
    finish: Any
    """Function that reads resolvers after the last step."""


@lru_cache(maxsize=256)
def compile_layout(layout: Layout) -> StepCode:
    """Compile the step of a layout.

    Raises:
        Untraceable: if a formula cannot be traced.
    """
    graph, before, (after, known) = trace_step(layout)
    slots, n = Slots(), layout.n_joints
    pointers = ["ptr %qpos", "ptr %qvel"]
    # before a physics step: torques
    apply = LoopCode("apply", n, slots)
    _write(apply, layout, before)
    arguments = [*pointers, *(f"ptr %{name}" for name in FIELDS[2:7]), "double %time"]
    functions = [(apply, arguments)]
    # after it: what resolvers read
    look = LoopCode("look", n, slots)
    if layout.reads:
        _write(look, layout, [*after, (("known", 0), known[0]), (("known", n), known[1])])
    functions.append((look, [*pointers, "ptr %known"]))
    text = [declarations(), *(code.constants() for code, _ in functions)]
    for code, names in functions:
        text.append(code.function(["ptr %context", "i64 %row", *names], _rows(layout, len(slots.places))))
    module = compile_code("\n".join([*text, _on_step(layout), _finish(layout)]))
    kind = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4, *[ctypes.c_int64] * 2)
    return StepCode(
        graph=graph,
        slots=tuple(slots.places),
        module=module,
        on_step=module.get_function_address("on_step"),
        finish=kind(module.get_function_address("finish")),
    )


def _write(code: LoopCode, layout: Layout, stores: Stores) -> None:
    """Write code that computes and stores; all is loaded before anything is stored."""
    sizes = dict(layout.memories)

    def place(source: Any) -> JointPlace | str:
        match source:
            case "time":
                return "%time"
            case "memory", name, part:
                return JointPlace(base=f"%memory.{name}", stride=sizes[name], offset=part)
            case "known", offset:
                return JointPlace(base="%known", offset=offset)
        _, name, addresses = source
        return JointPlace(base=f"%{name}", addresses=addresses)

    values = code.compute([node for _, node in stores], place)
    for value, (source, _) in zip(values, stores, strict=True):
        target = place(source)
        assert isinstance(target, JointPlace)
        code.store(value, target)


def _rows(layout: Layout, n_numbers: int) -> list[str]:
    """Write code that finds the numbers and memories of a robot."""
    entries = [("%numbers", 1, n_numbers)]
    entries += [(f"%memory.{name}", len(CONTEXT) + k, size) for k, (name, size) in enumerate(layout.memories)]
    lines = []
    for name, entry, size in entries:
        lines += [
            *_entry(f"{name}.all", entry),
            f"{name}.o = mul i64 %row, {size * layout.n_joints}",
            f"{name} = getelementptr double, ptr {name}.all, i64 {name}.o",
        ]
    return lines


def _entry(name: str, entry: int, kind: str = "ptr") -> list[str]:
    """Write code that loads an entry of the table of a compiled step."""
    return [f"{name}.e = getelementptr ptr, ptr %context, i64 {entry}", f"{name} = load {kind}, ptr {name}.e"]


def _on_step(layout: Layout) -> str:
    """Write code that MuJoCo calls before each physics step of a simulation."""
    offsets = data_offsets()
    lines = [f"%unread = alloca [{2 * layout.n_joints} x double]"]
    for name in (*FIELDS[:7], "time"):
        kind = "double" if name == "time" else "ptr"
        lines += [f"%{name}.a = getelementptr i8, ptr %data, i64 {offsets[name]}"]
        lines += [f"%{name}.d = load {kind}, ptr %{name}.a"]
    lines += [
        # physics steps since the rollout began
        *_entry("%steps", CONTEXT.index("steps")),
        "%step.p = getelementptr i64, ptr %steps, i64 %row",
        "%step = load i64, ptr %step.p",
        "%after = add i64 %step, 1",
        "store i64 %after, ptr %step.p",
        "%is_first = icmp eq i64 %step, 0",
    ]
    # outputs of the engine's last step: before the first one where it keeps them
    for name, entry in (("qfrc_actuator", "driven"), ("qacc", "acceleration")):
        lines += [
            *_entry(f"%{entry}", CONTEXT.index(entry)),
            f"%{entry}.o = mul i64 %row, {layout.n_velocities}",
            f"%{entry}.r = getelementptr double, ptr %{entry}, i64 %{entry}.o",
            f"%{name}.now = select i1 %is_first, ptr %{entry}.r, ptr %{name}.d",
        ]
    lines += ["br i1 %is_first, label %torques, label %look", "look:"]
    if layout.reads:
        lines += [
            "%ended = sub i64 %step, 1",
            "%known = call ptr @known_at(ptr %context, i64 %row, i64 %ended, ptr %unread)",
            "call void @look(ptr %context, i64 %row, ptr %qpos.d, ptr %qvel.d, ptr %known)",
        ]
    arguments = ", ".join(f"ptr %{name}.d" for name in FIELDS[:5])
    lines += [
        "br label %torques",
        "torques:",
        f"call void @apply(ptr %context, i64 %row, {arguments}, ptr %qfrc_actuator.now, ptr %qacc.now, double %time.d)",
        "ret void",
    ]
    return "define void @on_step(ptr %context, i64 %row, ptr %data) {\nentry:\n" + "\n".join(lines) + "\n}"


def _finish(layout: Layout) -> str:
    """Write code that reads resolvers after the last physics step, and finds the place for what servos know then."""
    entries = [line for name in ("reading", "position", "length") for line in _entry(f"%{name}", CONTEXT.index(name))]
    known = [
        *entries,
        "%place.p = getelementptr i64, ptr %position, i64 %row",
        "%place = load i64, ptr %place.p",
        "%length.i = ptrtoint ptr %length to i64",
        "%first = mul i64 %place, %length.i",
        "%sample = add i64 %first, %step",
        f"%offset = mul i64 %sample, {2 * layout.n_joints}",
        "%there = getelementptr double, ptr %reading, i64 %offset",
        "%is_none = icmp eq ptr %reading, null",
        "%target = select i1 %is_none, ptr %unread, ptr %there",
        "ret ptr %target",
    ]
    finish = [
        f"%unread = alloca [{2 * layout.n_joints} x double]",
        "%more = icmp sgt i64 %n, 0",
        "br i1 %more, label %loop, label %done",
        "loop:",
        "%k = phi i64 [0, %entry], [%next, %loop]",
        "%row.p = getelementptr i64, ptr %rows, i64 %k",
        "%row = load i64, ptr %row.p",
        "%offset = mul i64 %row, %stride",
        "%qpos.r = getelementptr double, ptr %qpos, i64 %offset",
        "%qvel.r = getelementptr double, ptr %qvel, i64 %offset",
        *_entry("%length", CONTEXT.index("length"), "i64"),
        "%ended = sub i64 %length, 1",
        "%known = call ptr @known_at(ptr %context, i64 %row, i64 %ended, ptr %unread)",
        "call void @look(ptr %context, i64 %row, ptr %qpos.r, ptr %qvel.r, ptr %known)",
        "%next = add i64 %k, 1",
        "%again = icmp slt i64 %next, %n",
        "br i1 %again, label %loop, label %done",
        "done:",
        "ret void",
    ]
    head = "ptr %context, ptr %rows, ptr %qpos, ptr %qvel, i64 %n, i64 %stride"
    return "\n".join(
        [
            "define ptr @known_at(ptr %context, i64 %row, i64 %step, ptr %unread) {\nentry:",
            *known,
            f"}}\ndefine void @finish({head}) {{\nentry:",
            *finish,
            "}",
        ]
    )
