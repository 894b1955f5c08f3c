"""Sensitivities: change of all predictions by one parameter of one effect on one joint.

Slopes of a stiffness hold as long as swings stay in phase: a spring that is a fifth softer swings at a frequency that
is a tenth lower, and after five swings its slope points elsewhere. What a log shows of it is near that of a replay with
about as soft a spring, from where a fit finds the rest.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.computing import FAILED
from ffgym.diagnosis.perturbation import (
    Parts,
    Perturbation,
    perturb,
    perturb_motion,
    propagate,
    replay_change,
    shift_clocks,
)
from ffgym.diagnosis.replay import Replay, predict, predict_feedback, predict_tracker
from ffgym.diagnosis.replay.rows import bend_with_shares
from ffgym.diagnosis.replay.springs import Deflection
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.variant import Cycles, Variant, add_effect, list_variants
from ffgym.effects import ClockEffect, Effect, ModelEffect, NativeEffect, ResolverEffect, TrackerEffect
from ffgym.effects.transmission.arm_friction import ArmFriction
from ffgym.effects.transmission.stiffness import JointStiffness
from ffgym.simulation.plant import Machine

_TOGETHER = 24
"""Pushes on the springs that are solved for at once; chosen: more gain little, and each array of them takes 50 MB for
84 s of six axes."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sensitivity:
    """Sensitivity of all predictions to one parameter, per its unit."""

    effect: type[Effect]
    joint: str = ""
    """Empty for the machine as a whole."""
    parameter: str
    part: int | None = None
    """Place of the number in a vector, or which other joint of a pair."""
    choice: int = 0
    """Columns of one effect, joint and choice belong together."""
    span: int = 0
    """Place among the values that span a phase or the like."""
    shape: Mapping[str, Array] = field(default_factory=dict)
    """Values of the shapes, of this joint or of the machine."""
    parts: Parts


def compute_sensitivities(run: Replay, kinds: Iterable[type[Effect]], cycles: Cycles) -> list[Sensitivity]:
    """Compute sensitivities of effects along a nominal replay; the same effect, joint and choice stand together."""
    found: list[Sensitivity] = []
    waiting: list[tuple[Variant, str, Perturbation]] = []

    def solve() -> None:
        for (variant, joint, _), parts in zip(waiting, propagate(run, [push for _, _, push in waiting]), strict=True):
            found.append(_build_sensitivity(run, variant, joint, parts))
        waiting.clear()

    # variants that bend springs wait, so that many are solved for at once
    for kind in kinds:
        for variant in list_variants(kind, run.robot, cycles):
            try:
                at_once = _compute_without_springs(run, variant)
                pushes = [] if at_once is not None else _list_perturbations(run, variant)
            except FAILED:
                continue  # a machine that cannot have it, or not so much of it, shows nothing of it
            found += [_build_sensitivity(run, variant, joint, parts) for joint, parts in at_once or ()]
            for joint, push in pushes:
                waiting.append((variant, joint, push))
                if len(waiting) == _TOGETHER:
                    solve()
    # columns that overflow are left out
    solve()
    return [column for column in found if all(np.isfinite(rows).all() for rows in column.parts.values())]


def _compute_without_springs(run: Replay, variant: Variant) -> list[tuple[str, Parts]] | None:
    """Compute the change by a variant that bends no springs of the arm, by joint; None if it bends them."""
    effect, log, joints = variant.effect, run.log, run.robot.joints
    # tracker and clock: the motion stays as it is, only its record changes
    if isinstance(effect, TrackerEffect):
        return _compute_tracker_changes(run, variant) if log.tool is not None else []
    if isinstance(effect, ClockEffect):
        written = shift_clocks(run, [], [effect])
        return [("", written)] if written else []
    if isinstance(effect, ModelEffect):
        return _compute_changes_by_own_joints(run, variant)
    # controller: torque that it would ask for at the same measured motion
    if effect.side == "controller":
        if not log.shows_servo or not isinstance(effect, NativeEffect):
            return []
        rows = log.sampling(predict_feedback(log, effect.in_description(run.robot)) - predict_feedback(log, run.robot))
        return [(joints[j], {("servo", j): rows[..., j]}) for j in variant.joints]
    # before the gearbox: torque of its own motor, for all motors at once
    if effect.side == "motor" and not isinstance(effect, ResolverEffect):
        motor = perturb(run, effect).motor
        if motor is None:
            return []
        rows = log.sampling(motor)
        return [(joints[j], {("torque", j): rows[..., j]}) for j in variant.joints]
    return None


def _compute_changes_by_own_joints(run: Replay, variant: Variant) -> list[tuple[str, Parts]]:
    """Compute the change by an effect whose own joints swing: a small one is more like one of any size."""
    kind, small, found = type(variant.effect), settings().screening.small_step, list[tuple[str, Parts]]()
    values, before = variant.effect.values(), predict(run)
    size = small * values[variant.parameter]
    for j in variant.joints or (None,):
        alone = size if j is None else np.where(np.arange(len(size)) == j, size, 0.0)
        try:
            parts = replay_change(run, add_effect(run.machine, kind(**values | {variant.parameter: alone})), before)
        except FAILED:
            continue  # a joint that cannot have it
        joint = "" if j is None else run.robot.joints[j]
        found.append((joint, {key: rows / small for key, rows in parts.items()}))
    return found


