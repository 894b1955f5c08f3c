"""Small perturbations of a machine: each size parameter of an effect, by a practical step, in every shape to try."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.settings import settings
from ffgym.effects import Effect
from ffgym.effects.parameters import Parameter
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Machine

Cycles = Mapping[str, Sequence[float]]
"""Repetitions of a periodic effect per motor turn that are likely, by joint, the most likely first."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Variant:
    """A machine with a bit more of one parameter of one effect, on every joint that can have it."""

    effect: Effect
    """The effect by itself."""
    parameter: str
    part: int | None
    """Place of the number in a vector, or the joint that causes it in a pair; None for one per joint or for the
    machine."""
    step: float
    """Distance of `parameter` from its null value."""
    shape: Mapping[str, Array]
    """Values of its shapes, as the effect has them."""
    joints: tuple[int, ...]
    """Joints that have it, each a column of its own; empty for one column of the whole machine."""
    choice: int
    """Number among the shapes that are tried; columns of one choice belong together."""
    span: int
    """Place among the values that span a phase or the like."""


def compute_step(known: Parameter) -> float:
    """Practical step of a size parameter away from its null value."""
    null = known.neutral
    towards = known.high if abs(known.high - null) >= abs(known.low - null) else known.low
    return settings().screening.step * (towards - null)


def list_variants(kind: type[Effect], robot: RobotDescription, cycles: Cycles) -> Iterator[Variant]:
    """All variants of an effect on a robot; none if the robot cannot have it at all."""
    # joints that can have it
    known = kind.parameters()
    repeats = any(p.is_looked_for for p in known.values())
    joints = [
        j
        for j, joint in enumerate(robot.joints)
        if not (kind.needs_elasticity and robot.drive.is_rigid[j]) and (cycles.get(joint) or not repeats)
    ]
    # an effect of single joints needs a joint that can have it
    per_joint = any(p.per in ("joint", "pair") for p in known.values() if p.role == "size")
    if per_joint and not joints:
        return
    # every shape, size parameter, direction of a span and part of a vector or pair
    parts: dict[str, Sequence[int | None]] = {"vector": range(3), "pair": range(robot.n_joints)}
    for choice, shape in enumerate(_list_shapes(known, robot, cycles)):
        for size in (p for p in known.values() if p.role == "size"):
            for span, fixed in enumerate(_list_spans(known, shape)):
                for part in parts.get(size.per, (None,)):
                    values = {name: np.asarray(value, dtype=np.float64) for name, value in fixed.items()}
                    values[size.name], places = _perturb(size, robot, joints, part)
                    effect = kind(**_complete(known, values, robot))
                    yield Variant(
                        effect=effect,
                        parameter=size.name,
                        part=part,
                        step=compute_step(size),
                        shape={name: getattr(effect, name) for name in fixed},
                        joints=places,
                        choice=choice,
                        span=span,
                    )


def add_effect(machine: Machine, effect: Effect) -> Machine:
    """The machine with one more effect."""
    return Machine(robot=machine.robot, effects=(*machine.effects, effect), climate=machine.climate)


def _perturb(
    size: Parameter, robot: RobotDescription, joints: Sequence[int], part: int | None
) -> tuple[Array, tuple[int, ...]]:
    """The parameter a step away from its null value, and the joints that have it."""
    values = np.full(size.shape(robot.n_joints), size.neutral)
    moved = size.neutral + compute_step(size)
    if size.per == "joint":
        values[joints] = moved
        return values, tuple(joints)
    if size.per == "pair":
        values[:, part] = moved
        values[part, part] = size.neutral
        return values, tuple(j for j in joints if j != part)
    values[... if part is None else part] = moved
    return values, ()


def _list_shapes(known: Mapping[str, Parameter], robot: RobotDescription, cycles: Cycles) -> list[dict[str, Any]]:
    """Values of shape parameters to try: every combination; frequencies differ from joint to joint."""
    tried: list[list[tuple[str, Any]]] = []
    for p in known.values():
        if p.scale == "top_speed":
            tried.append([(p.name, np.maximum(np.abs(robot.drive.motor_angle(robot.kinematics.max_speed)), p.minimum))])
        if p.role in ("shape", "cycles") and p.tries:
            tried.append([(p.name, value) for value in p.tries])
        if p.is_looked_for:
            likely = [cycles.get(joint) or (1.0,) for joint in robot.joints]
            count = max((len(cycles.get(joint, ())) for joint in robot.joints), default=0)
            ith = [[own[min(i, len(own) - 1)] for own in likely] for i in range(count)]
            tried.append([(p.name, np.clip(values, p.minimum, p.maximum)) for values in ith])
    return [dict(combination) for combination in product(*tried)]


def _list_spans(known: Mapping[str, Parameter], shape: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The shape with each of the values that span its phases and other linear parameters."""
    found = [dict(shape)]
    for p in known.values():
        if p.role == "phase":
            found = [one | {p.name: phase} for one in found for phase in (0.0, np.pi / 2)]
        elif p.role == "span":
            step = 0.5 * p.high  # away from its default, in each of its directions
            moved = [step * np.eye(3)[k] for k in range(3)] if p.per == "vector" else [step]
            found = found + [dict(shape) | {p.name: value} for value in moved]
    return found


def _complete(known: Mapping[str, Parameter], values: Mapping[str, Any], robot: RobotDescription) -> dict[str, Any]:
    """All parameters: sizes that are not moved at their null value, for as many joints as the robot has."""
    full: dict[str, Any] = {}
    for p in known.values():
        if p.name in values:
            value = np.asarray(values[p.name])
            full[p.name] = np.broadcast_to(value, p.shape(robot.n_joints)).copy() if p.per != "machine" else value
        elif p.role == "size":
            full[p.name] = np.full(p.shape(robot.n_joints), p.neutral)
    return full
