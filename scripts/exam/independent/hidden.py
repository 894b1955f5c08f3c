"""Effects that are hidden in machines of the independent plant, in equations of its own, and their names."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.core.errors import check_choice
from ffgym.core.types import Array
from ffgym.robot import RobotDescription
from scripts.exam.equations import Clue
from scripts.exam.independent.arm import join
from scripts.exam.independent.machine import Numbers, with_fault
from scripts.exam.independent.sensors import Columns, View
from scripts.exam.tasks import Row, Truth

_LIMIT_OF_OFFSET = 0.1
"""Largest offset of a torque [N m]: of an effect that the library finds plausible."""

Changed = tuple[Numbers, View]
"""A machine, and how its tracker sees it."""


@dataclass(frozen=True, eq=False)
class Kind:
    """A kind of effect that may be hidden."""

    answer: str
    """Name in the library; empty outside it."""
    full: "Full"
    """Largest size on a joint, with a sign by chance where it may have two."""
    change: "Change"
    """A machine with an effect of that size and shape on a joint."""
    numbers: Mapping[str, float | str] = field(default_factory=dict)
    """Its numbers by the names of the library, "size", "cycles" and the "way" x, y, z among them; nothing where its
    equation is another one."""
    needs: tuple[str, ...] = ()
    """'elastic' joints, a 'tracker', 'temperature', or a 'neighbour'."""
    at_machine: bool = False
    """True for a fault of the machine as a whole."""
    of_number: bool = False
    """True if its size is the relative error of a number that is described."""
    rows: tuple[Row, ...] = ()
    """Kinds of questions in which it is hidden alone; empty for those of all effects."""

    @property
    def asked_in(self) -> tuple[Row, ...]:
        """Kinds of questions in which it is hidden."""
        return self.rows or (("single",) if self.answer else ("outside",))


@dataclass(frozen=True, kw_only=True, eq=False)
class Shape:
    """Numbers of an effect beside its place and its size."""

    cycles: float = 1.0
    """In a turn of the motor, or [1/rad] of the joint."""
    frequency: float = 1.0
    """[Hz]."""
    way: Array
    """Direction, of unit length, shape (3,)."""


Full = Callable[[RobotDescription, int, np.random.Generator], float]
Change = Callable[[Changed, int, float, Shape], Changed]


@dataclass(frozen=True, kw_only=True, eq=False)
class Concealed:
    """An effect as it is hidden."""

    name: str
    """Name of the effect, see `KINDS`."""
    index: int
    """Index of its joint."""
    size: float
    shape: Shape
    joint: str
    """Empty for the machine as a whole."""
    beside: Mapping[str, float] = field(default_factory=dict)
    """Errors of the description that add to its numbers: one number is off by both, and they cannot be told apart."""

    @property
    def kind(self) -> Kind:
        """Kind of the effect."""
        return KINDS[self.name]

    @property
    def answer(self) -> str:
        """Name that a diagnosis should give; empty outside the library."""
        return self.kind.answer

    def clue(self, robot: RobotDescription) -> Clue | None:
        """Make the clue of an effect outside the library."""
        if self.answer:
            return None
        if self.name == "neighbour":
            other = robot.joints[(self.index + 1) % robot.n_joints]
            return Clue(words=("angle", "position"), joint=other)
        return Clue(words=("time",), frequency=self.shape.frequency)

    def numbers(self, robot: RobotDescription) -> dict[str, float]:
        """Parameters by the names that causes have."""
        way = dict(zip("xyz", (self.size * self.shape.way).tolist(), strict=True))
        known = {"size": self.size, "cycles": self.shape.cycles} | way
        numbers = {name: known[one] if isinstance(one, str) else one for name, one in self.kind.numbers.items()}
        return {name: float(value) + self.beside.get(name, 0.0) for name, value in numbers.items()}

    def truth(self, robot: RobotDescription, loudness: float) -> Truth:
        """Describe the hidden effect for the marks."""
        return Truth(
            effect=self.name,
            answer=self.answer,
            joint=self.joint,
            is_foreign=not self.kind.numbers,
            loudness=loudness,
            numbers=self.numbers(robot),
        )

    def on(self, machine: Changed) -> Changed:
        """A machine that has it."""
        return self.kind.change(machine, self.index, self.size, self.shape)


def conceal(name: str, robot: RobotDescription, rng: np.random.Generator, share: float = 1.0) -> Concealed:
    """An effect on a joint by chance, as large as a share of what is plausible.

    Raises:
        FFGymError: if there is no such kind.
    """
    kind = KINDS[check_choice("kind of effect", name, list(KINDS))]
    index = int(rng.integers(robot.n_joints))
    way = rng.standard_normal(3)
    cycles = np.exp(rng.uniform(np.log(2), np.log(15))) if name == "waves" else float(rng.choice([2, 4, 6, 8, 12, 24]))
    shape = Shape(cycles=float(cycles), frequency=float(rng.uniform(3, 12)), way=way / np.linalg.norm(way))
    size = share * kind.full(robot, index, rng)
    joint = "" if kind.at_machine else robot.joints[index]
    return Concealed(name=name, index=index, size=size, shape=shape, joint=joint)


def possible(robot: RobotDescription, columns: Columns) -> tuple[str, ...]:
    """Kinds that a machine can have, and its log can show."""
    there = {
        "elastic": not robot.drive.is_rigid.any(),
        "tracker": columns.tracker,
        "temperature": columns.temperature,
        "neighbour": robot.n_joints > 1,
    }
    return tuple(name for name, kind in KINDS.items() if all(there[need] for need in kind.needs))


def _up(limit: float | Callable[[RobotDescription, int], float], *, either: bool = False) -> Full:
    """A size, or one that a joint of a robot has; of either sign by chance if it may have both."""

    def full(robot: RobotDescription, j: int, rng: np.random.Generator) -> float:
        sign = float(rng.choice([-1.0, 1.0])) if either else 1.0
        return sign * (limit(robot, j) if callable(limit) else limit)

    return full


def _either(limit: float | Callable[[RobotDescription, int], float]) -> Full:
    return _up(limit, either=True)


def _of_coulomb(share: float, most: float = np.inf) -> Callable[[RobotDescription, int], float]:
    return lambda robot, j: min(most, share * float(robot.friction.coulomb[j]))


def _payload(robot: RobotDescription, j: int) -> float:
    return float(robot.tool.mass) if robot.tool is not None else 1.0


def _balance(robot: RobotDescription, j: int) -> float:
    return min(100.0, 0.05 * float(robot.drive.peak_torque[j] * abs(robot.drive.gear_ratio[j])))


def _larger(*names: str, of_coulomb: bool = False) -> Change:
    """Numbers of a joint that are larger by a share of themselves, or of the Coulomb torque."""

    def change(machine: Changed, j: int, size: float, shape: Shape) -> Changed:
        numbers, view = machine
        values = {name: getattr(numbers, name).copy() for name in names}
        for value in values.values():
            value[:, j] = value[:, j] + size * numbers.coulomb[:, j] if of_coulomb else value[:, j] * (1 + size)
        return replace(numbers, **values), view

    return change


def _fault(name: str, *, cycles: str = "", frequency: str = "") -> Change:
    def change(machine: Changed, j: int, size: float, shape: Shape) -> Changed:
        more = ({cycles: shape.cycles} if cycles else {}) | ({frequency: shape.frequency} if frequency else {})
        return with_fault(machine[0], j, **{name: size}, **more), machine[1]

    return change


def _blocks(machine: Changed, j: int, size: float, shape: Shape) -> Changed:
    """Another contact, which has no size."""
    return with_fault(machine[0], j, blocks=1.0), machine[1]


def _stiffness(machine: Changed, j: int, size: float, shape: Shape) -> Changed:
    numbers, view = _larger("stiffness")(machine, j, size, shape)
    damping = numbers.damping.copy()
    damping[:, j] *= np.sqrt(1 + size)
    return replace(numbers, damping=damping), view


def _growth(machine: Changed, j: int, size: float, shape: Shape) -> Changed:
    """Stiffer by a share at the deflection that the largest torque gives."""
    numbers, view = machine
    at = float(np.abs(numbers.gear_ratio[0, j]) * 10 * numbers.coulomb[0, j] / numbers.stiffness[0, j])
    return with_fault(numbers, j, growth=size, growth_at=at), view


def _heavier(machine: Changed, j: int, size: float, shape: Shape) -> Changed:
    """A point mass at the tool centre point."""
    numbers, view = machine
    bodies = numbers.bodies
    mass, com, inertia = bodies.mass.copy(), bodies.com.copy(), bodies.inertia.copy()
    for b in range(len(mass)):
        last = (mass[b, -1], com[b, -1], inertia[b, -1])
        mass[b, -1], com[b, -1], inertia[b, -1] = join(last, (size, bodies.tool_point[b], np.zeros((3, 3))))
    return replace(numbers, bodies=replace(bodies, mass=mass, com=com, inertia=inertia)), view


def _change_view(name: str) -> Change:
    def change(machine: Changed, j: int, size: float, shape: Shape) -> Changed:
        numbers, view = machine
        value: Any = size if name == "latency" else getattr(view, name) + size * shape.way
        return numbers, replace(view, **{name: value})

    return change


def _at_tracker(answer: str, full: float, name: str, numbers: Mapping[str, float | str]) -> Kind:
    """Make a kind that changes how the tracker sees the tool."""
    return Kind(answer, _up(full), _change_view(name), numbers, needs=("tracker",), at_machine=True)


def _vector(name: str) -> Mapping[str, str]:
    return {f"{name}.{axis}": axis for axis in "xyz"}


def _change_number(answer: str, full: Full, change: Change, numbers: Mapping[str, float | str], *needs: str) -> Kind:
    """A number that is described."""
    return Kind(answer, full, change, numbers, needs=needs, of_number=True)


_CHANGE: Mapping[str, float | str] = {"change": "size"}
_WAVE: Mapping[str, float | str] = {"cycles": "cycles", "phase": 0.0}
_ONCE: Mapping[str, float | str] = {"amplitude": "size", "cycles": 1.0, "phase": 0.0}
_PAYLOAD: Mapping[str, float | str] = {"mass": "size", "offset.x": 0.0, "offset.y": 0.0, "offset.z": 0.0, "radius": 0.0}

KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "coulomb": _change_number(
            "coulomb_level", _either(0.3), _larger("coulomb", "breakaway", of_coulomb=True), _CHANGE
        ),
        "viscous": _change_number("viscous_level", _either(0.5), _larger("viscous"), _CHANGE),
        "peak": Kind(
            "stribeck_peak", _up(0.8), _larger("breakaway", of_coulomb=True), {"level": "size", "velocity": 0.0}
        ),
        "presliding": _change_number(
            "presliding", _up(1.5), _larger("presliding"), {"stiffness": "size", "damping": 0.0}
        ),
        "blocks": Kind("presliding", _up(1.0), _blocks),
        "asymmetry": Kind("asymmetry", _either(0.2), _fault("asymmetry"), {"coulomb": "size", "viscous": 0.0}),
        "load_share": Kind("load_friction", _up(0.15), _fault("load_share"), {"share": "size"}),
        "bend": Kind("nonlinear_viscous", _up(0.4), _fault("bend")),
        "warm": Kind("temperature_friction", _up(0.8), _fault("warm"), needs=("temperature",)),
        "wear": Kind("coulomb_drift", _either(3.0), _fault("wear")),
        "waves": Kind("position_friction", _up(0.2), _fault("waves", cycles="wave_cycles"), {"share": "size", **_WAVE}),
        "stiffness": _change_number("joint_stiffness", _either(0.3), _stiffness, _CHANGE, "elastic"),
        "growth": Kind("hardening", _up(1.0), _growth, needs=("elastic",)),
        "gap": Kind("backlash", _up(3e-4), _fault("gap"), {"half_gap": "size"}, needs=("elastic",)),
        "behind": Kind("arm_friction", _up(0.9), _fault("behind"), needs=("elastic",), rows=("arm", "arm_blind")),
        "tooth": Kind("kinematic_error", _up(3e-4), _fault("tooth"), _ONCE, needs=("elastic",)),
        "payload": Kind("payload", _up(_payload), _heavier, _PAYLOAD, at_machine=True),
        "rotor": _change_number("rotor_inertia", _either(0.2), _larger("rotor"), _CHANGE),
        "torque_error": Kind(
            "torque_constant",
            _either(0.1),
            _fault("torque_error"),
            {"error": "size", "saturation": 0.0, "magnets": 0.0},
        ),
        "offset": Kind(
            "torque_offset", _either(_of_coulomb(0.3, _LIMIT_OF_OFFSET)), _fault("offset"), {"offset": "size"}
        ),
        "lag": Kind("torque_delay", _up(0.0015), _fault("lag")),
        "cogging": Kind(
            "cogging", _up(_of_coulomb(0.3)), _fault("cogging", cycles="cogging_cycles"), {"amplitude": "size", **_WAVE}
        ),
        "ripple": Kind(
            "torque_ripple", _up(0.05), _fault("ripple", cycles="ripple_cycles"), {"share": "size", **_WAVE}
        ),
        "resolver": Kind("resolver_ripple", _up(3e-3), _fault("resolver"), _ONCE),
        "balance": Kind(
            "gravity_term", _either(_balance), _fault("balance"), {"sine": 0.0, "cosine": "size", "stiffness": 0.0}
        ),
        "reflector": _at_tracker("tool_frame", 1.5e-3, "offset", _vector("offset")),
        "frame_shift": _at_tracker("tracker_frame", 1.5e-3, "shift", _vector("shift")),
        "frame_turn": _at_tracker("tracker_frame", 1e-3, "turn", _vector("turn")),
        "latency": _at_tracker("tracker_clock", 0.005, "latency", {"latency": "size", "drift": 0.0}),
        "brake": Kind("", _up(_of_coulomb(0.5)), _fault("brake", frequency="frequency")),
        "clock": Kind("", _up(_of_coulomb(0.3)), _fault("clock", frequency="frequency")),
        "neighbour": Kind("", _up(_of_coulomb(0.4)), _fault("neighbour"), needs=("neighbour",)),
    }
)
"""Every kind of effect, by the name that the exam gives it."""