def compute_machine_sensitivities(
    run: Replay, effects: Sequence[tuple[str, Effect]], parameter: str, step: float
) -> list[Sensitivity]:
    """Compute sensitivities of effects that act on the whole arm, per unit of `parameter`, `step` from null."""
    found = []
    for (joint, effect), change in zip(effects, propagate(run, [perturb(run, one) for _, one in effects]), strict=True):
        parts = {key: values / step for key, values in change.items()}
        found.append(Sensitivity(effect=type(effect), joint=joint, parameter=parameter, parts=parts))
    return found


def _build_sensitivity(run: Replay, variant: Variant, joint: str, parts: Parts) -> Sensitivity:
    """Build the sensitivity of a variant, per unit of its parameter."""
    at = list(run.robot.joints).index(joint) if joint else None
    shape = {name: value if at is None or value.ndim == 0 else value[at] for name, value in variant.shape.items()}
    return Sensitivity(
        effect=type(variant.effect),
        joint=joint,
        parameter=variant.parameter,
        part=variant.part,
        choice=variant.choice,
        span=variant.span,
        shape=shape,
        parts={key: values / variant.step for key, values in parts.items()},
    )


def _compute_tracker_changes(run: Replay, variant: Variant) -> list[tuple[str, Parts]]:
    """Compute the change by an effect between the tool and its measurement, on each joint alone."""
    joints = run.robot.joints
    every = run.log.sampling.stride  # what a tracker errs by changes no faster than the tool moves
    exact, found = predict_tracker(run, every=every), list[tuple[str, Parts]]()
    for j in variant.joints or (None,):
        values = variant.effect.values()
        for name, p in type(variant.effect).parameters().items():
            if j is not None and p.role == "size" and p.per == "joint":
                values[name] = np.where(np.arange(len(joints)) == j, values[name], p.neutral)
        machine = add_effect(run.machine, type(variant.effect)(**values))
        rows = predict_tracker(run, machine, every) - exact
        found.append(("" if j is None else joints[j], {("tool", k): rows[..., k] for k in range(3)}))
    return found


def _list_perturbations(run: Replay, variant: Variant) -> list[tuple[str, Perturbation]]:
    """List perturbations of the arm, one per joint that has the effect, or one of the whole machine."""
    effect, joints = variant.effect, run.robot.joints
    if isinstance(effect, ResolverEffect):
        # wrong readings at all motors, which truly moved otherwise; what they ask of the links is left to each
        error = effect.error(run.state.motor_angle, run.state.motor_speed)
        misread, found = perturb_motion(run, -run.robot.drive.joint_angle(error.angle)), []
        for j in variant.joints:
            alone = misread.select_joint(j)
            if misread.joint_ddq is not None:
                alone = replace(alone, links=run.links.mass[..., j] * misread.joint_ddq[..., j, None])
            found.append((joints[j], alone))
        return found
    push = perturb(run, effect)
    return [(joints[j], push.select_joint(j)) for j in variant.joints] or [("", push)]


def group_candidates(columns: Sequence[Sensitivity]) -> list[list[int]]:
    """Group columns that are one candidate, by place: one effect, joint and shape, and for a pair one other joint."""
    found: dict[tuple[type[Effect], str, int, int | None], list[int]] = {}
    for i, column in enumerate(columns):
        pair = column.effect.parameters()[column.parameter].per == "pair"
        key = (column.effect, column.joint, column.choice, column.part if pair else None)
        found.setdefault(key, []).append(i)
    return list(found.values())


_CHANGES = (-0.24, -0.16, -0.08, 0.08, 0.16, 0.24)
"""Relative changes of a stiffness that are replayed; chosen: between two of them a swing
is less than a third of a turn away from that of one of them, after six swings."""


_SHARES = (0.45, 0.9)
"""Shares of friction that move behind the elasticity, which are replayed; chosen: all that is plausible, and half."""


def compute_stiffness_sensitivities(run: Replay, joints: Iterable[int]) -> list[Sensitivity]:
    """Compute sensitivities of the springs of `joints` by replays; each change is a candidate of its own."""
    return _compute_by_replays(run, JointStiffness, "change", _CHANGES, joints)


def compute_share_sensitivities(run: Replay, joints: Iterable[int]) -> list[Sensitivity]:
    """Compute sensitivities of friction behind the elasticity of `joints` by replays, likewise.

    Slopes are those of links that turn with their motors. With much friction behind a soft spring they stand while it
    is wound up, and what a log shows of it is far from the slope.
    """
    return _compute_by_replays(run, ArmFriction, "share", _SHARES, joints, bend_with_shares)


def _compute_by_replays(
    run: Replay,
    kind: type[Effect],
    parameter: str,
    sizes: Sequence[float],
    joints: Iterable[int],
    bend: Callable[[Replay, Sequence[Machine]], Sequence[Deflection | None]] | None = None,
) -> list[Sensitivity]:
    """Compute sensitivities by replays with an effect of several sizes, on one joint after the other.

    `bend` computes deflections of all machines together, where that is faster.
    """
    found, here, each = [], predict(run), np.eye(run.robot.n_joints)
    tried = [(j, choice, size) for j in joints for choice, size in enumerate(sizes, start=1)]
    others = [add_effect(run.machine, kind(**{parameter: size * each[j]})) for j, _, size in tried]
    bent = [None] * len(others) if bend is None else bend(run, others)
    for (j, choice, size), other, deflection in zip(tried, others, bent, strict=True):
        try:
            change = replay_change(run, other, here, deflection)
        except FAILED:
            continue  # a machine that cannot be so
        parts = {key: rows / size for key, rows in change.items()}
        joint = run.robot.joints[j]
        found.append(Sensitivity(effect=kind, joint=joint, parameter=parameter, choice=choice, parts=parts))
    return found
