"""How predictions change with each number of a fitted hypothesis, about where it is now."""

from collections.abc import Mapping, Sequence

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.fit.hypothesis import Hypothesis, machine_of
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.signatures.exchange import exchanged
from ffgym.diagnosis.signatures.parts import Parts
from ffgym.simulation.plant import Machine


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
