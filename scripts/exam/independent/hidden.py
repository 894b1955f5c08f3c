"""Effects that are hidden in machines of the independent plant, in equations of its own, and their names."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, final

import numpy as np

from ffgym.core.errors import check_choice
from ffgym.core.types import Array
from ffgym.robot import RobotDescription
from scripts.exam.equations import Clue
from scripts.exam.independent.arm import joined
from scripts.exam.independent.machine import Numbers, with_fault
from scripts.exam.independent.sensors import Columns, View
from scripts.exam.paper import Truth

_LIMIT_OF_OFFSET = 0.1
"""Largest offset of a torque [N m]: of an effect that the library finds plausible."""

Changed = tuple[Numbers, View]
"""A machine, and how its tracker sees it."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Kind:
    """A kind of effect that may be hidden."""

    answer: str
    """Name in the library; empty outside it."""
    full: Callable[[RobotDescription, int, np.random.Generator], float]
    """Largest size on a joint, with a sign by chance where it may have two."""
    change: Callable[[Changed, int, float, "Shape"], Changed]
    """A machine with an effect of that size and shape on a joint."""
    told: Callable[[float, "Shape"], dict[str, float]] = lambda size, shape: {}
    """Its numbers by the names of the library; nothing where its equation is another one."""
    needs: tuple[str, ...] = ()
    """'elastic' joints, a 'tracker', 'temperature', or a 'neighbour'."""
    at_machine: bool = False
    """Whether it is of the machine as a whole."""
    of_number: bool = False
    """Whether its size is the relative error of a number that is described."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Shape:
    """What of an effect is neither its place nor its size."""

    cycles: float = 1.0
    """In a turn of the motor, or [1/rad] of the joint."""
    frequency: float = 1.0
    """[Hz]."""
    way: Array
    """Direction, of unit length, shape (3,)."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Concealed:
    """An effect as it is hidden."""

    name: str
    """See `KINDS`."""
    index: int
    """Of its joint."""
    size: float
    shape: Shape
    joint: str
    """Empty for the machine as a whole."""
    beside: Mapping[str, float] = field(default_factory=dict)
    """What errors of the description add to its numbers: one number is off by both, and nobody can tell them apart."""

    @property
    def kind(self) -> Kind:
        """What it is."""
        return KINDS[self.name]

    @property
    def answer(self) -> str:
        """Name that a diagnosis should give; empty outside the library."""
        return self.kind.answer

    @property
    def is_foreign(self) -> bool:
        """Whether its sizes do not compare with those of the library."""
        return not self.kind.told(self.size, self.shape)

    def clue(self, robot: RobotDescription) -> Clue | None:
        """What an answer must say of an effect outside the library."""
        if self.answer:
            return None
        if self.name == "neighbour":
            other = robot.joints[(self.index + 1) % robot.n_joints]
            return Clue(words=("angle", "position"), joint=other)
        return Clue(words=("time",), frequency=self.shape.frequency)

    def numbers(self, robot: RobotDescription) -> dict[str, float]:
        """Parameters by the names that causes have."""
        told = self.kind.told(self.size, self.shape)
        return {name: value + self.beside.get(name, 0.0) for name, value in told.items()}

    def truth(self, robot: RobotDescription, loudness: float) -> Truth:
        """What marks need of it."""
        return Truth(
            effect=self.name,
            answer=self.answer,
            joint=self.joint,
            is_foreign=self.is_foreign,
            loudness=loudness,
            numbers=self.numbers(robot),
        )

    def on(self, machine: Changed) -> Changed:
        """A machine that has it."""
        return self.kind.change(machine, self.index, self.size, self.shape)


def concealed(name: str, robot: RobotDescription, rng: np.random.Generator, share: float = 1.0) -> Concealed:
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


def _either(limit: float) -> Callable[[RobotDescription, int, np.random.Generator], float]:
    return lambda robot, j, rng: limit * float(rng.choice([-1.0, 1.0]))


def _up(limit: float) -> Callable[[RobotDescription, int, np.random.Generator], float]:
    return lambda robot, j, rng: limit


def _of_coulomb(limit: float) -> Callable[[RobotDescription, int, np.random.Generator], float]:
    return lambda robot, j, rng: limit * float(robot.friction.coulomb[j])


def _offset(robot: RobotDescription, j: int, rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0])) * min(_LIMIT_OF_OFFSET, 0.3 * float(robot.friction.coulomb[j]))


