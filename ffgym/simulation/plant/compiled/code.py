"""Machine code from graphs of formulas, by LLVM; without the package llvmlite there is none."""

import ctypes
import struct
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

from ffgym.core.provenance import is_installed
from ffgym.simulation.plant.compiled.operations import LIBRARY, OPERATIONS, library_symbol
from ffgym.simulation.plant.compiled.tracing import Node


@dataclass(eq=False)
class Slots:
    """Numbers that are the same at all physics steps, in the order of their places in a table (B, K, N)."""

    places: dict[Node, int] = field(default_factory=dict)

    def place(self, node: Node) -> int:
        """Place of a number."""
        return self.places.setdefault(node, len(self.places))


@dataclass(frozen=True, kw_only=True)
class JointPlace:
    """Address of a number of each joint: base pointer, and the index from it."""

    base: str
    """Name of a pointer in the code."""
    addresses: tuple[int, ...] | None = None
    """Index of each joint, below 0 for none; None stands for stride times the joint plus offset."""
    stride: int = 1
    offset: int = 0


class LoopCode:
    """Body of a loop over joints that computes nodes and stores them."""

    def __init__(self, name: str, n_joints: int, slots: Slots) -> None:
        self._name, self._n, self._slots = name, n_joints, slots
        self.lines: list[str] = []
        self.entry: list[str] = ["%nowhere = alloca double"]
        self._tables: dict[tuple[int, ...], str] = {}
        self._values: dict[Node, str] = {}
        self._count = 0

    def _new(self) -> str:
        self._count += 1
        return f"%v{self._count}"

    def compute(self, nodes: Iterable[Node], places: Callable[[Any], JointPlace | str]) -> list[str]:
        """Compute nodes; returns their names in the code.

        Args:
            nodes: to compute.
            places: where the sources of given nodes stand, or names of numbers in the code.
        """
        return [self._compute(node, places) for node in nodes]

    def _compute(self, wanted: Node, places: Callable[[Any], JointPlace | str]) -> str:
        stack = [wanted]
        while stack:
            node = stack[-1]
            if node in self._values:
                stack.pop()
                continue
            missing = [] if node.is_fixed else [a for a in node.arguments if a not in self._values]
            if missing:
                stack.extend(reversed(missing))
                continue
            self._values[node] = self._emit(node, places)
            stack.pop()
        return self._values[wanted]

    def _emit(self, node: Node, places: Callable[[Any], JointPlace | str]) -> str:
        if node.operation == "number":
            return _literal(float.fromhex(node.value))
        if node.is_fixed:
            name = self.load(JointPlace(base="%numbers", offset=self._slots.place(node) * self._n))
            return self._true(name) if node.gives == "truth" else name
        if node.operation == "given":
            place = places(node.value)
            return place if isinstance(place, str) else self.load(place)
        arguments = [self._values[argument] for argument in node.arguments]
        name = self._new()
        if node.operation == "where":
            kind = "i1" if node.gives == "truth" else "double"
            self.lines.append(f"{name} = select i1 {arguments[0]}, {kind} {arguments[1]}, {kind} {arguments[2]}")
        elif node.operation == "pick":
            others = self._row(node.arguments[2:], arguments[2:], places)
            self._pick(name, arguments[0], arguments[1], others, len(arguments) - 2)
        else:
            self.lines.append(OPERATIONS[node.operation].code.format(*arguments, r=name))
        return name

    def _true(self, number: str) -> str:
        name = self._new()
        self.lines.append(f"{name} = fcmp une double {number}, 0.0")
        return name

    def _row(self, nodes: Sequence[Node], values: Sequence[str], places: Callable[[Any], JointPlace | str]) -> str:
        """Write code that has values side by side in memory; returns the pointer to the first."""
        found = [places(node.value) if node.operation == "given" and not node.is_fixed else "" for node in nodes]
        first = found[0]
        if isinstance(first, JointPlace) and first.addresses is None:
            row = [replace(first, offset=first.offset + k) for k in range(len(found))]
            if found == row:  # as in what an effect remembers
                return self._pointer(first)
        name = f"{self._new()}.row"
        self.entry.append(f"{name} = alloca [{len(values)} x double]")
        for k, value in enumerate(values):
            self.lines.append(f"{name}.p{k} = getelementptr double, ptr {name}, i64 {k}")
            self.lines.append(f"store double {value}, ptr {name}.p{k}")
        return name

    def _pick(self, name: str, index: str, first: str, others: str, n: int) -> None:
        """Write code that takes the first value or one of n others, side by side; an index outside is the nearest."""
        self.lines += [
            f"{name}.i = call i64 @llvm.fptosi.sat.i64.f64(double {index})",
            f"{name}.b = sub i64 {name}.i, 1",
            f"{name}.h = call i64 @llvm.smin.i64(i64 {name}.b, i64 {n - 1})",
            f"{name}.l = call i64 @llvm.smax.i64(i64 {name}.h, i64 0)",
            f"{name}.p = getelementptr double, ptr {others}, i64 {name}.l",
            f"{name}.o = load double, ptr {name}.p",
            f"{name}.f = icmp sle i64 {name}.i, 0",
            f"{name} = select i1 {name}.f, double {first}, double {name}.o",
        ]

    def _pointer(self, place: JointPlace) -> str:
        name = self._new()
        if place.addresses is None:
            self.lines.append(f"{name}.s = mul i64 %joint, {place.stride}")
            self.lines.append(f"{name}.i = add i64 {name}.s, {place.offset}")
        else:
            table = self._tables.setdefault(place.addresses, f"@{self._name}.places{len(self._tables)}")
            self.lines.append(f"{name}.t = getelementptr i64, ptr {table}, i64 %joint")
            self.lines.append(f"{name}.i = load i64, ptr {name}.t")
        self.lines.append(f"{name} = getelementptr double, ptr {place.base}, i64 {name}.i")
        if place.addresses is not None and min(place.addresses) < 0:
            self.lines.append(f"{name}.there = icmp sge i64 {name}.i, 0")
            self.lines.append(f"{name}.else = select i1 {name}.there, ptr {name}, ptr %nowhere")
            return f"{name}.else"
        return name

    def load(self, place: JointPlace) -> str:
        """Load the number at a place; returns its name in the code."""
        pointer, name = self._pointer(place), self._new()
        self.lines.append(f"{name} = load double, ptr {pointer}")
        return name

    def store(self, value: str, place: JointPlace) -> None:
        """Store a number at a place."""
        self.lines.append(f"store double {value}, ptr {self._pointer(place)}")

    def function(self, arguments: Sequence[str], before: Sequence[str]) -> str:
        """Text of the function: its arguments, what comes before the loop, and the loop."""
        return "\n  ".join(
            [
                f"define void @{self._name}({', '.join(arguments)}) {{\nentry:",
                *self.entry,
                *before,
                "br label %loop\nloop:",
                "%joint = phi i64 [0, %entry], [%next, %loop]",
                *self.lines,
                "%next = add i64 %joint, 1",
                f"%more = icmp ult i64 %next, {self._n}",
                "br i1 %more, label %loop, label %done\ndone:",
                "ret void\n}",
            ]
        )

    def constants(self) -> str:
        """Text of the tables of addresses."""
        return "\n".join(
            f"{name} = private constant [{len(t)} x i64] [{', '.join(f'i64 {a}' for a in t)}]"
            for t, name in self._tables.items()
        )


