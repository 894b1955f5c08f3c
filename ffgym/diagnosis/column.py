"""Columns of a regression: what one parameter of one effect on one joint changes in all that is compared.

Slopes of a stiffness hold as long as swings stay in phase: a spring that is a fifth softer swings at a frequency that
is a tenth lower, and after five swings its slope points elsewhere. What a log shows of it is near that of a replay with
about as soft a spring, from where a fit finds the rest.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.computing import FAILED
from ffgym.diagnosis.push import (
    Parts,
    Push,
    changes,
    clock_parts,
    misread_on,
    misread_push,
    push_of,
    replayed_parts,
    shown,
)
from ffgym.diagnosis.replay import Replay, servo_feedback, tracked
from ffgym.diagnosis.variant import Cycles, Variant, variants, with_effect
from ffgym.effects import ClockEffect, Effect, ModelEffect, NativeEffect, ResolverEffect, TrackerEffect
from ffgym.effects.elasticity import JointStiffness

_TOGETHER = 24
"""Pushes on the springs that are solved for at once; chosen: more gain little, and each array of them takes 50 MB for
84 s of six axes."""

_SMALL = 0.3
"""Share of a practical step by which what swings is perturbed; chosen: a base of 30 Hz, faster than machines move."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Column:
    """Change of the predictions per unit of a parameter."""

    effect: type[Effect]
    joint: str
    """Empty for the machine as a whole."""
    parameter: str
    part: int | None
    """Which number of a vector, or which other joint of a pair."""
    choice: int
    """Columns of one effect, joint and choice belong together."""
    span: int
    """Which of the values that span a phase or the like."""
    shape: Mapping[str, Array]
    """Values of the shapes, of this joint or of the machine."""
    parts: Parts


def column_of_machine(effect: type[Effect], parameter: str, parts: Parts, choice: int = 0, joint: str = "") -> Column:
    """A column of one number without shapes, of the machine as a whole or of a joint."""
    return Column(
        effect=effect, joint=joint, parameter=parameter, part=None, choice=choice, span=0, shape={}, parts=parts
    )


def columns_of(run: Replay, kinds: Iterable[type[Effect]], cycles: Cycles) -> list[Column]:
    """Columns of effects along a nominal replay; the same effect, joint and choice stand together."""
    found: list[Column] = []
    waiting: list[tuple[Variant, str, Push]] = []

    def solve() -> None:
        for (variant, joint, _), change in zip(waiting, changes(run, [push for _, _, push in waiting]), strict=True):
            found.append(_column(run, variant, joint, shown(run, change)))
        waiting.clear()

    for kind in kinds:
        for variant in variants(kind, run.robot, cycles):
            try:
                at_once = _at_once(run, variant)
                pushes = [] if at_once is not None else _pushes(run, variant)
            except FAILED:
                continue  # a machine that cannot have it, or not so much of it, shows nothing of it
            found += at_once or ()
            for joint, push in pushes:
                waiting.append((variant, joint, push))
                if len(waiting) == _TOGETHER:
                    solve()
    solve()
    return [column for column in found if all(np.isfinite(rows).all() for rows in column.parts.values())]


def _at_once(run: Replay, variant: Variant) -> list[Column] | None:
    """Columns of a variant that bends no springs of the arm; None if it does."""
    effect = variant.effect
    if isinstance(effect, TrackerEffect):
        return _tracker_columns(run, variant)
    if isinstance(effect, ClockEffect):
        return _clock_columns(run, variant)
    if isinstance(effect, ModelEffect):
        return [_model_column(run, variant)]
    if effect.side == "controller":
        return _servo_columns(run, variant)
    if effect.side == "motor" and not isinstance(effect, ResolverEffect):
        return _motor_columns(run, variant)
    return None


def machine_columns(run: Replay, effects: Sequence[tuple[str, Effect]], parameter: str, step: float) -> list[Column]:
    """One column for each of several effects that act on the whole arm, per unit of `parameter`, `step` from null."""
    pushes = [push_of(run, effect) for _, effect in effects]
    return [
        column_of_machine(
            type(effect), parameter, {key: values / step for key, values in shown(run, change).items()}, 0, joint
        )
        for (joint, effect), change in zip(effects, changes(run, pushes), strict=True)
    ]


def _column(run: Replay, variant: Variant, joint: str, parts: Parts) -> Column:
    """The column of a variant, per unit of its parameter."""
    at = list(run.robot.joints).index(joint) if joint else None
    shape = {name: value if at is None or value.ndim == 0 else value[at] for name, value in variant.shape.items()}
    return Column(
        effect=type(variant.effect),
        joint=joint,
        parameter=variant.parameter,
        part=variant.part,
        choice=variant.choice,
        span=variant.span,
        shape=shape,
        parts={key: values / variant.step for key, values in parts.items()},
    )