def _payload(robot: RobotDescription, j: int, rng: np.random.Generator) -> float:
    return float(robot.tool.mass) if robot.tool is not None else 1.0


def _balance(robot: RobotDescription, j: int, rng: np.random.Generator) -> float:
    peak = robot.drive.peak_torque[j] * abs(robot.drive.gear_ratio[j])
    return float(rng.choice([-1.0, 1.0])) * min(100.0, 0.05 * float(peak))


def _scaled(*names: str) -> Callable[[Changed, int, float, Shape], Changed]:
    """Numbers of a joint that are a share of themselves larger."""

    def change(machine: Changed, j: int, size: float, shape: Shape) -> Changed:
        numbers, view = machine
        values = {name: getattr(numbers, name).copy() for name in names}
        for value in values.values():
            value[:, j] *= 1 + size
        return replace(numbers, **values), view

    return change


def _fault(name: str, *, cycles: str = "", frequency: str = "") -> Callable[[Changed, int, float, Shape], Changed]:
    def change(machine: Changed, j: int, size: float, shape: Shape) -> Changed:
        more = ({cycles: shape.cycles} if cycles else {}) | ({frequency: shape.frequency} if frequency else {})
        return with_fault(machine[0], j, **{name: size}, **more), machine[1]

    return change


def _coulomb(machine: Changed, j: int, size: float, shape: Shape) -> Changed:
    """The whole strength of the contact is larger, by a share of the Coulomb torque."""
    return _raised(machine, j, size, ("coulomb", "breakaway"))


def _blocks(machine: Changed, j: int, size: float, shape: Shape) -> Changed:
    """Another contact, which has no size."""
    return with_fault(machine[0], j, blocks=1.0), machine[1]


def _peak(machine: Changed, j: int, size: float, shape: Shape) -> Changed:
    return _raised(machine, j, size, ("breakaway",))


def _raised(machine: Changed, j: int, size: float, names: tuple[str, ...]) -> Changed:
    numbers, view = machine
    values = {name: getattr(numbers, name).copy() for name in names}
    for value in values.values():
        value[:, j] += size * numbers.coulomb[:, j]
    return replace(numbers, **values), view


def _stiffness(machine: Changed, j: int, size: float, shape: Shape) -> Changed:
    numbers, view = _scaled("stiffness")(machine, j, size, shape)
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
        mass[b, -1], com[b, -1], inertia[b, -1] = joined(last, (size, bodies.tool_point[b], np.zeros((3, 3))))
    return replace(numbers, bodies=replace(bodies, mass=mass, com=com, inertia=inertia)), view


def _viewed(name: str) -> Callable[[Changed, int, float, Shape], Changed]:
    def change(machine: Changed, j: int, size: float, shape: Shape) -> Changed:
        numbers, view = machine
        value: Any = size if name == "latency" else getattr(view, name) + size * shape.way
        return numbers, replace(view, **{name: value})

    return change


def _by_tracker(answer: str, full: float, name: str, told: Callable[[float, Shape], dict[str, float]]) -> Kind:
    """Of how the tracker sees the tool."""
    change = _viewed(name)
    return Kind(answer=answer, full=_up(full), change=change, told=told, needs=("tracker",), at_machine=True)


def _vector(name: str) -> Callable[[float, Shape], dict[str, float]]:
    return lambda size, shape: {f"{name}.{axis}": float(size * x) for axis, x in zip("xyz", shape.way, strict=True)}


def _number(name: str) -> Callable[[float, Shape], dict[str, float]]:
    return lambda size, shape: {name: size}


KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "coulomb": Kind(
            answer="coulomb_level", full=_either(0.3), change=_coulomb, told=_number("change"), of_number=True
        ),
        "viscous": Kind(
            answer="viscous_level", full=_either(0.5), change=_scaled("viscous"), told=_number("change"), of_number=True
        ),
        "peak": Kind(
            answer="stribeck_peak",
            full=_up(0.8),
            change=_peak,
            told=lambda size, shape: {"level": size, "velocity": 0.0},
        ),
        "presliding": Kind(
            answer="presliding",
            full=_up(1.5),
            change=_scaled("presliding"),
            told=lambda size, shape: {"stiffness": size, "damping": 0.0},
            of_number=True,
        ),
        "blocks": Kind(answer="presliding", full=_up(1.0), change=_blocks),
        "asymmetry": Kind(
            answer="asymmetry",
            full=_either(0.2),
            change=_fault("asymmetry"),
            told=lambda size, shape: {"coulomb": size, "viscous": 0.0},
        ),
        "load_share": Kind(answer="load_friction", full=_up(0.15), change=_fault("load_share"), told=_number("share")),
        "bend": Kind(answer="nonlinear_viscous", full=_up(0.4), change=_fault("bend")),
        "warm": Kind(answer="temperature_friction", full=_up(0.8), change=_fault("warm"), needs=("temperature",)),
        "wear": Kind(answer="coulomb_drift", full=_either(3.0), change=_fault("wear")),
        "waves": Kind(
            answer="position_friction",
            full=_up(0.2),
            change=_fault("waves", cycles="wave_cycles"),
            told=lambda size, shape: {"share": size, "cycles": shape.cycles, "phase": 0.0},
        ),
        "stiffness": Kind(
            answer="joint_stiffness",
            full=_either(0.3),
            change=_stiffness,
            told=_number("change"),
            needs=("elastic",),
            of_number=True,
        ),
        "growth": Kind(answer="hardening", full=_up(1.0), change=_growth, needs=("elastic",)),
        "gap": Kind(
            answer="backlash", full=_up(3e-4), change=_fault("gap"), told=_number("half_gap"), needs=("elastic",)
        ),
        "tooth": Kind(
            answer="kinematic_error",
            full=_up(3e-4),
            change=_fault("tooth"),
            told=lambda size, shape: {"amplitude": size, "cycles": 1.0, "phase": 0.0},
            needs=("elastic",),
        ),
        "payload": Kind(
            answer="payload",
            full=_payload,
            change=_heavier,
            told=lambda size, shape: {"mass": size, "offset.x": 0.0, "offset.y": 0.0, "offset.z": 0.0, "radius": 0.0},
            at_machine=True,
        ),
        "rotor": Kind(
            answer="rotor_inertia", full=_either(0.2), change=_scaled("rotor"), told=_number("change"), of_number=True
        ),
        "torque_error": Kind(
            answer="torque_constant",
            full=_either(0.1),
            change=_fault("torque_error"),
            told=lambda size, shape: {"error": size, "saturation": 0.0, "magnets": 0.0},
        ),
        "offset": Kind(answer="torque_offset", full=_offset, change=_fault("offset"), told=_number("offset")),
        "lag": Kind(answer="torque_delay", full=_up(0.0015), change=_fault("lag")),
        "cogging": Kind(
            answer="cogging",
            full=_of_coulomb(0.3),
            change=_fault("cogging", cycles="cogging_cycles"),
            told=lambda size, shape: {"amplitude": size, "cycles": shape.cycles, "phase": 0.0},
        ),
        "ripple": Kind(
            answer="torque_ripple",
            full=_up(0.05),
            change=_fault("ripple", cycles="ripple_cycles"),
            told=lambda size, shape: {"share": size, "cycles": shape.cycles, "phase": 0.0},
        ),
        "resolver": Kind(
            answer="resolver_ripple",
            full=_up(3e-3),
            change=_fault("resolver"),
            told=lambda size, shape: {"amplitude": size, "cycles": 1.0, "phase": 0.0},
        ),
        "balance": Kind(
            answer="gravity_term",
            full=_balance,
            change=_fault("balance"),
            told=lambda size, shape: {"sine": 0.0, "cosine": size, "stiffness": 0.0},
        ),
        "reflector": _by_tracker("tool_frame", 1.5e-3, "offset", _vector("offset")),
        "frame_shift": _by_tracker("tracker_frame", 1.5e-3, "shift", _vector("shift")),
        "frame_turn": _by_tracker("tracker_frame", 1e-3, "turn", _vector("turn")),
        "latency": _by_tracker("tracker_clock", 0.005, "latency", lambda size, shape: {"latency": size, "drift": 0.0}),
        "brake": Kind(answer="", full=_of_coulomb(0.5), change=_fault("brake", frequency="frequency")),
        "clock": Kind(answer="", full=_of_coulomb(0.3), change=_fault("clock", frequency="frequency")),
        "neighbour": Kind(answer="", full=_of_coulomb(0.4), change=_fault("neighbour"), needs=("neighbour",)),
    }
)
"""Every kind of effect, by the name that the exam gives it."""
