"""How predictions change with each number of a fitted hypothesis, about where it is now."""

from collections.abc import Sequence
from dataclasses import replace

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.signatures.column import Parts
from ffgym.diagnosis.signatures.exchange import exchanged
from ffgym.effects import Effect
from ffgym.plant import Machine

_SHARE = 0.05
"""Of a practical step: the difference quotient's; chosen: small against where effects bend, large against rounding."""


def tangents(run: Replay, before: Machine, hypotheses: Sequence[Hypothesis]) -> list[Parts]:
    """One column per free number of all `hypotheses`, per its practical step.

    Args:
        run: replay of the machine with all hypotheses.
        before: the machine without them.
        hypotheses: in the order in which the machine has them.
    """
    robot = before.robot
    effects = [h.effect(robot) for h in hypotheses]
    machines, signs = [], []
    for i, hypothesis in enumerate(hypotheses):
        for k, free in enumerate(hypothesis.free()):
            inside = free.value + _SHARE * free.step <= free.high
            sign = 1.0 if inside else -1.0
            changes = [0.0] * len(hypothesis.free())
            changes[k] = sign * _SHARE * free.step
            moved = hypothesis.moved(changes).effect(robot)
            machines.append(_with(before, [moved if j == i else e for j, e in enumerate(effects)]))
            signs.append(sign * _SHARE)
    parts = exchanged(replace(run, machine=_with(before, effects)), machines)
    return [{key: values / sign for key, values in one.items()} for one, sign in zip(parts, signs, strict=True)]


def _with(machine: Machine, effects: Sequence[Effect]) -> Machine:
    return Machine(robot=machine.robot, effects=(*machine.effects, *effects), climate=machine.climate)
