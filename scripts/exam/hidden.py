"""An effect that is hidden in a machine: how it is drawn, how large it is, and what an answer must say of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ffgym.core.errors import check_choice
from ffgym.effects import Effect
from ffgym.effects.parameters import Parameter
from ffgym.effects.transmission.arm_friction import ArmFriction
from ffgym.paths.motions.part import resting_position
from ffgym.robot import RobotDescription
from scripts.exam.equations import Clue, Outsider, Variant
from scripts.exam.tasks import Truth

_AS_DESCRIBED = ("reference",)
"""Shapes that are not drawn: a description holds at the temperature of the room in which it was made."""

_WRIST = 3
"""Last joints, between which wrists have coupling losses."""

_NEARBY = 0.03
"""Distance of a damaged tooth from the centre of motions [rad]; chosen: all motions but the smallest pass it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Hidden:
    """An effect on one joint of a robot, or on all of it, and how it is to be named."""

    effect: Effect
    joint: str
    """Empty for the machine as a whole."""
    beside: Mapping[str, float] = field(default_factory=dict)
    """Errors of the description that add to its numbers: one number is off by both, and they cannot be told apart."""

    @property
    def answer(self) -> str:
        """Name of the effect that a diagnosis should give; empty outside the library."""
        effect = self.effect
        if isinstance(effect, Outsider):
            return ""
        return effect.variant_of if isinstance(effect, Variant) else effect.name

    def clue(self, robot: RobotDescription) -> Clue | None:
        """Make the clue of an effect outside the library."""
        effect = self.effect
        return effect.clue(tuple(robot.joints), self.joint) if isinstance(effect, Outsider) else None

    def numbers(self, robot: RobotDescription) -> dict[str, float]:
        """Its parameters on its joint, by the names that causes have: `name.x` of vectors, `name.j4` of pairs."""
        found: dict[str, float] = {}
        for name, known in self.effect.parameters().items():
            value = getattr(self.effect, name)
            if known.per in ("joint", "pair"):
                value = value[robot.joints.index(self.joint)]
            parts = {"vector": "xyz", "pair": robot.joints}.get(known.per)
            if parts is None:
                found[name] = float(value)
            else:
                found |= {f"{name}.{part}": float(x) for part, x in zip(parts, value, strict=True)}
        return {name: value + self.beside.get(name, 0.0) for name, value in found.items()}

    def truth(self, robot: RobotDescription, loudness: float) -> Truth:
        """Describe the hidden effect for the marks."""
        return Truth(
            effect=self.effect.name,
            answer=self.answer,
            joint=self.joint,
            is_foreign=isinstance(self.effect, Variant),
            loudness=loudness,
            numbers=self.numbers(robot),
        )

    def times(self, factor: float) -> "Hidden":
        """The same, smaller or larger; shapes stay."""
        values = {}
        for name, known in self.effect.parameters().items():
            value = getattr(self.effect, name)
            values[name] = value if known.null is None else known.null + factor * (value - known.null)
        return replace(self, effect=type(self.effect)(**values))


def drawn(kind: type[Effect], robot: RobotDescription, rng: np.random.Generator, joint: str | None = None) -> Hidden:
    """An effect at full size on a joint by chance, or the one that is named; of several sizes it has one.

    Shapes are drawn from their plausible range, whole numbers of cycles per motor turn, directions of vectors evenly.

    Raises:
        FFGymError: if the robot has no such joint.
    """
    known = kind.parameters()
    sizes = [name for name, p in known.items() if p.null is not None]
    chosen = sizes[rng.integers(len(sizes))]
    # losses between joints of the library are those of wrists
    in_wrist = any(p.per == "pair" for p in known.values()) and not issubclass(kind, Outsider)
    places = tuple(robot.joints[-_WRIST:] if in_wrist else robot.joints)
    if kind is ArmFriction:  # as in all exams held so far, not on the last link
        places = places[:-1] or places
    place = str(places[rng.integers(len(places))]) if joint is None else check_choice("joint", joint, robot.joints)
    values: dict[str, Any] = {}
    for name, p in known.items():
        if name == chosen:
            values[name] = _full(p, robot, rng, place, places)
        elif p.null is not None:
            values[name] = p.null
        elif kind.name == "damaged_tooth" and name == "place":
            rest = resting_position(robot)[robot.joints.index(place)]
            values[name] = float(rest + rng.uniform(-_NEARBY, _NEARBY))
        elif p.role == "cycles":
            number = float(np.exp(rng.uniform(np.log(p.low), np.log(p.high))))
            values[name] = float(round(number)) if p.unit == "1" else number
        elif name not in _AS_DESCRIBED:
            values[name] = rng.uniform(p.low, p.high, size=3 if p.per == "vector" else None)
    is_local = any(p.per in ("joint", "pair") for p in known.values())
    return Hidden(effect=kind.on(robot, **values), joint=place if is_local else "")


def _full(
    known: Parameter, robot: RobotDescription, rng: np.random.Generator, joint: str, others: tuple[str, ...]
) -> Any:
    """The end of the plausible range on a joint, either one if there are two; null on all other joints."""
    ends = [end for end in (known.low, known.high) if end != known.null]
    end, row = ends[rng.integers(len(ends))], robot.joints.index(joint)
    if known.per == "machine":
        return end
    if known.per == "vector":
        way = rng.standard_normal(3)
        way = np.abs(way) if known.minimum >= 0 else way
        return end * way / np.linalg.norm(way)
    value = np.full(known.shape(robot.n_joints), known.null)
    if known.per == "pair":
        value[row, rng.choice([robot.joints.index(name) for name in others if name != joint])] = end
    else:
        value[row] = end
    return value