def _literal(value: float) -> str:
    """Number in LLVM's language, all of its bits."""
    return f"0x{struct.pack('>d', value).hex()}"


def declarations() -> str:
    """Text of all functions that operations call."""
    intrinsics = ["fabs", "sqrt", "rint", "floor", "ceil", "trunc"]
    lines = [f"declare double @llvm.{name}.f64(double)" for name in intrinsics]
    lines += [
        "declare double @llvm.copysign.f64(double, double)",
        "declare i64 @llvm.fptosi.sat.i64.f64(double)",
        "declare i64 @llvm.smax.i64(i64, i64)",
        "declare i64 @llvm.smin.i64(i64, i64)",
    ]
    for name, n in LIBRARY.values():
        arguments = ", ".join(["double"] * n)
        lines.append(f"declare double @{library_symbol(name)}({arguments}) memory(none) nounwind willreturn")
    return "\n".join(lines)


def can_compile() -> bool:
    """Tell if there is a compiler: package llvmlite, with the functions of the C library."""
    return _compiler() is not None


@cache
def _compiler() -> Any:
    """LLVM for this processor, with the C library's functions; None without package llvmlite."""
    if not is_installed("llvmlite"):
        return None
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    try:
        library = ctypes.CDLL(None)
        for name, _ in LIBRARY.values():
            llvm.add_symbol(library_symbol(name), ctypes.cast(getattr(library, name), ctypes.c_void_p).value)
    except (OSError, TypeError, AttributeError):  # another kind of C library
        return None
    return llvm


def compile_code(text: str) -> Any:
    """Compile LLVM's language; returns the compiled module, which must be kept as long as its functions are used."""
    llvm = _compiler()
    module = llvm.parse_assembly(text)
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten(), opt=2, jit=True
    )
    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=2))
    builder.getModulePassManager().run(module, builder)
    engine = llvm.create_mcjit_compiler(module, machine)
    engine.finalize_object()
    return engine
