"""What changes in a replay if its machine is exchanged for one with other effects, to first order about the replay."""

from collections.abc import Sequence

from ffgym.core.types import Array
from ffgym.diagnosis.replay import Replay, servo_feedback, tracked
from ffgym.diagnosis.signatures.bending import changes
from ffgym.diagnosis.signatures.parts import Parts, clock_parts, replayed_parts, shown
from ffgym.diagnosis.signatures.push import Push, moved, of_numbers
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