def _motor_columns(run: Replay, variant: Variant) -> list[Column]:
    """Of an effect before the gearbox: torque of its own motor, for all motors at once."""
    push = push_of(run, variant.effect)
    if push.motor is None:
        return []
    torque = run.log.sampling(push.motor)
    return [_column(run, variant, run.robot.joints[j], {("torque", j): torque[..., j]}) for j in variant.joints]


def _servo_columns(run: Replay, variant: Variant) -> list[Column]:
    """Of an effect in the servo."""
    effect, log = variant.effect, run.log
    if not log.shows_servo or not isinstance(effect, NativeEffect):
        return []
    more = servo_feedback(log, effect.in_description(run.robot)) - servo_feedback(log, run.robot)
    rows = log.sampling(more)
    return [_column(run, variant, run.robot.joints[j], {("servo", j): rows[..., j]}) for j in variant.joints]


def _clock_columns(run: Replay, variant: Variant) -> list[Column]:
    """Of samples that are written late."""
    parts = clock_parts(run, [], [variant.effect])
    return [_column(run, variant, "", parts)] if parts else []


def _tracker_columns(run: Replay, variant: Variant) -> list[Column]:
    """Of an effect between the tool and its measurement."""
    if run.log.tool is None:
        return []
    joints = run.robot.joints
    every = run.log.sampling.stride  # what a tracker errs by changes no faster than the tool moves
    exact = tracked(run, run.machine, every)
    found = []
    for joint in [joints[j] for j in variant.joints] or [""]:
        effect = variant.effect if not joint else _on_one(variant, joint, run)
        rows = tracked(run, with_effect(run.machine, effect), every) - exact
        found.append(_column(run, variant, joint, {("tool", k): rows[..., k] for k in range(3)}))
    return found


def _model_column(run: Replay, variant: Variant) -> Column:
    """Of an effect with joints of its own, which swing: a small one is more like one of any size."""
    values = variant.effect.values()
    small = type(variant.effect)(**values | {variant.parameter: _SMALL * values[variant.parameter]})
    parts = replayed_parts(run, with_effect(run.machine, small))
    return _column(run, variant, "", {key: rows / _SMALL for key, rows in parts.items()})


def _on_one(variant: Variant, joint: str, run: Replay) -> Effect:
    """The effect of a variant on one joint alone."""
    at = list(run.robot.joints).index(joint)
    known = type(variant.effect).parameters()
    values = variant.effect.values()
    for name, p in known.items():
        if p.role == "size" and p.per == "joint":
            alone = np.full_like(values[name], p.neutral)
            alone[at] = values[name][at]
            values[name] = alone
    return type(variant.effect)(**values)


def _pushes(run: Replay, variant: Variant) -> list[tuple[str, Push]]:
    """Pushes on the arm, one per joint that has the effect, or one of the whole machine."""
    effect, joints = variant.effect, run.robot.joints
    if isinstance(effect, ResolverEffect):
        misread = misread_push(run, effect)
        return [(joints[j], misread_on(run, misread, j)) for j in variant.joints]
    push = push_of(run, effect)
    return [(joints[j], push.only_joint(j)) for j in variant.joints] or [("", push)]


def together(columns: Sequence[Column]) -> list[list[int]]:
    """Places of columns that are one candidate: of one effect, joint and shape, and for a pair of one other joint."""
    found: dict[tuple[type[Effect], str, int, int | None], list[int]] = {}
    for i, column in enumerate(columns):
        pair = column.effect.parameters()[column.parameter].per == "pair"
        key = (column.effect, column.joint, column.choice, column.part if pair else None)
        found.setdefault(key, []).append(i)
    return list(found.values())


_CHANGES = (-0.24, -0.16, -0.08, 0.08, 0.16, 0.24)
"""Relative changes of a stiffness that are replayed; chosen: between two of them a swing
is less than a third of a turn away from that of one of them, after six swings."""


def stiffness_columns(run: Replay, joints: Iterable[int]) -> list[Column]:
    """Columns of the springs of some `joints`, by their indices; each change is a candidate of its own."""
    found = []
    for j in joints:
        for choice, change in enumerate(_CHANGES, start=1):
            alone = np.zeros(run.robot.n_joints)
            alone[j] = change
            parts = replayed_parts(run, with_effect(run.machine, JointStiffness(change=alone)))
            columns = {key: rows / change for key, rows in parts.items()}
            found.append(column_of_machine(JointStiffness, "change", columns, choice, run.robot.joints[j]))
    return found
