"""An effect that is hidden in a machine: how it is drawn, how large it is, and what an answer must say of it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from ffgym.effects import Effect
from ffgym.effects.parameter import Parameter
from ffgym.errors import check_choice
from ffgym.exam.equations import Clue, DamagedTooth, Outsider, Variant
from ffgym.motions.parts.place import resting_position
from ffgym.robot import RobotDescription
from ffgym.types import Array

_AS_DESCRIBED = ("reference",)
"""Shapes that are not drawn: a description holds at the temperature of the room in which it was made."""

_WRIST = 3
"""Last joints, between which wrists have coupling losses."""

_NEARBY = 0.03
"""How far from where motions are centred a damaged tooth is [rad]; chosen: all motions but the smallest pass it."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Hidden:
    """An effect on one joint of a robot, or on all of it, and how it is to be named."""

    effect: Effect
    joint: str
    """Empty for the machine as a whole."""

    @property
    def is_foreign(self) -> bool:
        """Whether its equation is another than that of the library."""
        return isinstance(self.effect, Variant)

    @property
    def answer(self) -> str:
        """Name of the effect that a diagnosis should give; empty outside the library."""
        effect = self.effect
        if isinstance(effect, Outsider):
            return ""
        return effect.variant_of if isinstance(effect, Variant) else effect.name

    def clue(self, robot: RobotDescription) -> Clue | None:
        """What an answer must say of an effect outside the library."""
        effect = self.effect
        return effect.clue(tuple(robot.joints), self.joint) if isinstance(effect, Outsider) else None

    def numbers(self, robot: RobotDescription) -> dict[str, Any]:
        """Its parameters on its joint, by name; None for sizes that are null there."""
        known = self.effect.parameters()
        return {name: _at(known[name], value, robot, self.joint) for name, value in self.effect.values().items()}

    def times(self, factor: float) -> "Hidden":
        """The same, smaller or larger; shapes stay."""
        return replace(self, effect=_scaled(self.effect, factor))


def _at(known: Parameter, value: Array, robot: RobotDescription, joint: str) -> Any:
    """A parameter on one joint: a number, or a list for vectors and pairs."""
    if known.per in ("joint", "pair"):
        value = value[robot.joints.index(joint)]
    return value.tolist()


def _scaled(effect: Effect, factor: float) -> Effect:
    values = {}
    for name, known in effect.parameters().items():
        value = getattr(effect, name)
        values[name] = value if known.null is None else known.null + factor * (value - known.null)
    return type(effect)(**values)


def drawn(kind: type[Effect], robot: RobotDescription, rng: np.random.Generator, joint: str | None = None) -> Hidden:
    """An effect at full size on a joint by chance, or the one that is named; of several sizes it has one.

    Shapes are drawn from their plausible range, whole numbers of cycles per motor turn, directions of vectors evenly.
    """
    known = kind.parameters()
    sizes = [name for name, p in known.items() if p.null is not None]
    chosen = sizes[rng.integers(len(sizes))]
    where = {p.per for p in known.values()}
    wrist = robot.joints[-_WRIST:] if "pair" in where and not issubclass(kind, Outsider) else robot.joints
    place = str(wrist[rng.integers(len(wrist))]) if joint is None else check_choice("joint", joint, robot.joints)
    values: dict[str, Any] = {}
    for name, p in known.items():
        if p.null is None:
            values |= _shape(kind, p, robot, rng, place)
        else:
            values[name] = _full(p, robot, rng, place, wrist) if name == chosen else p.null
    per_joint = bool(where & {"joint", "pair"})
    if not per_joint:
        return Hidden(effect=kind.on(robot, **values), joint="")
    alone = {name: _only(known[name], value, robot, place) for name, value in values.items()}
    return Hidden(effect=kind.on(robot, **alone), joint=place)


def _only(known: Parameter, value: Any, robot: RobotDescription, joint: str) -> Any:
    """A size on one joint and null on all others; shapes everywhere, where they do not matter."""
    if known.per != "joint" or known.null is None:
        return value
    return np.where([name == joint for name in robot.joints], value, known.null)


def _full(
    known: Parameter, robot: RobotDescription, rng: np.random.Generator, joint: str, others: tuple[str, ...]
) -> Any:
    """The end of the plausible range, either one if there are two."""
    ends = [end for end in (known.low, known.high) if end != known.null]
    end = ends[rng.integers(len(ends))]
    if known.per == "vector":
        way = rng.standard_normal(3)
        way = np.abs(way) if known.minimum >= 0 else way
        return end * way / np.linalg.norm(way)
    if known.per == "pair":
        row = robot.joints.index(joint)
        other = rng.choice([robot.joints.index(name) for name in others if name != joint])
        matrix = np.zeros((robot.n_joints, robot.n_joints))
        matrix[row, other] = end
        return matrix
    return end


def _shape(
    kind: type[Effect], known: Parameter, robot: RobotDescription, rng: np.random.Generator, joint: str
) -> Mapping[str, Any]:
    """A shape from its plausible range; nothing for one that stays as it is described."""
    if known.name in _AS_DESCRIBED:
        return {}
    if issubclass(kind, DamagedTooth) and known.name == "place":
        rest = resting_position(robot)[robot.joints.index(joint)]
        return {known.name: rest + rng.uniform(-_NEARBY, _NEARBY)}
    size = 3 if known.per == "vector" else None
    if known.role == "cycles":
        number = np.exp(rng.uniform(np.log(known.low), np.log(known.high)))
        return {known.name: float(np.round(number)) if known.unit == "1" else float(number)}
    return {known.name: rng.uniform(known.low, known.high, size=size)}
