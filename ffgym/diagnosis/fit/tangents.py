"""What changes in a replay, to first order, if its machine is exchanged, or a number of a hypothesis moves."""

from collections.abc import Mapping, Sequence

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.diagnosis.fit.hypothesis import Hypothesis, machine_of
from ffgym.diagnosis.replay import Replay, servo_feedback, tracked
from ffgym.diagnosis.signatures.push import Parts, Push, changes, clock_parts, moved, of_numbers, replayed_parts, shown
from ffgym.effects import ClockEffect, ModelEffect, NativeEffect, TorqueEffect, Torques, TrackerEffect
from ffgym.effects.along import torques_along
from ffgym.effects.effect import Effect
from ffgym.simulation.plant import Machine


def exchanged(run: Replay, machines: Sequence[Machine]) -> list[Parts]:
    """Change of all predictions for each of several machines in place of that of the replay."""
    known: dict[TorqueEffect, Torques] = {}
    pushes = [_push(run, machine, known) for machine in machines]
    found: list[Parts] = []
    for machine, change in zip(machines, changes(run, pushes), strict=True):
        gone, come = _exchange(run.machine, machine)
        both = (*gone, *come)
        if any(isinstance(effect, ModelEffect) for effect in both):
            found.append(replayed_parts(run, machine))
            continue
        parts = dict(shown(run, change))
        if run.log.tool is not None and any(isinstance(effect, TrackerEffect) for effect in both):
            every = run.log.sampling.stride
            seen = tracked(run, machine, every) - tracked(run, run.machine, every)
            for k in range(3):
                parts["tool", k] = parts.get(("tool", k), 0.0) + seen[..., k]
        if any(isinstance(effect, ClockEffect) for effect in both):
            for key, rows in clock_parts(run, gone, come).items():
                parts[key] = parts.get(key, 0.0) + rows
        if any(effect.side == "controller" for effect in both) and run.log.shows_servo:
            servo = run.log.sampling(servo_feedback(run.read, machine.physical) - servo_feedback(run.read, run.robot))
            parts |= {("servo", j): servo[..., j] for j in range(run.robot.n_joints)}
        found.append(parts)
    return found


def _exchange(before: Machine, after: Machine) -> tuple[list[Effect], list[Effect]]:
    """Effects that go, and effects that come."""
    gone = [effect for effect in before.effects if effect not in after.effects]
    return gone, [effect for effect in after.effects if effect not in before.effects]


def _push(run: Replay, machine: Machine, known: dict[TorqueEffect, Torques]) -> Push:
    """What the exchange adds to the balance of torques; `known` are those of effects that go, computed once."""
    gone, come = _exchange(run.machine, machine)
    total = Push()
    if any(isinstance(effect, NativeEffect) for effect in (*gone, *come)):
        total = of_numbers(run, machine.physical)
    for sign, effects in ((-1.0, gone), (1.0, come)):
        for effect in effects:
            if isinstance(effect, TorqueEffect):
                if effect not in known:
                    known[effect] = torques_along(effect, run.state, run.log.dt)
                added = known[effect]
                total = Push(
                    motor=_plus(total.motor, added.motor, -sign),
                    links=_plus(total.links, added.link, -sign),
                    spring=_plus(total.spring, added.spring, sign),
                )
    if machine.resolver_effects != run.machine.resolver_effects:
        total = _with_reading(run, machine, total)
    return total


def _with_reading(run: Replay, machine: Machine, total: Push) -> Push:
    """With motors that truly were elsewhere, as another resolver read what was read."""
    drive = run.robot.drive
    angle, speed = run.state.motor_angle, run.state.motor_speed
    was, is_now = run.machine.read_by_resolver(angle, speed), machine.read_by_resolver(angle, speed)
    other = moved(run, drive.joint_angle(was[0] - is_now[0]))
    return Push(
        motor=_plus(total.motor, other.motor, 1.0),
        links=_plus(total.links, other.links, 1.0),
        spring=total.spring,
        joint_q=other.joint_q,
    )


def _plus(total: Array | None, more: Array | None, sign: float) -> Array | None:
    if more is None:
        return total
    return sign * more if total is None else total + sign * more


def tangents(
    run: Replay, before: Machine, hypotheses: Sequence[Hypothesis], known: Mapping[int, Sequence[Parts]] | None = None
) -> list[Parts]:
    """One column per free number of all `hypotheses`, per its practical step.

    Args:
        run: replay of the machine with all hypotheses.
        before: the machine without them.
        hypotheses: in the order in which the machine has them.
        known: columns of some of them, by their places in that order.
    """
    known = known or {}
    machines, steps = [], []
    for i, hypothesis in enumerate(hypotheses):
        for k in range(0 if i in known else len(hypothesis.free())):
            machine, step = _beside(run.machine, len(before.effects) + i, hypothesis, k)
            machines.append(machine)
            steps.append(step)
    parts = iter(zip(exchanged(run, machines), steps, strict=True))
    columns: list[Parts] = []
    for i, hypothesis in enumerate(hypotheses):
        if i in known:
            columns += known[i]
            continue
        for _, (one, step) in zip(hypothesis.free(), parts, strict=False):
            columns.append({key: values / step for key, values in one.items()})
    return columns


def _beside(machine: Machine, place: int, hypothesis: Hypothesis, k: int) -> tuple[Machine, float]:
    """The machine with number `k` of the hypothesis at `place` a bit higher, or lower if need be; and by how much.

    Raises:
        FFGymError: if it can be neither.
    """
    free = hypothesis.free()
    for change in (free[k].nudge, -free[k].nudge):
        changes = [0.0] * len(free)
        changes[k] = change
        if not free[k].low <= free[k].value + changes[k] <= free[k].high:
            continue
        effects = list(machine.effects)
        effects[place] = hypothesis.moved(changes).effect(machine.robot)
        beside = machine_of(machine, effects)
        if beside is not None:
            return beside, change / free[k].step
    raise FFGymError(f"{free[k].name} of {hypothesis.label} = {free[k].value:g} can be neither higher nor lower.")
